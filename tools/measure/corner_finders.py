"""Corners of a folder of photographs by OpenCV: corner_finders.py PHOTOGRAPHS KIND PATTERN.yaml FEATURES.csv
KIND: sub-pix-N, cornerSubPix with a window of 2 N + 1 pixels; sector, findChessboardCornersSB; aruco, ChArUco."""
import csv
import os
import sys

import cv2
import numpy as np

import datasets

SUB_PIX_CRITERIA = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 100, 1e-4)


def find_chessboard(image, kind, size):
    if kind == "sector":
        flags = cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
        found, corners = cv2.findChessboardCornersSB(image, size, flags=flags)
    else:
        found, corners = cv2.findChessboardCorners(image, size)
        if found:
            half = int(kind.rsplit("-", 1)[1])
            corners = cv2.cornerSubPix(image, corners, (half, half), (-1, -1), SUB_PIX_CRITERIA)
    return (range(len(corners)), corners) if found else ((), ())


def charuco_finder(path, size, square_m):
    marker_m, name = (datasets.read_value(path, key) for key in ("marker_m", "dictionary"))
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
    board = cv2.aruco.CharucoBoard_create(size[0] + 1, size[1] + 1, square_m, float(marker_m), dictionary)

    def find(image):
        markers, ids, _ = cv2.aruco.detectMarkers(image, dictionary)
        if ids is None:
            return (), ()
        count, corners, places = cv2.aruco.interpolateCornersCharuco(markers, ids, image, board)
        return (places.ravel(), corners) if count else ((), ())
    return find


def main(photographs, kind, pattern, path):
    columns, rows, square_m = datasets.read_board(pattern)
    find = charuco_finder(pattern, (columns, rows), square_m) if kind == "aruco" else (
        lambda image: find_chessboard(image, kind, (columns, rows)))
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["image", "board", "column", "row", "x", "y"])
        for name in sorted(os.listdir(photographs)):
            image = cv2.imread(os.path.join(photographs, name), cv2.IMREAD_GRAYSCALE)
            if image is None:
                continue
            places, corners = find(image)
            for place, (x, y) in zip(places, np.reshape(corners, (-1, 2))):
                writer.writerow([name, 0, place % columns, place // columns, f"{x:.5f}", f"{y:.5f}"])


if __name__ == "__main__":
    main(*sys.argv[1:])
