"""Camera calibration with raygrid: detection, calibration, cameras, undistortion and blobs.

Example::

    import raygrid
    camera = raygrid.Camera.load("result/camera.yaml")
    pixels = camera.project([[0.1, 0.2, 1.0]])
    directions = camera.unproject(pixels)

Arrays are numpy's. Pixels are (x, y), and (0, 0) is the centre of the top-left pixel. Camera axes
are x right, y down, z forward. Lengths are metres; angles are radians, but degrees in names and
arguments that say so. Results are NaN outside the calibrated area and for points that are not
visible. Errors raise Error, of blobs BlobError; invalid arguments ValueError or TypeError.
"""
from . import importers
from ._blob import Blob, BlobError
from ._raygrid import (Calibration, Camera, Detection, Error, View, calibrate, detect,
                       load_features, save_features)
from ._rig import Rig

__all__ = ["Blob", "BlobError", "Calibration", "Camera", "Detection", "Error", "Rig", "View",
           "calibrate", "detect", "importers", "load_features", "save_features"]
