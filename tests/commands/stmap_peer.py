"""OpenCV saves an STMap again in many ways: stmap_peer.py STMAP.exr. The ways of map.exr are
map_moved.exr and so on. Runs under any Python that has cv2."""
import os
import sys

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
import cv2
import numpy as np


def save(way, channels):
    assert cv2.imwrite(f"{os.path.splitext(sys.argv[1])[0]}_{way}.exr", np.float32(channels))


stmap = cv2.imread(sys.argv[1], cv2.IMREAD_UNCHANGED)
width = stmap.shape[1]
seen = stmap[:, :, 3:] > 0
left = np.arange(width)[None, :, None] < width / 2
save("moved", stmap + np.float32([0, 0, 0.5 / width, 0]) * seen)
# OpenCV saves no alpha of an image of three channels.
save("nan", np.where(seen & left, stmap[:, :, :3], np.nan))
save("black", np.where(seen, stmap * np.float32([1, 1, 1, 0]), 0))
save("flipped", np.where(seen, stmap * np.float32([1, -1, 1, 1]) + np.float32([0, 1, 0, 0]), -1))
