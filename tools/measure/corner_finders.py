"""Corners of a folder of chessboard photographs by OpenCV: corner_finders.py PHOTOGRAPHS KIND FEATURES.csv
KIND: sub-pix-N, cornerSubPix with a window of 2 N + 1 pixels; sector, findChessboardCornersSB."""
import csv
import os
import sys

import cv2

SIZE = 9, 6
SUB_PIX_CRITERIA = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 100, 1e-4)


def find(image, kind):
    if kind == "sector":
        flags = cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
        found, corners = cv2.findChessboardCornersSB(image, SIZE, flags=flags)
        return corners if found else None
    found, corners = cv2.findChessboardCorners(image, SIZE)
    half = int(kind.rsplit("-", 1)[1])
    return cv2.cornerSubPix(image, corners, (half, half), (-1, -1), SUB_PIX_CRITERIA) if found else None


def main(photographs, kind, path):
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["image", "board", "column", "row", "x", "y"])
        for name in sorted(os.listdir(photographs)):
            corners = find(cv2.imread(os.path.join(photographs, name), cv2.IMREAD_GRAYSCALE), kind)
            if corners is None:
                continue
            for i, (x, y) in enumerate(corners.reshape(-1, 2)):
                writer.writerow([name, 0, i % SIZE[0], i // SIZE[0], f"{x:.5f}", f"{y:.5f}"])


if __name__ == "__main__":
    main(*sys.argv[1:])
