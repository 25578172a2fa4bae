"""Uses the runtime's wheel where it is installed: the golden frame and rays, by both of its names.

    use_runtime.py FOLDER    with what tests/micropython/write_golden.py wrote
"""
import json
import sys
import zlib
from pathlib import Path

import raygrid
import raygrid_runtime


def main():
    folder = Path(sys.argv[1])
    expected = json.loads((folder / "expected.json").read_text(encoding="utf-8"))
    blob = raygrid.Blob(folder / "lens.raygrid")
    flat = blob.undistort((folder / "frame").read_bytes(),
                          border_values=(expected["border"],))
    print(f"Python {sys.version_info[0]}.{sys.version_info[1]}: remap CRC {zlib.crc32(flat):08x}")
    assert zlib.crc32(flat) == expected["crc"]
    camera = raygrid_runtime.Camera((folder / "lens.raygrid").read_bytes())
    for ray, wanted in zip(camera.unproject(expected["pixels"]), expected["rays"]):
        assert all(abs(a - b) < 1e-7 for a, b in zip(ray, wanted)), (ray, wanted)
    assert raygrid.Blob is raygrid_runtime.Camera
    assert "runtime for devices" in raygrid.__doc__
    try:
        raygrid.Blob(b"no blob")
    except raygrid.Error as error:
        print(f"refused: {error}")
    else:
        raise AssertionError("no blob is taken for one")


main()
