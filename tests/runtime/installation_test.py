#!/usr/bin/env python3
"""Installs the runtime into a folder and builds a program against it, by find_package() and by
pkg-config. Both know the installation by the version that its raygrid.h tells."""
import argparse
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


def main():
    parser = argparse.ArgumentParser()
    for name in ("cmake", "build", "compiler", "flags", "consumer"):
        parser.add_argument(f"--{name}", required=True)
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


if __name__ == "__main__":
    main()
