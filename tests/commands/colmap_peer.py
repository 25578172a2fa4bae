"""COLMAP projects points with cameras of its own folders: colmap_peer.py POINTS.csv FOLDER..., a
line "u,v" for each "x,y,z", each camera and each folder. Runs under a Python that has pycolmap."""
import sys

import numpy as np
import pycolmap

with open(sys.argv[1], encoding="ascii") as file:
    points = np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)
for folder in sys.argv[2:]:
    model = pycolmap.Reconstruction()
    model.read(folder)
    for number in sorted(model.cameras):
        pixels = model.cameras[number].img_from_cam(points)
        print("\n".join(f"{u:.9f},{v:.9f}" for u, v in pixels))
