"""OpenCV remaps an image with maps of raygrid's: maps_peer.py IMAGE UNDISTORTED MAPS...
Prints what each file of maps holds, and how far the remapped image is from the undistorted one, also
if the maps are moved by half a pixel. Runs under any Python that has cv2."""
import json
import os
import sys

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
import cv2
import numpy as np

COLUMNS, ROWS = slice(None, None, 2), slice(None, None, 3)


def maps_of_stmap(path):
    """Parts of width and height from the lower left corner, as pixels; -1 where alpha is 0."""
    blue, t, s, alpha = cv2.split(cv2.imread(path, cv2.IMREAD_UNCHANGED))
    assert not blue.any() and set(np.unique(alpha)) <= {0, 1}
    height, width = image.shape
    places = (s.astype(float) * width - 0.5, (1 - t.astype(float)) * height - 0.5)
    return {"map1": np.where(alpha, places[0], -1).astype(np.float32),
            "map2": np.where(alpha, places[1], -1).astype(np.float32), "source_size": []}


def read_maps(path):
    if path.endswith(".exr"):
        return maps_of_stmap(path)
    if path.endswith(".npz"):
        return dict(np.load(path))
    storage = cv2.FileStorage(path, cv2.FILE_STORAGE_READ)
    return {name: storage.getNode(name).mat() for name in ("map1", "map2", "source_size", "K")}


def difference(map1, map2):
    """Of pixels that both images see: largest and RMS; the part of pixels that one of them sees."""
    picture = cv2.remap(image, map1, map2, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    seen = (picture > 0) & (undistorted > 0)
    errors = (picture.astype(float) - undistorted)[seen]
    return {"max": float(np.abs(errors).max()), "rms": float(np.sqrt((errors ** 2).mean())),
            "seen_by_one": float(((picture > 0) != (undistorted > 0)).mean())}


image, undistorted = (cv2.imread(path, cv2.IMREAD_UNCHANGED) for path in sys.argv[1:3])
told = []
for file in sys.argv[3:]:
    maps = read_maps(file)
    first, second = maps["map1"], maps["map2"]
    is_fixed = first.dtype == np.int16
    x, y = cv2.convertMaps(first, second, cv2.CV_32FC1) if is_fixed else (first, second)
    told.append({
        "types": [str(first.dtype), str(second.dtype)],
        "shapes": [list(first.shape), list(second.shape)],
        "source_size": np.ravel(maps["source_size"]).tolist(),
        "K": None if maps.get("K") is None else maps["K"].tolist(),
        "unseen": float(((x == -1) & (y == -1)).mean()),
        "x": x[ROWS, COLUMNS].astype(float).ravel().tolist(),
        "y": y[ROWS, COLUMNS].astype(float).ravel().tolist(),
        "difference": difference(first, second),
        "moved": difference(x + np.float32(0.5), y)})
print(json.dumps(told))
