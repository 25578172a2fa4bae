"""Projects points as the programs do that files of keys are of, by their documentation:
keyed_peer.py FORMAT FILE POINTS.csv CAMERA, a line "u,v" for each "x,y,z" of the rig, or of the
camera alone. Runs under a Python that has cv2, yaml and tomllib."""
import json
import sys

import cv2
import numpy as np
import tomllib
import yaml

IDENTITY = (np.eye(3), np.zeros(3))


def storage(path):
    return cv2.FileStorage(path, cv2.FILE_STORAGE_READ)


def reals(node):
    return [node.at(k).real() for k in range(node.size())]


def pinhole(k, d, points):
    return cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.array(k, float).reshape(3, 3),
                             np.array(d, float))[0]


def fisheye(k, d, points):
    return cv2.fisheye.projectPoints(points, np.zeros(3), np.zeros(3),
                                     np.array(k, float).reshape(3, 3), np.array(d, float))[0]


def matrix(fx, fy, cx, cy):
    return [fx, 0, cx, 0, fy, cy, 0, 0, 1]


def inverse(rows):
    """camera_from_rig of a matrix rig_from_camera of 16 numbers."""
    pose = np.linalg.inv(np.array(rows, float).reshape(4, 4))
    return pose[:3, :3], pose[:3, 3]


def gyroflow(path, _):
    profile = json.load(open(path, encoding="utf8"))
    lens = profile["fisheye_params"]
    kind = fisheye if profile["distortion_model"] == "opencv_fisheye" else pinhole
    return kind, lens["camera_matrix"], lens["distortion_coeffs"], IDENTITY


def orbslam(path, _):
    file = storage(path)
    value = lambda key: file.getNode("Camera." + key).real()
    # ORB-SLAM3 stops at a number that is an integer.
    assert all(file.getNode("Camera." + key).isReal() for key in ("fx", "fy", "cx", "cy", "k1"))
    k = matrix(*map(value, ("fx", "fy", "cx", "cy")))
    if file.getNode("Camera.type").string() == "KannalaBrandt8":
        return fisheye, k, list(map(value, ("k1", "k2", "k3", "k4"))), IDENTITY
    return pinhole, k, list(map(value, ("k1", "k2", "p1", "p2", "k3"))), IDENTITY


def camodocal(path, _):
    file = storage(path)
    value = lambda name: lambda key: file.getNode(name + "_parameters").getNode(key).real()
    model = file.getNode("model_type").string()
    lens, bend = value("projection"), value("distortion")
    if model == "KANNALA_BRANDT":
        return (fisheye, matrix(*map(lens, ("mu", "mv", "u0", "v0"))),
                list(map(lens, ("k2", "k3", "k4", "k5"))), IDENTITY)
    keys = ("k1", "k2", "p1", "p2") + (("k3", "k4", "k5", "k6") if model == "PINHOLE_FULL" else ())
    return pinhole, matrix(*map(lens, ("fx", "fy", "cx", "cy"))), list(map(bend, keys)), IDENTITY


def euroc(path, _):
    sensor = yaml.safe_load(open(path, encoding="utf8"))
    assert sensor["sensor_type"] == "camera" and sensor["T_BS"]["rows"] == 4
    kind = fisheye if sensor["distortion_model"] == "equidistant" else pinhole
    return (kind, matrix(*sensor["intrinsics"]), sensor["distortion_coefficients"],
            inverse(sensor["T_BS"]["data"]))


def anipose(path, camera):
    tables = tomllib.load(open(path, "rb"))
    lens = next(table for table in tables.values() if table["name"] == camera)
    kind = fisheye if lens["fisheye"] else pinhole
    pose = (cv2.Rodrigues(np.array(lens["rotation"]))[0], np.array(lens["translation"]))
    return kind, lens["matrix"], lens["distortions"], pose


def okvis(path, camera):
    file = storage(path)  # its nodes live as long as it
    node = file.getNode("cameras").at(int(camera[-1]))
    kind = fisheye if node.getNode("distortion_type").string() == "equidistant" else pinhole
    k = matrix(*reals(node.getNode("focal_length")), *reals(node.getNode("principal_point")))
    return (kind, k, reals(node.getNode("distortion_coefficients")),
            inverse(reals(node.getNode("T_SC"))))


def opensfm(path, camera):
    lens = json.load(open(path, encoding="utf8"))[camera]
    side = max(lens["width"], lens["height"])
    k = matrix(lens["focal_x"] * side, lens["focal_y"] * side,
               lens["c_x"] * side + (lens["width"] - 1) / 2,
               lens["c_y"] * side + (lens["height"] - 1) / 2)
    if lens["projection_type"] == "fisheye_opencv":
        return fisheye, k, [lens[key] for key in ("k1", "k2", "k3", "k4")], IDENTITY
    return pinhole, k, [lens.get(key, 0) for key in ("k1", "k2", "p1", "p2", "k3")], IDENTITY


def kitti(path, camera):
    lines = dict(line.strip().split(": ", 1) for line in open(path, encoding="utf8"))
    numbers = lambda key: np.array(lines[f"{key}_0{camera[-1]}"].split(), float)
    return (pinhole, numbers("K"), numbers("D"), (numbers("R").reshape(3, 3), numbers("T")))


name, file_name, points_name, camera_name = sys.argv[1:]
xyz = np.array([line.split(",") for line in open(points_name, encoding="utf8").read().split()[1:]],
               float)
project, k_matrix, coefficients, (rotation, translation) = globals()[name.replace("-", "_")](
    file_name, camera_name)
pixels = project(k_matrix, coefficients, (xyz @ rotation.T + translation).reshape(-1, 1, 3))
print("\n".join(f"{u:.9f},{v:.9f}" for u, v in pixels.reshape(-1, 2)))
