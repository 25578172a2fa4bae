#!/usr/bin/env python3
"""The source files that the documents name exist.

A name may be a path from the project's folder or from the document's, or the end of one: a recipe
that says `camera.c` finds the file wherever it was moved. NAME stands for a file to be made.
"""
import fnmatch
import os
import re
import sys

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
# Stages of the calibrator with a page on why they are as they are.
STAGES = ("adjustment", "bags", "calibration", "camera", "dataset", "evaluation", "features",
          "fleet", "hand_eye", "host_library", "initialization", "packing", "report")
DOCUMENTS = ("README.md", "CONTRIBUTING.md", "offline/GLOSSARY.md", "tools/README.md", "tools/raygrid_camera/README.md", "formats/JSON.md",
             "tools/raygrid_capture/README.md", "offline/METHOD.md", "offline/TUTORIAL.md",
             "offline/fleet/README.md", "runtime/README.md", "runtime/DESIGN.md",
             "runtime/COST.md", "runtime/libcamera/README.md", "runtime/micropython/README.md",
             "runtime/python/README.md", "runtime/v4l2/README.md",
             "runtime/wasm/README.md", "offline/README.md",
             "benchmarks/README.md", "offline/experiments/README.md", "offline/python/README.md",
             "offline/python/DESIGN.md", "offline/host_library/README.md",
             *(f"offline/{stage}/DESIGN.md" for stage in STAGES))
DOCUMENTS += ("SECURITY.md", "formats/SPEC.md", "formats/vectors/README.md",
              *(f"runtime/{folder}/README.md"
                for folder in ("cortex_m", "frames", "gstreamer", "kernels", "rays")))
NAMED = re.compile(r"`([\w./*-]+\.(?:c|h|cc|py|js|md|txt|toml|json|\*))`")
# Files that a command writes.
MADE = {"SERIAL.failed.json", "raygrid.c", "result.json", "resume.json", "session.json", "thumbnails.json", "unit.json"}
NO_FOLDERS = {".git", "build"}


def list_files():
    """All files of the project, with the paths below its folder."""
    files = []
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [name for name in folders if name not in NO_FOLDERS]
        files += [os.path.relpath(os.path.join(folder, name), ROOT) for name in names]
    return files


def is_there(name, files):
    name = re.sub(r"^(\.\./)+", "", name)
    return any(fnmatch.fnmatchcase(file, name) or fnmatch.fnmatchcase(file, "*/" + name)
               for file in files)


def main():
    files, missing, count = list_files(), [], 0
    for document in DOCUMENTS:
        with open(os.path.join(ROOT, document), encoding="utf-8") as file:
            names = sorted(set(NAMED.findall(file.read())))
        for name in names:
            if name in MADE or "NAME" in name:
                continue
            count += 1
            if not is_there(name, files):
                missing.append(f"{document} names {name}, which is not there")
    print(f"{count} names of files")
    if missing:
        sys.exit("\n".join(missing))


if __name__ == "__main__":
    main()
