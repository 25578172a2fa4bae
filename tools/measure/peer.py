"""The part that the peers share: each calibration becomes a row of results."""
import os
import sys
import time

import datasets
import localization


class Camera:
    """A calibrated camera: project() takes points in its frame, one a row; board holds the corners as
    the calibration knows them."""

    def __init__(self, project, board, parameters):
        self.project, self.board, self.parameters = project, board, parameters


class NotPossible(Exception):
    """Why a peer does not calibrate from a set."""


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
