#!/usr/bin/env python3
"""Runs the examples of the C++ library with cameras of several models. Installs the library alone,
and builds the program of its README.md against it by find_package()."""
import argparse
import math
import os
import re
import subprocess
import sys
import tempfile

WIDTH, HEIGHT = 640, 480
AREA = f"image_size: [{WIDTH}, {HEIGHT}]\narea: [0, 0, {WIDTH - 1}, {HEIGHT - 1}]\n"
COLUMNS, ROWS = 19, 15
GRID = f"grid: {{columns: {COLUMNS}, rows: {ROWS}, chart: stereographic}}\n"
OPENCV = """parameters: {fx: 400, fy: 402, cx: 320, cy: 240, k1: -0.1, k2: 0.02, k3: 0, k4: 0, k5: 0,
  k6: 0, p1: 0.001, p2: -0.001}
"""
# Libraries of the calibrator that the programs of others must not get.
FOREIGN = ("opencv", "ceres", "png", "jpeg", "exif", "cairo")


def grid_points(count):
    """Control points of a wide lens, and points of its lines."""
    for row in range(ROWS):
        for column in range(COLUMNS):
            x = ((column - 1) * (WIDTH - 1) / (COLUMNS - 3) - 320) / 400
            y = ((row - 1) * (HEIGHT - 1) / (ROWS - 3) - 240) / 400
            radius = math.hypot(x, y) or 1e-9
            scale = math.tan(math.atan(radius) / 2) / radius
            yield [scale * x, scale * y, 0.002 * x * x, 0.001 * y, 0.001 * x][:count]


def camera(model, count):
    """The text of a camera.yaml."""
    if model == "opencv":
        return f"model: opencv\n{AREA}{OPENCV}raygrid_camera: 1\n"
    points = "".join(f"  - {point}\n" for point in grid_points(count))
    return f"model: {model}\n{AREA}{GRID}control_points:\n{points}raygrid_camera: 1\n"


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"host_library: {' '.join(command)}\n{done.stdout}{done.stderr}")
    return done.stdout


def run_examples(examples, cameras):
    for example in examples:
        name = os.path.basename(example)
        for model, path in cameras.items():
            # Three views do not determine a grid.
            if name == "ceres_reprojection" and model != "opencv":
                continue
            run(example, path)
        done = subprocess.run([example, "missing.yaml"], capture_output=True, text=True, check=False)
        if done.returncode != 1 or "missing.yaml" not in done.stderr:
            sys.exit(f"host_library: {name} of a missing file says {done.stderr!r}")


def find(folder, name):
    found = [os.path.join(place, name) for place, _, files in os.walk(folder) if name in files]
    return found[0] if found else sys.exit(f"host_library: {name} is missing")


def check_needed(library):
    """It needs no library of the calibrator, and its headers include Eigen alone."""
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", run("readelf", "-d", library))
    for name in needed:
        if any(foreign in name for foreign in FOREIGN):
            sys.exit(f"host_library: {library} needs {name}")
    if not needed:
        sys.exit(f"host_library: readelf prints nothing about {library}")


def check_headers(folder):
    for name in os.listdir(folder):
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            for header in re.findall(r"#include [<\"](.*)[>\"]", file.read()):
                if not re.fullmatch(r"[a-z]+|Eigen/\w+|raygrid_host/\w+\.h", header):
                    sys.exit(f"host_library: {name} includes {header}")


def build_consumer(arguments, prefix, folder):
    """Builds the README's program with its CMakeLists.txt."""
    with open(arguments.readme, encoding="utf-8") as file:
        blocks = dict(re.findall(r"^```(cpp|cmake)\n(.*?)^```$", file.read(), re.M | re.S))
    for name, block in (("consumer.cc", "cpp"), ("CMakeLists.txt", "cmake")):
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(blocks[block])
    build = os.path.join(folder, "build")
    # Eigen allocates and aligns otherwise with AVX, which the library is not compiled for.
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        flags = "-mavx" if re.search(r"\bavx\b", file.read()) else ""
    run(arguments.cmake, "-S", folder, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}",
        f"-DCMAKE_CXX_COMPILER={arguments.compiler}", f"-DCMAKE_CXX_FLAGS={flags}")
    run(arguments.cmake, "--build", build)
    return os.path.join(build, "consumer")


def main():
    parser = argparse.ArgumentParser()
    for name in ("cmake", "build", "compiler", "readme"):
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--examples", nargs="+", required=True)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        cameras = {}
        for model, count in (("opencv", 0), ("central-generic", 2), ("noncentral-generic", 5)):
            cameras[model] = os.path.join(folder, f"{model}.yaml")
            with open(cameras[model], "w", encoding="utf-8") as file:
                file.write(camera(model, count))
        run_examples(arguments.examples, cameras)

        prefix, project = os.path.join(folder, "prefix"), os.path.join(folder, "project")
        os.mkdir(project)
        run(arguments.cmake, "--install", arguments.build, "--prefix", prefix,
            "--component", "host_library")
        check_needed(find(prefix, "libraygrid_host.so"))
        check_headers(os.path.join(prefix, "include", "raygrid_host"))
        consumer = build_consumer(arguments, prefix, project)
        printed = run(consumer, cameras["noncentral-generic"])
        if not printed.startswith("noncentral-generic, 1425 intrinsics\n(319.500, 239.500) -> "):
            sys.exit(f"host_library: the README's program prints {printed!r}")


if __name__ == "__main__":
    main()
