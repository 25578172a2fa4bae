#!/usr/bin/env python3
"""Golden blobs, and what MicroPython must make of them, in files of a folder.

    write_golden.py FOLDER
"""
import json
import sys
from pathlib import Path

import blob_reference as reference
import make_golden

STACK_VALUES = [-3, 0.5, 2, 5, 9]  # dioptres: the outer ones lie outside
PIXELS = [(20.5, 14.25), (80, 60), (131.125, 99.75)]


def rays_at(stack, value):
    there = reference.at_condition(stack, round(value * 65536))
    return [[v / 2**30 for v in reference.unproject_q16(there, *(round(65536 * v) for v in pixel))]
            for pixel in PIXELS]


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    lens, wide = make_golden.make_lens(), make_golden.make_wide()
    stack = make_golden.make_stack(wide)
    lines = make_golden.make_seen_lines(make_golden.make_narrow(lens))
    for name, blob in (("lens", lens), ("wide", wide), ("lines", lines), ("stack", stack)):
        (folder / f"{name}.raygrid").write_bytes(reference.serialize(blob))
    (folder / "frame").write_bytes(bytes(make_golden.make_frame(160, 120)))
    (folder / "expected.json").write_text(json.dumps({
        "pixels": PIXELS,
        "rays": [reference.unproject(lens, *pixel) for pixel in PIXELS],
        "wide_rays": [reference.unproject(wide, *pixel) for pixel in PIXELS],
        "line_points": [reference.line_point(lines, *pixel) for pixel in PIXELS],
        "line_rays": [reference.unproject(lines, *pixel) for pixel in PIXELS],
        "stack_values": STACK_VALUES,
        "stack_inside": [False, True, True, True, False],
        "stack_rays": [rays_at(stack, value) for value in STACK_VALUES],
        "border": make_golden.BORDER,
        "crc": make_golden.remap_crc(lens),
        "size": [lens.remap.width, lens.remap.height],
    }), encoding="utf-8")


if __name__ == "__main__":
    main()
