"""mrcal projects points with its .cameramodel files: mrcal_peer.py POINTS.csv FILE..., a line "u,v"
for each "x,y,z" in the reference frame and each file. Runs under a Python that has mrcal."""
import sys

import mrcal
import numpy as np

with open(sys.argv[1], encoding="ascii") as file:
    points = np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)
for path in sys.argv[2:]:
    model = mrcal.cameramodel(path)
    turned = mrcal.transform_point_rt(model.extrinsics_rt_fromref(), points)
    print("\n".join(f"{u:.9f},{v:.9f}" for u, v in mrcal.project(turned, *model.intrinsics())))
