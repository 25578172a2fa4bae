"""Numpy saves a table of rays again as other programs may, well or badly: rays_peer.py RAYS FOLDER,
FOLDER/WAY.npz for each way. Prints types and shapes, and the first row's directions."""
import json
import sys

import numpy as np

rays = dict(np.load(sys.argv[1]))
directions = rays["directions"]
height, width, _ = directions.shape
y, x = np.mgrid[-1:1:height * 1j, -1:1:width * 1j]
circle = directions.copy()
circle[x * x + y * y > 1] = np.nan
for name, arrays in {
        "circle": {**rays, "directions": circle},
        "moved": {**rays, "x": rays["x"] + 0.5, "image_size": rays["image_size"] + 1},
        "y_up": {**rays, "directions": directions * [1, -1, 1]},
        "opengl": {**rays, "directions": directions * [1, -1, -1]},
        "fortran": {"directions": np.asfortranarray(directions)},
        "big_endian": {"directions": directions.astype(">f8")},
        "none": {"directions": directions * np.nan},
        "flat": {"directions": directions.reshape(-1, 3)},
        "two": {"directions": directions[..., :2]},
        "other_name": {"rays": directions},
        "places": {**rays, "x": rays["x"][::-1]},
        "few_places": {**rays, "y": rays["y"][1:]},
        "small": {**rays, "image_size": np.array([8, 8])},
        "huge": {**rays, "image_size": np.array([2 ** 40, 2 ** 40])},
        "objects": {"directions": np.array([{}, {}], dtype=object)}}.items():
    np.savez(f"{sys.argv[2]}/{name}.npz", **arrays)
np.savez_compressed(f"{sys.argv[2]}/plain.npz", directions=3 * directions.astype(np.float32))
told = {name: [str(values.dtype), list(values.shape)] for name, values in rays.items()}
told["directions_of_first_row"] = directions[0].tolist()
print(json.dumps(told))
