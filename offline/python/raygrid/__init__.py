"""raygrid for the host: cameras, views, detection, calibration and blobs, with numpy in and out.

    import raygrid
    camera = raygrid.Camera.load("result/camera.yaml")
    pixels = camera.project([[0.1, 0.2, 1.0]])
    directions = camera.unproject(pixels)

Pixels are (x, y), and (0, 0) is the centre of the top-left pixel. Camera axes are x right, y down,
z forward. Lengths are metres. Answers are NaN where a camera sees nothing.
"""
from . import importers
from ._blob import Blob, BlobError
from ._raygrid import (Calibration, Camera, Detection, Error, View, calibrate, detect,
                       load_features, save_features)
from ._rig import Rig

__all__ = ["Blob", "BlobError", "Calibration", "Camera", "Detection", "Error", "Rig", "View",
           "calibrate", "detect", "importers", "load_features", "save_features"]
