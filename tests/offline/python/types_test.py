#!/usr/bin/env python3
"""The host's Python package has the types that it says: by mypy, and by its stubtest.

    types_test.py FOLDER      the folder that the package is in
"""
import os
import subprocess
import sys
import tempfile

DEBIAN_PYTHON = "/usr/bin/python3"
# What users write; a wrong use is to be found.
RIGHT = """import numpy as np
import raygrid
camera = raygrid.Camera.load("camera.yaml")
pixels, jacobians = camera.project(np.zeros((3, 3)), jacobians=True)
deviation: float = float(camera.uncertainty(pixels)[0])
map1, map2 = camera.maps(camera.view(hfov=60))
found = raygrid.detect(np.zeros((9, 9), np.uint8), "chessboard:9x6:25mm")
result = raygrid.calibrate({"left": [found], "right": [found]}, "pattern.yaml",
                           progress=lambda stage, done, left: print(stage, done, left))
raygrid.Rig.of(result).save("rig.yaml")
frame = raygrid.Blob(camera.pack()).undistort(np.zeros((9, 9), np.uint8))
"""
WRONG = ("raygrid.Camera.load(3)", "raygrid.Blob('a').unproject()",
         "raygrid.importers.save('camera.yaml', 'a', 'ros')",
         "a, b = raygrid.Camera.load('a').project([[0, 0, 1]], jacobians=False).shape.x")


def run(folder, *command):
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder,
                          env={**os.environ, "MYPYPATH": folder, "PYTHONPATH": folder})


def check_uses(package):
    """What is right passes strictly, and what is wrong is found, line by line."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [os.path.join(folder, name) for name in ("right.py", "wrong.py")]
        for path, text in zip(paths, (RIGHT, "import raygrid\n" + "\n".join(WRONG) + "\n")):
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        done = run(package, "mypy", "--cache-dir", os.devnull, "--python-executable",
                   DEBIAN_PYTHON, "--strict", *paths)
    places = [line.split(": error")[0].rsplit("/", 1)[-1] for line in done.stdout.splitlines()
              if ": error" in line]
    expected = [f"wrong.py:{line}" for line in range(2, 2 + len(WRONG))]
    if sorted(set(places)) != expected:
        sys.exit(f"types: expected errors at {expected}:\n{done.stdout}{done.stderr}")


def check_stubs(package):
    """The extension has what its stubs say. pybind11's classes have a metaclass of their own, and
    say less of __init__."""
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as allowed:
        allowed.write(r"raygrid\._raygrid\.(Calibration|Camera|Detection|View)(\.__init__)?" "\n")
        allowed.flush()
        done = run(package, "stubtest", "raygrid._raygrid", "--allowlist", allowed.name,
                   "--ignore-unused-allowlist")
    if done.returncode != 0:
        sys.exit("types: " + done.stdout + done.stderr)


def main():
    package = os.path.abspath(sys.argv[1])
    check_uses(package)
    check_stubs(package)


if __name__ == "__main__":
    main()
