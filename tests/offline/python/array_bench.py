#!/usr/bin/env python3
"""How much longer a million points take in Python than in C++, by one thread each.

    array_bench.py ARRAY_BENCH CAMERA...     the program of array_bench.cc; camera.yaml

Python and C++ take turns, ten times; the least time of each counts, of the processor's.
"""
import subprocess
import sys
import time

import numpy as np
import raygrid

COUNT, TURNS = 1_000_000, 10


def seconds_of(call, *arguments):
    """The least of three, as in C++: the second result has the memory of the first one."""
    least = np.inf
    for _ in range(3):
        began = time.process_time()
        call(*arguments, threads=1)
        least = min(least, time.process_time() - began)
    return least


def main():
    program, *paths = sys.argv[1:]
    for path in paths:
        camera = raygrid.Camera.load(path)
        x0, y0, x1, y1 = camera.area
        pixels = np.random.default_rng(1).uniform((x0, y0), (x1, y1), (COUNT, 2))
        directions = camera.unproject(pixels)
        least = np.full((2, 2), np.inf)
        for _ in range(TURNS):
            told = subprocess.run([program, path], input=pixels.tobytes(), capture_output=True,
                                  check=True).stdout.split()
            ours = [seconds_of(camera.project, directions), seconds_of(camera.unproject, pixels)]
            least = np.minimum(least, [ours, [float(number) for number in told[:2]]])
        for name, python, native in zip(("project", "unproject"), *least):
            print(f"{path}: {camera.model}: {name}: Python {1e3 * python:.0f} ms, C++ "
                  f"{1e3 * native:.0f} ms, ratio {python / native:.3f}")


if __name__ == "__main__":
    main()
