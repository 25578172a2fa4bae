"""A renderer's lookups in Isaac Sim's pair of tables, written from its documents: isaac_peer.py NAME
PIXELS AHEAD. PIXELS.csv has x, y and what raygrid says of each: the direction there. Prints how far
tables lead from the pixels, also with each mistake. Runs under any Python that has cv2."""
import json
import os
import sys

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
import cv2
import numpy as np


def channels(suffix, count):
    """Blue, green and red of OpenCV, the other way around."""
    return cv2.imread(f"{sys.argv[1]}_{suffix}.exr", cv2.IMREAD_UNCHANGED)[..., 2::-1][..., :count]


def sampled(texture, u, v):
    """Bilinear, as graphics processors do: the first texel's centre is half a texel from the edge."""
    height, width, _ = texture.shape
    x, y = (np.clip(part * count - 0.5, 0, count - 1) for part, count in ((u, width), (v, height)))
    i, j = (np.minimum(np.floor(at).astype(int), count - 2) for at, count in ((x, width), (y, height)))
    s, t = (x - i)[:, None], (y - j)[:, None]
    rows = [(1 - s) * texture[j + k, i] + s * texture[j + k, i + 1] for k in (0, 1)]
    return (1 - t) * rows[0] + t * rows[1]


def octahedron(rays):
    """The square that the faces of an octahedron unfold to, from 0 to 1; ahead is in its middle."""
    x, y, z = (rays / np.abs(rays).sum(axis=1, keepdims=True)).T
    if is_ahead:
        z = -z
    away = z < 0
    u = np.where(away, (1 - np.abs(y)) * np.where(x < 0, -1, 1), x)
    v = np.where(away, (1 - np.abs(x)) * np.where(y < 0, -1, 1), y)
    return (u + 1) / 2, (v + 1) / 2


def worst_px(rays, offset=0.0):
    """Of the places that directions in the renderer's axes have, from the pixels."""
    places = sampled(leaving, *octahedron(rays)) * [width, height] - 0.5 + offset
    return float(np.linalg.norm(places - pixels, axis=1).max())


is_ahead = sys.argv[3] == "ahead"
table = np.loadtxt(sys.argv[2], delimiter=",", skiprows=1)
pixels, directions = table[:, :2], table[:, 2:5]
entering, leaving = channels("enter", 3), channels("exit", 2)
height, width, _ = entering.shape
rays = directions * [1, -1, -1]
read = sampled(entering, *((pixels + 0.5) / [width, height]).T)
whole = np.all(pixels == np.floor(pixels), axis=1)
difference = np.linalg.norm(read / np.linalg.norm(read, axis=1, keepdims=True) - rays, axis=1)
print(json.dumps({
    "enter_size": [width, height], "exit_size": list(leaving.shape[1::-1]),
    "enter_types": [str(entering.dtype), str(leaving.dtype)],
    "whole_pixels": int(whole.sum()), "worst_rad": float(difference[whole].max()),
    "between_rad": float(difference.max()),
    "exit_px": worst_px(rays), "both_px": worst_px(read),
    "mistakes": {"half a pixel": worst_px(rays, 0.5), "y": worst_px(rays * [1, -1, 1]),
                 "z": worst_px(rays * [1, 1, -1]), "y and z": worst_px(directions),
                 "x": worst_px(rays * [-1, 1, 1])},
    "none": {"enter": int((entering == [0, 0, 1]).all(axis=2).sum()),
             "exit_inside": int(((leaving >= 0) & (leaving <= 1)).all(axis=2).sum()),
             "exit": int((np.isin(leaving, (-1, 2))).all(axis=2).sum())}}))
