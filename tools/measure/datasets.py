"""Sets of corners: features.csv, pattern.yaml and split.csv in one folder, and what a job file says
beside them (image size, rough focal length)."""
import csv
import json
import os
import re

import numpy as np


class View:
    """The board in one image: places of the board's corners, and their pixels."""

    def __init__(self, image):
        self.image = image
        self.places, self.pixels = [], []

    def close(self):
        """Row by row."""
        order = np.argsort(self.places)
        self.places, self.pixels = np.array(self.places)[order], np.array(self.pixels)[order]


class DataSet:
    """Corners of one camera and one flat board, training and held-out images apart."""

    def __init__(self, job):
        self.name = job["name"]
        self.image_size = tuple(job["image_size"])
        self.focal_px = job["focal_px"]
        self.fov_deg = job["fov_deg"]
        self.folder = job["folder"]
        self.few = job.get("few", False)  # models
        self.both_ways = job.get("both_ways", False)  # cameras go into files, for both_ways.py
        self.work = job["work"]
        self.columns, self.rows, self.square_m = read_board(os.path.join(self.folder, "pattern.yaml"))
        parts = read_split(self.folder)
        views = {}
        for row in read_csv(os.path.join(self.folder, "features.csv")):
            view = views.setdefault(row["image"], View(row["image"]))
            view.places.append(int(row["row"]) * self.columns + int(row["column"]))
            view.pixels.append((float(row["x"]), float(row["y"])))
        for view in views.values():
            view.close()
        self.train = [v for v in views.values() if parts[v.image] == "train"]
        self.test = [v for v in views.values() if parts[v.image] == "test"]
        self.starts = read_poses(job["poses"]) if "poses" in job else {}

    def flat_board(self):
        """Nominal corners, row by row, in metres."""
        row, column = np.divmod(np.arange(self.rows * self.columns), self.columns)
        return np.stack([column, row, 0 * row], axis=1) * self.square_m


def write_board(path, data, points):
    """pattern.yaml of a board whose corners lie where a calibration found them."""
    rows = "".join("      - [" + ", ".join(f"{value:.12g}" for value in point) + "]\n" for point in points)
    with open(path, "w", encoding="utf-8") as file:
        file.write("raygrid_pattern: 1\nboards:\n  - id: 0\n    kind: chessboard\n"
                   f"    columns: {data.columns}\n    rows: {data.rows}\n    square_m: {data.square_m:.12g}\n"
                   f"    points:\n{rows}")


def read_csv(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def read_value(path, key):
    """Of a pattern of one board."""
    with open(path, encoding="utf-8") as file:
        values = re.findall(rf"\b{key}: *([\w.-]+)", file.read())
    if len(values) != 1:
        raise ValueError(f"{path}: not a pattern of one board with {key}")
    return values[0]


def read_board(path):
    """Columns, rows and square length of a pattern of one board."""
    return (int(read_value(path, "columns")), int(read_value(path, "rows")), float(read_value(path, "square_m")))


def read_split(folder):
    return {row["image"]: row["part"] for row in read_csv(os.path.join(folder, "split.csv"))}


def read_poses(path):
    """poses.csv: rotation matrix and translation by image."""
    poses = {}
    for row in read_csv(path):
        w, x, y, z = (float(row[key]) for key in ("qw", "qx", "qy", "qz"))
        rotation = np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
        poses[row["image"]] = rotation, np.array([float(row[key]) for key in ("tx", "ty", "tz")])
    return poses


def read_json(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def parse_json(text):
    return json.loads(text)


def write_json(path, value):
    with open(path, "w", encoding="utf-8") as file:
        json.dump(value, file, indent=1)
        file.write("\n")
