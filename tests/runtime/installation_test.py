#!/usr/bin/env python3
"""Installs the runtime into a folder and builds a program against it, by find_package() and by
pkg-config. Both know the installation by the version that its raygrid.h tells. Then installs all
components, as packages do, moves them, and uses them where they lie."""
import argparse
import ctypes
import fnmatch
import os
import re
import shutil
import subprocess
import sys
import tempfile

PROJECT = """cmake_minimum_required(VERSION 3.16)
project(consumer LANGUAGES C)
find_package(raygrid {version} EXACT REQUIRED)
add_executable(consumer consumer.c)
set_target_properties(consumer PROPERTIES C_STANDARD 99)
target_link_libraries(consumer PRIVATE raygrid::runtime)
"""

# Some files of each component, in the folder of the prefix.
COMPONENTS = {
    "runtime": ("include/raygrid/raygrid.h", "lib*/libraygrid.so.0", "lib*/pkgconfig/raygrid.pc"),
    "undistort": ("bin/raygrid-undistort", "share/man/man1/raygrid-undistort.1"),
    "command": ("bin/raygrid", "share/man/man1/raygrid.1",
                "share/man/man1/raygrid_calibrate.1", "share/zsh/site-functions/_raygrid",
                "share/bash-completion/completions/raygrid"),
    "camera": ("bin/raygrid-camera", "share/man/man1/raygrid-camera.1"),
    "gstreamer": ("lib*/gstreamer-1.0/libgstraygrid.so",),
    "host_library": ("include/raygrid_host/camera.h", "lib*/libraygrid_host.so.0",
                     "lib*/cmake/raygrid_host/raygrid_host-config.cmake"),
    "python": ("lib/python*/raygrid/__init__.py", "lib/python*/raygrid/_raygrid.*.so"),
    "examples": ("share/doc/raygrid/examples/runtime/undistort_frame.c",
                 "share/doc/raygrid/examples/python/photographs_figure.py"),
}
# A lens of another program, whose frames the command undistorts.
CAMERA = """%YAML:1.0
---
image_width: 64
image_height: 48
camera_matrix: !!opencv-matrix
   {rows: 3, cols: 3, dt: d, data: [50, 0, 31.5, 0, 50, 23.5, 0, 0, 1]}
distortion_coefficients: !!opencv-matrix {rows: 1, cols: 5, dt: d, data: [0.1, 0, 0, 0, 0]}
"""


def run(*command, **environment):
    done = subprocess.run(command, capture_output=True, text=True, check=False,
                          env={**os.environ, **environment})
    if done.returncode != 0:
        sys.exit(f"installation: {' '.join(command)}\n{done.stdout}{done.stderr}")
    return done.stdout


def check_program(path):
    """It runs, and finds the library's texts."""
    done = subprocess.run([path, "/dev/null", "in", "out"], capture_output=True, text=True,
                          check=False)
    if done.returncode != 1 or "/dev/null" not in done.stderr:
        sys.exit(f"installation: {path} says '{done.stderr.strip()}'")


def find(folder, name):
    found = [os.path.join(place, name) for place, _, files in os.walk(folder) if name in files]
    return found[0] if found else sys.exit(f"installation: {name} is missing")


def version_of(header):
    """The version that raygrid.h tells: "0.2.0"."""
    with open(header, encoding="utf-8") as file:
        parts = re.findall(r"^#define RAYGRID_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", file.read(),
                           re.MULTILINE)
    return ".".join(parts)


def check_version(pc_folder, version):
    """pkg-config tells the header's version."""
    told = run("pkg-config", "--modversion", "raygrid", PKG_CONFIG_PATH=pc_folder).strip()
    if told != version:
        sys.exit(f"installation: pkg-config tells version {told}, raygrid.h {version}")


def check_module(prefix):
    """The Python module finds the library that it was installed with, and says where it looked."""
    module, library = find(prefix, "raygrid.py"), find(prefix, "libraygrid.so")
    command = (sys.executable, "-B", "-c", "import raygrid; print(raygrid._library._name)")
    place = {"PYTHONPATH": os.path.dirname(module), "RAYGRID_LIBRARY": ""}
    found = run(*command, **place).strip()
    if not os.path.samefile(found, library):
        sys.exit(f"installation: the module takes {found}, not {library}")
    os.rename(library, library + ".away")
    done = subprocess.run(command, capture_output=True, text=True, check=False,
                          env={**os.environ, **place})
    if done.returncode == 0 or os.path.realpath(library) not in done.stderr:
        sys.exit(f"installation: without the library, the module says '{done.stderr.strip()}'")


def list_files(folder):
    return {os.path.relpath(os.path.join(place, name), folder)
            for place, _, names in os.walk(folder) for name in names}


def install_all(arguments, folder):
    """Stages each component, as for /usr, in a folder of its own; then all in another place."""
    everything = os.path.join(folder, "moved to here", "usr")
    for component, patterns in COMPONENTS.items():
        if component in arguments.without:
            continue
        staged = os.path.join(folder, "staged", component)
        run(arguments.cmake, "--install", arguments.build, "--prefix", "/usr", "--component",
            component, DESTDIR=staged)
        files = list_files(staged)
        for pattern in patterns:
            if not fnmatch.filter(files, "usr/" + pattern):
                sys.exit(f"installation: component {component} lacks {pattern}: {sorted(files)}")
        shutil.copytree(os.path.join(staged, "usr"), everything, symlinks=True, dirs_exist_ok=True)
    shutil.rmtree(os.path.join(folder, "staged"))
    return everything


def use_all(arguments, prefix, folder):
    """The moved tree works, also what finds its parts from its own place on."""
    camera, image, flat = (os.path.join(folder, name) for name in ("lens.yml", "a.pgm", "flat"))
    with open(camera, "w", encoding="utf-8") as file:
        file.write(CAMERA)
    with open(image, "wb") as file:
        file.write(b"P5 64 48 255\n" + bytes(range(64)) * 48)
    run(os.path.join(prefix, "bin", "raygrid"), "undistort", camera, image, "-o", flat)
    find(flat, "a.png")
    run(os.path.join(prefix, "bin", "raygrid-undistort"), "--help")
    if "python" not in arguments.without:
        package = os.path.dirname(os.path.dirname(find(prefix, "py.typed")))
        run(arguments.python, "-B", "-c", "import raygrid, sys\nprint(raygrid.detect(sys.argv[1], "
            "'chessboard:9x6:25mm'))", image, PYTHONPATH=package)
    if "camera" not in arguments.without:
        run(os.path.join(prefix, "bin", "raygrid-camera"), "--help")
    if "gstreamer" not in arguments.without:
        ctypes.CDLL(find(prefix, "libgstraygrid.so"))


def main():
    parser = argparse.ArgumentParser()
    for name in ("cmake", "build", "compiler", "flags", "consumer"):
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--python", help="the one that the package is for")
    parser.add_argument("--without", nargs="*", default=[], help="components that are not built")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        prefix, project = os.path.join(folder, "prefix"), os.path.join(folder, "project")
        run(arguments.cmake, "--install", arguments.build, "--prefix", prefix,
            "--component", "runtime")
        version = version_of(find(prefix, "raygrid.h"))
        os.mkdir(project)
        source = shutil.copy(arguments.consumer, os.path.join(project, "consumer.c"))
        with open(os.path.join(project, "CMakeLists.txt"), "w", encoding="utf-8") as file:
            file.write(PROJECT.format(version=version))
        build = os.path.join(folder, "build")
        run(arguments.cmake, "-S", project, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}",
            f"-DCMAKE_C_COMPILER={arguments.compiler}", f"-DCMAKE_C_FLAGS={arguments.flags}")
        run(arguments.cmake, "--build", build)
        check_program(os.path.join(build, "consumer"))

        pc_folder = os.path.dirname(find(prefix, "raygrid.pc"))
        check_version(pc_folder, version)
        options = run("pkg-config", "--cflags", "--libs", "raygrid",
                      PKG_CONFIG_PATH=pc_folder).split()
        program = os.path.join(folder, "by_pkg_config")
        run(arguments.compiler, "-std=c99", *arguments.flags.split(), source, *options,
            "-o", program)
        check_program(program)

        check_module(prefix)
        use_all(arguments, install_all(arguments, folder), folder)


if __name__ == "__main__":
    main()
