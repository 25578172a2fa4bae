#!/usr/bin/env python3
"""What debian/ says is what the project has: its version, the library's functions, the packages that
the build needs, and links of packaged documents."""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
HEADERS = ("runtime/raygrid.h", "formats/rg_projection.h", "formats/rg_status.h")
# Groups of tools/install_packages that packages are built with, but for what Debian need not name
# or only users of the build folder need.
GROUPS = ("host", "python", "camera", "reference")
# Packages are built with g++, the preset host with clang.
UNNAMED = {"g++", "clang-14", "python3-numpy"}
# A function's declaration begins at the left with its type. Macros and comments do not.
DECLARED = re.compile(r"^(?!typedef|static|#)[a-z][\w ]*[ *]+(rg_\w+)\(", re.MULTILINE)


def read(name):
    with open(os.path.join(ROOT, name), encoding="utf-8") as file:
        return file.read()


def versions():
    header = read("runtime/raygrid.h")
    return {
        "CMakeLists.txt": re.search(r"^project\(raygrid VERSION (\S+)", read("CMakeLists.txt"),
                                    re.MULTILINE).group(1),
        "runtime/raygrid.h": ".".join(
            re.search(rf"RAYGRID_VERSION_{part} (\d+)", header).group(1)
            for part in ("MAJOR", "MINOR", "PATCH")),
        "debian/changelog": re.match(r"raygrid \((.+?)\)", read("debian/changelog")).group(1),
    }


def needed_packages():
    """What the build needs by tools/install_packages, and by debian/control."""
    groups = dict(re.findall(r"^ +([\w-]+)\) echo ((?:[^;\\]|\\\n)*);;",
                             read("tools/install_packages"), re.MULTILINE))
    installed = {name for group in GROUPS for name in groups[group].replace("\\\n", " ").split()}
    depends = "".join(re.findall(r"^Build-Depends(?:-Indep)?:\n((?: .*\n)+)", read("debian/control"),
                                 re.MULTILINE))
    return installed - UNNAMED, set(re.findall(r"^ ([\w.+-]+)", depends, re.MULTILINE))


def dead_links_of_packaged_documents():
    """Stages raygrid-doc's documents as the package has them."""
    with tempfile.TemporaryDirectory() as staged:
        for line in read("debian/raygrid-doc.install").splitlines():
            source, folder = line.split()
            if source.startswith("usr/"):
                continue  # made by the build
            source, target = os.path.join(ROOT, source), os.path.join(staged, folder)
            os.makedirs(target, exist_ok=True)
            if os.path.isdir(source):
                shutil.copytree(source, os.path.join(target, os.path.basename(source)))
            else:
                shutil.copy(source, target)
        subprocess.run([os.path.join(ROOT, "debian/unlink_missing"), staged], check=True)
        return [f"{os.path.relpath(path, staged)}: {link}"
                for path in glob.glob(staged + "/**/*.md", recursive=True)
                for link in re.findall(r"\]\(([^)#]+)[^)]*\)", read(path))
                if ":" not in link
                and not os.path.exists(os.path.join(os.path.dirname(path), link))]


def main():
    told = versions()
    if len(set(told.values())) != 1:
        sys.exit(f"the versions differ: {told}; write the same into each of these files")
    declared = {name for header in HEADERS for name in DECLARED.findall(read(header))}
    listed = set(re.findall(r"^ (rg_\w+)@", read("debian/libraygrid0.symbols"), re.MULTILINE))
    if declared != listed:
        sys.exit(f"debian/libraygrid0.symbols lacks {sorted(declared - listed)} and has "
                 f"{sorted(listed - declared)} too many; list what raygrid.h declares")
    installed, named = needed_packages()
    if installed - named:
        sys.exit(f"Build-Depends of debian/control lacks {sorted(installed - named)}, which "
                 "tools/install_packages installs for the build")
    dead = dead_links_of_packaged_documents()
    if dead:
        sys.exit(f"links of raygrid-doc lead nowhere: {', '.join(dead)}")
    print(f"version {told['CMakeLists.txt']}, {len(declared)} functions, {len(installed)} packages")


if __name__ == "__main__":
    main()
