"""mrcal projects points with its .cameramodel files: mrcal_peer.py POINTS.csv FILE..., a line "u,v"
for each "x,y,z" in the reference frame and each file. With "region" before these, pixels "x,y" are in
the file's valid_intrinsics_region, 1 or 0. Runs under a Python that has mrcal."""
import sys
import warnings

import mrcal
import numpy as np

warnings.simplefilter("error")  # mrcal warns of a region that it does not take
if sys.argv[1] == "region":
    with open(sys.argv[2], encoding="ascii") as file:
        pixels = np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)
    for path in sys.argv[3:]:
        model = mrcal.cameramodel(path)
        inside = mrcal.is_within_valid_intrinsics_region(pixels, model)
        print("\n".join(str(int(is_inside)) for is_inside in inside))
    sys.exit()
with open(sys.argv[1], encoding="ascii") as file:
    points = np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)
for path in sys.argv[2:]:
    model = mrcal.cameramodel(path)
    turned = mrcal.transform_point_rt(model.extrinsics_rt_fromref(), points)
    print("\n".join(f"{u:.9f},{v:.9f}" for u, v in mrcal.project(turned, *model.intrinsics())))
