#!/usr/bin/env python3
"""Compares raygrid hand-eye with OpenCV's hand-eye methods on simulated robots.

    tools/measure/hand_eye.py RAYGRID [--robots 200] [--eye-to-hand] [--wrong-poses 1] [-o table.csv]

Each robot has its own camera (640 to 1920 px wide, 45° to 75°), target, mount, 15 to 25 poses, and noise: 0.1 to 0.5 mm
and 0.02° to 0.1° per axis of its poses, 0.05 to 0.3 px of the features. The target is 30 % to 60 % as wide as the image, and tilted
by up to 45°. All methods get the poses of the target from raygrid localize. Errors are those of
gripper_from_camera (base_from_camera with --eye-to-hand), RMS over the robots. Needs numpy and OpenCV.
"""
import argparse
import csv
import json
import subprocess
import tempfile
from pathlib import Path

import cv2
import numpy as np

SIZES = ((640, 480), (1280, 960), (1920, 1200))
TARGETS = ((9, 6, 0.025), (11, 8, 0.02), (14, 9, 0.03))  # columns, rows, squares in metres
METHODS = {"Tsai": cv2.CALIB_HAND_EYE_TSAI, "Park": cv2.CALIB_HAND_EYE_PARK, "Horaud": cv2.CALIB_HAND_EYE_HORAUD,
           "Andreff": cv2.CALIB_HAND_EYE_ANDREFF, "Daniilidis": cv2.CALIB_HAND_EYE_DANIILIDIS}
WORLD_METHODS = {"Shah": cv2.CALIB_ROBOT_WORLD_HAND_EYE_SHAH, "Li": cv2.CALIB_ROBOT_WORLD_HAND_EYE_LI}


def rotation(vector):
    return cv2.Rodrigues(np.asarray(vector, float))[0]


def vector_of(matrix):
    return cv2.Rodrigues(matrix)[0].ravel()


def pose(matrix, translation):
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = matrix, translation
    return result


def quaternion(matrix):
    """x, y, z, w."""
    vector = vector_of(matrix)
    angle = np.linalg.norm(vector)
    return [*(vector / angle * np.sin(angle / 2) if angle > 0 else vector), np.cos(angle / 2)]


class Robot:
    """A simulated robot: its truth, its noisy poses and the features of its images."""

    def __init__(self, seed, eye_to_hand):
        self.random = random = np.random.default_rng(seed)
        self.sigma_m, self.sigma_deg = random.uniform(1e-4, 5e-4), random.uniform(0.02, 0.1)
        self.sigma_px = random.uniform(0.05, 0.3)
        self.size = np.array(SIZES[random.integers(len(SIZES))])
        self.focal = self.size[0] / 2 / np.tan(np.radians(random.uniform(45, 75)) / 2)
        self.columns, rows, square = TARGETS[random.integers(len(TARGETS))]
        self.pattern = f"chessboard:{self.columns}x{rows}:{square * 1000:g}mm"
        self.center = np.array([(self.columns - 1) / 2, (rows - 1) / 2, 0]) * square
        self.points = np.array([[c, r, 0] for r in range(rows) for c in range(self.columns)], float) * square
        # What carries the camera, and what carries the target.
        length = 0.8 if eye_to_hand else 0.1
        self.camera_from_mount = pose(rotation(random.uniform(-1.5, 1.5, 3)), random.uniform(-length, length, 3))
        self.anchor_from_target = pose(rotation(random.uniform(-1.5, 1.5, 3)),
                                       random.uniform(-0.1, 0.1, 3) if eye_to_hand else random.uniform(-0.8, 0.8, 3))
        self.camera_from_target, self.base_from_gripper, self.pixels = [], [], []
        count = int(random.integers(15, 26))
        while len(self.pixels) < count:
            self.add_view(eye_to_hand)

    def add_view(self, eye_to_hand):
        random = self.random
        matrix = rotation([*random.uniform(-0.56, 0.56, 2), 0]) @ rotation([0, 0, random.uniform(-1, 1)])
        distance = 2 * self.center[0] * self.focal / (random.uniform(0.3, 0.6) * self.size[0])
        shift = random.uniform(-0.25, 0.25, 2) * self.size / self.focal * distance
        camera = pose(matrix, np.array([*shift, distance]) - matrix @ self.center)
        points = self.points @ camera[:3, :3].T + camera[:3, 3]
        pixels = points[:, :2] / points[:, 2:] * self.focal + (self.size - 1) / 2
        if pixels.min() < 0 or (pixels > self.size - 1).any():
            return
        robot = np.linalg.inv(self.camera_from_mount) @ camera @ np.linalg.inv(self.anchor_from_target)
        robot = robot if eye_to_hand else np.linalg.inv(robot)
        noisy = pose(rotation(random.normal(0, np.radians(self.sigma_deg), 3)) @ robot[:3, :3],
                     robot[:3, 3] + random.normal(0, self.sigma_m, 3))
        self.base_from_gripper.append(noisy)
        self.pixels.append(pixels + random.normal(0, self.sigma_px, pixels.shape))

    def write(self, folder):
        with open(folder / "features.csv", "w", encoding="utf-8") as file:
            file.write("image,board,column,row,x,y\n")
            for k, pixels in enumerate(self.pixels):
                for i, (x, y) in enumerate(pixels):
                    file.write(f"im{k:02d}.png,0,{i % self.columns},{i // self.columns},{x:.6f},{y:.6f}\n")
        with open(folder / "robot.txt", "w", encoding="utf-8") as file:
            for k, robot in enumerate(self.base_from_gripper):
                numbers = [*robot[:3, 3], *quaternion(robot[:3, :3])]
                file.write(f"im{k:02d}.png " + " ".join(f"{value:.9f}" for value in numbers) + "\n")
        (folder / "camera.yaml").write_text(
            f"model: opencv\nimage_size: [{self.size[0]}, {self.size[1]}]\narea: [0, 0, {self.size[0] - 1}, {self.size[1] - 1}]\n"
            f"parameters: {{fx: {self.focal}, fy: {self.focal}, cx: {(self.size[0] - 1) / 2}, cy: {(self.size[1] - 1) / 2}, k1: 0, k2: 0, "
            "k3: 0, k4: 0, k5: 0, k6: 0, p1: 0, p2: 0}\nraygrid_camera: 1\n", encoding="utf-8")


def read_poses(path):
    poses = {}
    with open(path, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            w, x, y, z = (float(row[key]) for key in ("qw", "qx", "qy", "qz"))
            matrix = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                               [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                               [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
            poses[row["image"]] = pose(matrix, [float(row[key]) for key in ("tx", "ty", "tz")])
    return poses


def split(poses):
    return [p[:3, :3] for p in poses], [p[:3, 3] for p in poses]


def opencv_estimates(mount_from_anchor, camera_from_target):
    """mount_from_camera by each method."""
    anchor_from_mount = [np.linalg.inv(p) for p in mount_from_anchor]
    estimates = {}
    for name, method in METHODS.items():
        matrix, translation = cv2.calibrateHandEye(*split(anchor_from_mount), *split(camera_from_target), method=method)
        estimates[name] = pose(matrix, translation.ravel())
    for name, method in WORLD_METHODS.items():
        *_, matrix, translation = cv2.calibrateRobotWorldHandEye(*split(camera_from_target), *split(mount_from_anchor),
                                                                 method=method)
        estimates[name] = np.linalg.inv(pose(matrix, translation.ravel()))
    return estimates


def raygrid_estimate(raygrid, folder, options):
    subprocess.run([raygrid, "hand-eye", folder / "poses", "--robot", folder / "robot.txt", "-o", folder / "out", "--json",
                    *options], check=True, stdout=open(folder / "out.json", "w", encoding="utf-8"))
    result = json.loads((folder / "out.json").read_text(encoding="utf-8"))
    found = result["transforms"][1]
    q, t = found["rotation"], found["translation"]
    axis = np.array([q["x"], q["y"], q["z"]])
    length = np.linalg.norm(axis)
    matrix = rotation(axis / max(length, 1e-30) * 2 * np.arctan2(length, q["w"]))
    return pose(matrix, [t["x"], t["y"], t["z"]]), np.array(found["covariance"]), result


def error_of(estimate, truth):
    return np.array([*vector_of(truth[:3, :3] @ estimate[:3, :3].T), *(truth[:3, 3] - estimate[:3, 3])])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("raygrid")
    parser.add_argument("--robots", type=int, default=200)
    parser.add_argument("--eye-to-hand", action="store_true")
    parser.add_argument("--stated", action="store_true", help="state the robot's accuracy instead of estimating it")
    parser.add_argument("--wrong-poses", type=int, default=0, help="poses of each robot that are off by 5 mm")
    parser.add_argument("-o", "--output", help="CSV file of the table")
    arguments = parser.parse_args()
    errors, squared, ratios, sigmas, rejected = {}, [], [], [], 0
    for seed in range(arguments.robots):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            robot = Robot(seed, arguments.eye_to_hand)
            for k in range(arguments.wrong_poses):
                robot.base_from_gripper[k][:3, 3] += 0.005 * robot.random.choice([-1, 1], 3) / np.sqrt(3)
            robot.write(folder)
            subprocess.run([arguments.raygrid, "localize", folder / "camera.yaml", "--features", folder / "features.csv",
                            "--pattern", robot.pattern, "-o", folder / "poses", "--quiet"], check=True)
            poses = read_poses(folder / "poses" / "poses.csv")
            camera = [poses[f"im{k:02d}.png"] for k in range(len(robot.pixels))]
            options = ["--eye-to-hand"] if arguments.eye_to_hand else []
            if arguments.stated:
                options += ["--robot-sigma-mm", str(1000 * robot.sigma_m), "--robot-sigma-deg", str(robot.sigma_deg)]
            estimate, covariance, result = raygrid_estimate(arguments.raygrid, folder, options)
        mounts = [p if arguments.eye_to_hand else np.linalg.inv(p) for p in robot.base_from_gripper]
        truth = np.linalg.inv(robot.camera_from_mount)
        estimates = {"raygrid": estimate, **opencv_estimates(mounts, camera)}
        for method, found in estimates.items():
            errors.setdefault(method, []).append(error_of(found, truth))
        error = errors["raygrid"][-1]
        squared.append(error @ np.linalg.solve(covariance, error) / 6)
        ratios.append(error / np.sqrt(np.diag(covariance)))
        sigmas.append([result["robot_sigma_m"] / robot.sigma_m,
                       np.degrees(result["robot_sigma_rad"]) / robot.sigma_deg])
        rejected += len(result["rejected_images"])
    rows = []
    for method, values in errors.items():
        values = np.array(values)
        turns, shifts = np.linalg.norm(values[:, :3], axis=1), np.linalg.norm(values[:, 3:], axis=1)
        rows.append([method, np.degrees(np.sqrt(np.mean(turns**2))), 1000 * np.sqrt(np.mean(shifts**2)),
                     np.degrees(np.median(turns)), 1000 * np.median(shifts)])
    best = np.min(np.array([row[1:] for row in rows[1:]]), axis=0)
    print(f"{'method':12} {'rms_deg':>9} {'rms_mm':>9} {'median_deg':>11} {'median_mm':>10}")
    for row in rows:
        print(f"{row[0]:12} {row[1]:9.4f} {row[2]:9.4f} {row[3]:11.4f} {row[4]:10.4f}")
    print("raygrid / best of OpenCV:", " ".join(f"{value:.3f}" for value in np.array(rows[0][1:]) / best))
    print(f"squared error / stated variance: {np.mean(squared):.3f} (6 axes jointly);",
          "per axis", " ".join(f"{value:.2f}" for value in np.mean(np.array(ratios)**2, axis=0)))
    print("estimated / true robot sigma: {:.3f} (mm), {:.3f} (deg)".format(*np.mean(sigmas, axis=0)),
          f"; rejected poses: {rejected}")
    if arguments.output:
        with open(arguments.output, "w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["method", "rms_deg", "rms_mm", "median_deg", "median_mm"])
            writer.writerows([row[0], *(f"{value:.5g}" for value in row[1:])] for row in rows)


if __name__ == "__main__":
    main()
