#!/usr/bin/env python3
"""Speed and accuracy of the C++ library, OpenCV and mrcal in one table, for people; CPU times of one
thread. mrcal projects with the same parameters (OPENCV8), and with a splined model of the first
camera; it needs python3-mrcal.

    speed_table.py build/host/bin/host_library_bench build/host/bin/raygrid CAMERA.yaml...
"""
import os
import re
import subprocess
import sys
import tempfile
import time

import mrcal
import numpy as np

REPETITIONS = 7
# mrcal and OpenCV: k1 k2 p1 p2 k3 to k6.
ORDER = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")


def speed(count, run):
    """Millions of results per second."""
    least = float("inf")
    for _ in range(REPETITIONS):
        start = time.thread_time()
        run()
        least = min(least, time.thread_time() - start)
    return count / least / 1e6


def print_row(name, intrinsics, points):
    pixels = mrcal.project(points, *intrinsics)
    # mrcal's inverse is a search per pixel.
    some = pixels[:len(points) // 50]
    back = mrcal.project(mrcal.unproject(some, *intrinsics), *intrinsics)
    error = np.nanmax(np.linalg.norm(back - some, axis=1))
    print(f"| mrcal, {name} | {speed(len(some), lambda: mrcal.unproject(some, *intrinsics)):.2f} | "
          f"{speed(len(points), lambda: mrcal.project(points, *intrinsics)):.1f} | {error:.1e} |")
    print(f"| mrcal, {name}, with gradients of points and intrinsics | | "
          f"{speed(len(points), lambda: mrcal.project(points, *intrinsics, get_gradients=True)):.2f} | |")


def main():
    bench, raygrid, *cameras = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        rays = os.path.join(folder, "rays")
        print(subprocess.run([bench, *cameras, "--rays", rays], check=True, capture_output=True,
                             text=True).stdout, end="")
        points = np.fromfile(rays).reshape(-1, 3)
        for path in cameras:
            with open(path, encoding="utf-8") as file:
                text = file.read()
            if "model: opencv\n" in text:
                found = dict(re.findall(r"(\w+): ([-+.\de]+)", text))
                print_row("OPENCV8", ("LENSMODEL_OPENCV8", np.array([float(found[key]) for key in ORDER])),
                          points)
        model = os.path.join(folder, "splined.cameramodel")
        subprocess.run([raygrid, "export", cameras[0], "--to", "mrcal", "-o", model], check=True,
                       capture_output=True)
        name, parameters = mrcal.cameramodel(model).intrinsics()
        size = re.search(r"Nx=(\d+)_Ny=(\d+)", name)
        print_row(f"splined {size[1]}×{size[2]}" if size else name, (name, parameters), points)


if __name__ == "__main__":
    main()
