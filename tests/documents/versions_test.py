#!/usr/bin/env python3
"""All places tell one version, and Debian's list of the library's functions is that of its headers.
"""
import os
import re
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
HEADERS = ("runtime/raygrid.h", "formats/rg_projection.h", "formats/rg_status.h")
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


def main():
    told = versions()
    if len(set(told.values())) != 1:
        sys.exit(f"the versions differ: {told}; write the same into each of these files")
    declared = {name for header in HEADERS for name in DECLARED.findall(read(header))}
    listed = set(re.findall(r"^ (rg_\w+)@", read("debian/libraygrid0.symbols"), re.MULTILINE))
    if declared != listed:
        sys.exit(f"debian/libraygrid0.symbols lacks {sorted(declared - listed)} and has "
                 f"{sorted(listed - declared)} too many; list what raygrid.h declares")
    print(f"version {told['CMakeLists.txt']}, {len(declared)} functions")


if __name__ == "__main__":
    main()
