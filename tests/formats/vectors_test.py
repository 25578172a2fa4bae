#!/usr/bin/env python3
"""The runtime and the whole reader in C give the results of formats/vectors, bit for bit."""
import csv
import re
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

import raygrid
import runtime_camera

ROOT = Path(__file__).resolve().parents[2]
VECTORS = ROOT / "formats" / "vectors"
FRAME_SEED = 2025
BORDER_VALUES = (201, 17, 130, 66)
KEPT_BYTE = 0xa5
BYTES_PER_PIXEL = {name: sum(across * down for across, down in planes)
                   for name, (_, _, planes) in raygrid.FORMATS.items()}


def read_rows(name):
    with open(VECTORS / name, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def integers(row, *columns):
    """None where the first of the fields is empty."""
    return tuple(int(row[column]) for column in columns) if row[columns[0]] else None


def blob_bytes(name):
    return (VECTORS / f"{name}.raygrid").read_bytes()


class Cameras:
    """Opened once for each blob and condition."""

    def __init__(self, open_camera):
        self._open = open_camera
        self._cameras = {}

    def of(self, row):
        key = row["blob"], row["condition_q16"]
        if key not in self._cameras:
            condition = int(key[1]) if key[1] else None
            self._cameras[key] = self._open(blob_bytes(key[0]), condition)
        return self._cameras[key]


def open_for_frames(data, condition):
    camera = raygrid.Camera(data)
    if condition is not None:
        camera.set_condition(condition / 2**16)
    return camera


def make_plane(width, height):
    state, rows = FRAME_SEED, bytearray()
    for y in range(height):
        for x in range(width):
            state = (state * 1664525 + 1013904223) % 2**32
            rows.append((2 * x + y + (state >> 27)) % 256)
    return bytes(rows)


def make_frame(pixel_format, width, height):
    planes = raygrid.FORMATS[pixel_format][2]
    return b"".join(make_plane(int(width * across), int(height * down)) for across, down in planes)


class VectorsTest(unittest.TestCase):
    def test_rays(self):
        cameras = Cameras(runtime_camera.Camera)
        rows = read_rows("rays.csv")
        for row in rows:
            camera, pixel = cameras.of(row), integers(row, "x_q16", "y_q16")
            direction = integers(row, "dx_q30", "dy_q30", "dz_q30")
            origin = integers(row, "ox_q28", "oy_q28", "oz_q28")
            self.assertEqual(camera.line(pixel), direction and (origin, direction), row)
            self.assertEqual(camera.is_valid(pixel), row["valid"] == "1", row)
            uncertainty = integers(row, "uncertainty_q12")
            self.assertEqual(camera.uncertainty(pixel), uncertainty and uncertainty[0], row)
        self.assertGreater(len(rows), 1000)

    def test_projections(self):
        cameras = Cameras(runtime_camera.Camera)
        rows = read_rows("projections.csv")
        for row in rows:
            camera, point = cameras.of(row), integers(row, "x", "y", "z")
            pixel = integers(row, "x_q16", "y_q16")
            bits = integers(row, "fraction_bits")
            found = camera.pixel_of(point) if bits is None else camera.pixel_of_point(point, *bits)
            self.assertEqual(found, pixel, row)
        self.assertGreater(len(rows), 1000)

    def test_frames(self):
        cameras = Cameras(open_for_frames)
        rows = read_rows("frames.csv")
        for row in rows:
            camera, pixel_format = cameras.of(row), row["format"]
            camera.select_remap(int(row["table"]))
            width, height = camera.remap_size()
            frame = make_frame(pixel_format, *camera.frame_size())
            out = bytearray([KEPT_BYTE]) * round(width * height * BYTES_PER_PIXEL[pixel_format])
            camera.undistort(frame, pixel_format, row["border"], BORDER_VALUES, row["sampling"], out)
            self.assertEqual(f"{zlib.crc32(out):08x}", row["crc32"], row)
        self.assertGreater(len(rows), 200)

    def test_mutants(self):
        rows = read_rows("mutants.csv")
        with tempfile.TemporaryDirectory() as folder:
            paths = []
            for k, row in enumerate(rows):
                paths.append(Path(folder) / str(k))
                paths[-1].write_bytes(mutate(row))
            output = subprocess.run([BLOB_STATUS, *paths], check=True, capture_output=True,
                                    text=True).stdout
        names = status_names()
        for row, line in zip(rows, output.splitlines(), strict=True):
            whole, board = (names[int(number)] for number in line.split()[-2:])
            self.assertEqual(whole, row["whole_reader"], row)
            self.assertIn(board, row["board"].split("/"), row)
        self.assertGreater(len(rows), 40)


def mutate(row):
    """The blob with the bytes of a row of mutants.csv, and with CRCs that hold if it says so."""
    data = bytearray(blob_bytes(row["blob"]))
    sections = [data[at:at + 16] for at in range(32, 32 + 16 * data[16], 16)]
    new, offset = bytes.fromhex(row["bytes"]), int(row["offset"])
    data[offset:offset + len(new)] = new
    if row["crcs"] == "recomputed":
        for k, entry in enumerate(sections):
            start, size = (int.from_bytes(entry[at:at + 4], "little") for at in (4, 8))
            data[44 + 16 * k:48 + 16 * k] = crc_bytes(zlib.crc32(data[start:start + size]))
        table = data[32:32 + 16 * len(sections)]
        data[28:32] = crc_bytes(zlib.crc32(table, zlib.crc32(data[:28])))
    return bytes(data)


def crc_bytes(crc):
    return crc.to_bytes(4, "little")


def status_names():
    """Names without RG_ERR_, by their numbers."""
    text = (ROOT / "formats" / "rg_status.h").read_text(encoding="utf-8")
    return {int(number): name.removeprefix("RG_").removeprefix("ERR_")
            for name, number in re.findall(r"(RG_\w+)\s*=\s*(-?\d+)", text)}


if __name__ == "__main__":
    BLOB_STATUS = sys.argv.pop()
    unittest.main(verbosity=2)
