"""The part that the peers share: each calibration becomes a row of results."""
import os
import re
import sys
import time

import datasets
import localization


class Camera:
    """A calibrated camera: project() takes points in its frame, one a row; board holds the corners as
    the calibration knows them; write(path) writes a file of the program's own, which ends in suffix."""

    def __init__(self, project, board, parameters, write=None, suffix=".yaml"):
        self.project, self.board, self.parameters = project, board, parameters
        self.write, self.suffix = write, suffix


class NotPossible(Exception):
    """Why a peer does not calibrate from a set."""


def write_files(data, label, camera):
    """The camera and its board in files, by the names of the row that has them."""
    words = "-".join(label[key] for key in ("peer", "version", "model", "target"))
    folder = os.path.join(data.work, re.sub(r"[^\w.-]+", "-", words))
    os.makedirs(folder, exist_ok=True)
    files = {"camera": os.path.join(folder, "camera" + camera.suffix),
             "pattern": os.path.join(folder, "pattern.yaml")}
    camera.write(files["camera"])
    datasets.write_board(files["pattern"], data, camera.board)
    return files


def row_of(data, label, calibrate):
    """Calibrates, localises, and says how well; or why not."""
    begin = time.perf_counter()
    row = dict(label)
    try:
        camera = calibrate()
    except NotPossible as reason:
        return {**row, "failed": str(reason)}
    row["seconds"] = time.perf_counter() - begin
    row["parameters"] = camera.parameters
    if data.both_ways and camera.write:
        row.update(write_files(data, label, camera))
    for part, views in (("train", data.train), ("test", data.test)):
        norms = localization.errors_px(camera.project, camera.board, views, data.starts)
        row[part] = localization.figures(norms)
    return row


def main(rows_of):
    """rows_of(data) yields rows. PROGRAM JOB.json RESULT.json; until all is done, RESULT.json.part"""
    data = datasets.DataSet(datasets.read_json(sys.argv[1]))
    rows, part = [], sys.argv[2] + ".part"
    for row in rows_of(data):
        rows.append(row)
        datasets.write_json(part, rows)
    os.replace(part, sys.argv[2])
