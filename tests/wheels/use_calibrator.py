"""Uses the calibrator's wheel as a notebook does: detects, calibrates, packs, undistorts.

    use_calibrator.py PHOTOGRAPHS FOLDER    writes FOLDER/package, and FOLDER/front.raygrid
"""
import sys
from pathlib import Path

import numpy as np
import raygrid

BOARD = "chessboard:9x6:25mm"


def main():
    photographs, folder = map(Path, sys.argv[1:])
    paths = sorted(photographs.glob("left*.jpg"))
    assert len(raygrid.detect(paths[0], BOARD).pixels) == 54
    result = raygrid.calibrate([photographs], BOARD)
    result.save(folder / "package")
    camera = raygrid.Camera.load(folder / "package/camera.yaml")
    packed = camera.pack([camera.view(hfov=60)])
    (folder / "front.raygrid").write_bytes(packed)
    blob = raygrid.Blob(packed)
    width, height = blob.frame_size()
    flat = blob.undistort(np.full((height, width), 77, np.uint8))
    assert flat.shape[::-1] == blob.remap_size() and (flat == 77).mean() > 0.9
    places = np.array([[320.0, 240.0]])
    assert np.allclose(camera.unproject(places), blob.unproject(places), atol=1e-5)
    print(f"Python {sys.version_info[0]}.{sys.version_info[1]}: {len(paths)} photographs, "
          f"{result.verdict}, a blob of {len(packed)} bytes")


main()
