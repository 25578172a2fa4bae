"""The table of README.md for a folder of images that a user has: the models of all programs with the corners of all
detectors. All columns have the same images, corners and split, so that they differ by the detector alone."""
import argparse
import csv
import os
import re
import shutil
import subprocess
import sys

import cv2
import numpy as np

import accuracy
import data_files
import datasets
import page
import progress
import sets
import tables

DETECTORS = {"chessboard": {kind: name.replace("`", "") for kind, name in page.CORNERS.items()},
             "charuco": {"aruco": "cv::aruco", "raygrid": "raygrid detect"}}
STRIDE = 5  # every fifth image is held out
MIN_IMAGES, MIN_CORNERS = 10, 8
MIN_FOUND = 0.3  # part of raygrid's images, below which a detector is left out
MAX_OFFSET = 1 / 3  # of the distance to the next corner: farther off, it is another corner


def write_pattern(options):
    """pattern.yaml of a file or specification. Returns its path and the kind."""
    folder = os.path.join(options.work, "pattern")
    done = subprocess.run([options.raygrid, "simulate", "--images", "1", "--pattern", options.pattern,
                           "--quiet", "-o", folder], capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"--pattern: {done.stderr.strip().removeprefix('raygrid: ')}")
    path = os.path.join(folder, "pattern.yaml")
    kind = datasets.read_value(path, "kind")
    if kind not in DETECTORS:
        raise RuntimeError(f"--pattern {options.pattern}: {kind}; expected one chessboard or ChArUco board")
    return path, kind


def read_corners(path):
    """Pixel by image and place."""
    corners = {}
    for row in datasets.read_csv(path):
        corners.setdefault(row["image"], {})[row["column"], row["row"]] = float(row["x"]), float(row["y"])
    return corners


def match_corners(found, reference):
    """A detector's corners of one image, numbered as raygrid's: boards may be turned by 180 degrees."""
    places, pixels = list(reference), np.array(list(reference.values()))
    spacing = np.linalg.norm(pixels[:, None] - pixels, axis=2) + np.diag([np.inf] * len(pixels))
    numbered = {}
    for pixel in found.values():
        distances = np.linalg.norm(pixels - pixel, axis=1)
        nearest = int(np.argmin(distances))
        if distances[nearest] < MAX_OFFSET * spacing[nearest].min():
            numbered[places[nearest]] = pixel
    return numbered


def select_common(detected):
    """By detector, the images and corners that all of them detect. Detectors of few images are left out."""
    reference = detected["raygrid"]
    kept = {kind: {image: match_corners(found, reference[image]) for image, found in corners.items()
                   if image in reference}
            for kind, corners in detected.items()}
    kept = {kind: corners for kind, corners in kept.items()
            if kind == "raygrid" or len(corners) >= max(MIN_IMAGES, MIN_FOUND * len(reference))}
    shared = {}
    for image in sorted(set.intersection(*(set(corners) for corners in kept.values()))):
        places = set.intersection(*(set(corners[image]) for corners in kept.values()))
        if len(places) >= MIN_CORNERS:
            shared[image] = [place for place in reference[image] if place in places]
    return {kind: {image: {place: corners[image][place] for place in places} for image, places in shared.items()}
            for kind, corners in kept.items()}


def write_set(job, pattern, corners):
    os.makedirs(job["folder"], exist_ok=True)
    with open(pattern, encoding="utf-8") as file, \
            open(os.path.join(job["folder"], "pattern.yaml"), "w", encoding="utf-8") as copy:
        copy.write(file.read())
    rows = [(image, 0, *place, *pixel) for image, found in corners.items() for place, pixel in found.items()]
    parts = [(image, "train" if (i + 1) % STRIDE else "test") for i, image in enumerate(corners)]
    for name, head, lines in (("features", ("image", "board", "column", "row", "x", "y"), rows),
                              ("split", ("image", "part"), parts)):
        with open(os.path.join(job["folder"], name + ".csv"), "w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([head, *lines])


def detect(options, kinds, pattern):
    """Corners by detector, image and place."""
    paths = {kind: os.path.join(options.work, kind + ".csv") for kind in kinds}
    progress.run([progress.Step(f"corners: {name}", 10, lambda k=kind: accuracy.find_corners(
        options, options.images, k, pattern, paths[k])) for kind, name in kinds.items()])
    return {kind: read_corners(path) if os.path.exists(path) else {} for kind, path in paths.items()}


def aligned(lines):
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() for line in lines)


def print_parts(found, kinds):
    """What the corners, the target geometry and the model contribute, changed one after the other."""
    def best(names, models, target):
        rows = [row for row in found if row["program"] == "raygrid" and row["set"] in names and
                re.fullmatch(models, row["model"]) and row["target"] == target]
        return page.best_of(rows, "median_px")

    others = [kind for kind in kinds if kind != "raygrid"]
    parts = [best(others, page.PARAMETRIC, "nominal"), best(["raygrid"], page.PARAMETRIC, "nominal"),
             best(["raygrid"], page.PARAMETRIC, "estimated"), best(["raygrid"], page.GENERIC, "estimated")]
    print("\nContributions, medians of raygrid's calibrations:")
    for row, text in zip(parts, ("{model}, nominal target, corners of {set}", "with the corners of raygrid detect",
                                 "with estimated target geometry", "with the model {model}")):
        if row:
            print(f"  {row['median_px']}  {text.format(**{**row, 'set': kinds[row['set']]})}")


def print_tables(found, kinds):
    for column, title in (("median_px", "Median"), ("rms_px", "RMS")):
        print(f"\n{title} of held-out errors in px, nominal / estimated target, by the detector of the corners:")
        lines = [[cell.replace("`", "") for cell in line] for line in page.model_lines(found, kinds, column)]
        print(aligned([["model", *kinds.values()], *(line for line in lines if set(line[1:]) != {"–"})]))


def measure(options):
    pattern, kind = write_pattern(options)
    kinds = DETECTORS[kind]
    detected = detect(options, kinds, pattern)
    corners = select_common(detected)
    images = list(corners["raygrid"])
    print(f"\n{len(images)} images have corners of all detectors in the tables:")
    for name, found in detected.items():
        print(f"  {kinds[name]}: {sum(map(len, found.values()))} corners of {len(found)} images" +
              (", left out" if name not in corners else ""))
    if len(images) < MIN_IMAGES:
        raise RuntimeError(f"--images {options.images}: {len(images)} images show the pattern; at least "
                           f"{MIN_IMAGES} are needed")
    height, width = cv2.imread(os.path.join(options.images, images[0]), cv2.IMREAD_GRAYSCALE).shape
    jobs = [{**sets.make_job(options.work, kind, kinds[kind], os.path.join(options.work, kind, "corners"),
                             (width, height), few=options.few), "length": len(images) / 13} for kind in corners]
    for job in jobs:
        write_set(job, pattern, corners[job["name"]])
    progress.run([step for job in jobs for step in accuracy.steps_of(job, options)])  # a program that fails has no row
    data_files.write(options.work, "accuracy", tables.accuracy_rows(accuracy.results_of(jobs, options)))
    found = page.read_accuracy(options.work)
    kinds = {kind: kinds[kind] for kind in corners}
    print_tables(found, kinds)
    print_parts(found, kinds)
    print(f"\nall figures: {data_files.path_of(options.work, 'accuracy')}")


def main(options):
    options = argparse.Namespace(**{**vars(options), "work": os.path.join(options.work, "images")})
    shutil.rmtree(options.work, ignore_errors=True)
    os.makedirs(options.work)
    try:
        measure(options)
    except (RuntimeError, ValueError) as error:
        sys.exit(f"measure_readme: {error}")
