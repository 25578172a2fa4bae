"""OpenCV projects points with cameras of its own files: opencv_peer.py POINTS.csv FILE..., a line
"u,v" for each "x,y,z" and each file. Runs under any Python that has cv2."""
import sys

import cv2
import numpy as np

with open(sys.argv[1], encoding="ascii") as file:
    numbers = file.read().split("\n", 1)[1].replace("\n", ",").rstrip(",")
points = np.fromstring(numbers, sep=",").reshape(-1, 1, 3)
for path in sys.argv[2:]:
    storage = cv2.FileStorage(path, cv2.FILE_STORAGE_READ)
    matrix = storage.getNode("camera_matrix").mat()
    distortion = storage.getNode("distortion_coefficients").mat()
    turn = storage.getNode("raygrid_fit").getNode("lens_from_camera_wxyz").mat()
    rotation = np.zeros(3)
    if turn is not None:
        w, *axis = turn.ravel()
        rotation = 2 * np.arctan2(np.linalg.norm(axis), w) * np.array(axis) / max(
            np.linalg.norm(axis), 1e-300)
    if storage.getNode("fisheye_model").real() == 1:
        pixels = cv2.fisheye.projectPoints(points, rotation, np.zeros(3), matrix, distortion)[0]
    else:
        pixels = cv2.projectPoints(points, rotation, np.zeros(3), matrix, distortion)[0]
    print("\n".join(f"{u:.9f},{v:.9f}" for u, v in pixels.reshape(-1, 2)))
