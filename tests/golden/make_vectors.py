#!/usr/bin/env python3
"""Write the test vectors of formats/vectors with blob_reference.py.

With --check, compare what would be written with what is there instead.
"""

import argparse
import dataclasses
import sys
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import make_golden as golden
import blob_reference as reference

FOLDER = golden.VECTORS
WHOLE_NUMBER_LIMIT = 1 << 30
DIRECTIONS = 60
POINT_FRACTION_BITS = 24
TABLES_OF_ALL_FORMATS = (("wide", "", 0), ("bent", "", 0), ("bent", "", 1),
                         *(("stack", str(golden.FORMATS_CONDITION), table) for table in (0, 1)))


def make_blobs() -> dict[str, reference.Blob]:
    """The cameras of the vectors, by the names of their files."""
    example, lens, wide = golden.make_example(), golden.make_lens(), golden.make_wide()
    narrow = golden.make_narrow(lens)
    return {"example": example, "lens": lens, "narrow": narrow, "wide": wide,
            "lines": golden.make_lines(example), "seen_lines": golden.make_seen_lines(narrow),
            "bent": golden.make_bent(wide), "views": golden.make_views(wide),
            "modes": golden.make_modes(wide), "capture": golden.make_capture(example),
            "stack": golden.make_stack(wide), "row_time": golden.make_row_time(example)}


def at_conditions(blob: reference.Blob) -> Iterator[tuple[str, reference.Blob]]:
    """A condition in q16 and the camera there; without a stack the blob as it is."""
    if blob.stack is None:
        yield "", blob
        return
    for value in golden.STACK_CONDITIONS:
        yield str(value), reference.at_condition(blob, value)


def csv_line(values: Iterable[object]) -> str:
    """A line of a CSV; empty fields for None."""
    return ",".join("" if value is None else str(value) for value in values)


def ray_lines(blobs: dict[str, reference.Blob]) -> Iterator[str]:
    """rays.csv."""
    yield ("blob,condition_q16,x_q16,y_q16,dx_q30,dy_q30,dz_q30,ox_q28,oy_q28,oz_q28,valid,"
           "uncertainty_q12")
    for name, blob in blobs.items():
        for condition, camera in at_conditions(blob):
            outside = (camera.grid.x0 - 1, camera.grid.y0)
            for pixel in (*golden.golden_pixels(camera.grid), outside):
                line = reference.unproject_line_q16(camera, *pixel)
                origin, direction = line or ((None,) * 3, (None,) * 3)
                valid = int(reference.is_valid_q16(camera, *pixel))
                yield csv_line((name, condition, *pixel, *direction, *origin, valid,
                                reference.uncertainty_q12(camera, *pixel)))


def projection_lines(blobs: dict[str, reference.Blob]) -> Iterator[str]:
    """projections.csv: directions, if the camera is central, and points in front of it."""
    yield "blob,condition_q16,fraction_bits,x,y,z,x_q16,y_q16"
    for name, blob in blobs.items():
        if blob.inverse is None:
            continue
        for condition, camera in at_conditions(blob):
            for vector in () if camera.line_points else directions_of(camera):
                pixel = reference.project_q16(camera, vector)
                yield csv_line((name, condition, None, *vector, *(pixel or (None, None))))
            for point in points_of(camera):
                pixel = reference.project_point_q16(camera, point, POINT_FRACTION_BITS)
                yield csv_line((name, condition, POINT_FRACTION_BITS, *point,
                                *(pixel or (None, None))))


def directions_of(camera: reference.Blob) -> Iterator[reference.Vector]:
    """Directions of all ways and lengths, and those of pixels."""
    yield 0, 0, 0
    yield from golden.random_directions(DIRECTIONS)
    for pixel in golden.golden_pixels(camera.grid)[:DIRECTIONS // 2]:
        yield reference.unproject_q16(camera, *pixel)


def points_of(camera: reference.Blob) -> Iterator[reference.Vector]:
    """Points on the lines of pixels, 0.1 m away and more."""
    for k, pixel in enumerate(golden.golden_pixels(camera.grid)[9:9 + DIRECTIONS // 2]):
        origin, direction = reference.unproject_line_q16(camera, *pixel)
        distance = 0.1 * 1.25 ** (k % 20)
        point = [round((o / golden.Q28 + distance * d / golden.Q30) * 2**POINT_FRACTION_BITS)
                 for o, d in zip(origin, direction)]
        if max(map(abs, point)) < WHOLE_NUMBER_LIMIT:
            yield tuple(point)


def frame_lines(blobs: dict[str, reference.Blob]) -> Iterator[str]:
    """frames.csv: all formats with some tables, grey ones with each."""
    yield "blob,condition_q16,table,format,border,sampling,crc32"
    for name, blob in blobs.items():
        for condition, camera in at_conditions(blob):
            for table, remap in enumerate(camera.remaps):
                lone = dataclasses.replace(camera, remap=remap, more_remaps=())
                has_all = (name, condition, table) in TABLES_OF_ALL_FORMATS
                formats = golden.FORMAT_NAMES if has_all else golden.FORMAT_NAMES[:1]
                for index, name_of_format in enumerate(formats):
                    for mode in golden.MODES:
                        crc = golden.format_crc(lone, golden.FORMATS[index], *mode)
                        yield csv_line((name, condition, table, name_of_format,
                                        mode[0] or "keep", "nearest" if mode[1] else "bilinear",
                                        f"{crc:08x}"))


class Mutant(NamedTuple):
    """Bytes of a blob that are replaced, and what readers say of the result."""

    blob: str
    section: tuple[int, int] | None  # type and index; None: the header and the section table
    offset: int  # from the section's first byte; from its end if negative
    new_bytes: bytes
    whole_reader: str  # status without RG_ERR_
    board: str  # opening, or selecting the first table that is refused; A/B: either
    fault: str
    crcs: str = "recomputed"  # or kept


def u16(value: int) -> bytes:
    """A field of 16 bits."""
    return value.to_bytes(2, "little")


def u32(value: int) -> bytes:
    """A field of 32 bits, or of 32 bits with a sign."""
    return (value % (1 << 32)).to_bytes(4, "little")


def entry_field(index: int, field: int) -> int:
    """Offset of a field of the section table."""
    return reference.HEADER.size + index * reference.ENTRY.size + field


CAMERA, GRID, REMAP = ((kind, 0) for kind in (reference.TYPE_CAMERA, reference.TYPE_CENTRAL_GRID,
                                              reference.TYPE_REMAP))
INVERSE, STACK = (reference.TYPE_INVERSE, 0), (reference.TYPE_STACK, 0)
# The last byte of the first knot's last table, in front of its inverse grid.
END_OF_A_MASK = 987
MUTANTS = (
    Mutant("example", None, 0, b"r", "MAGIC", "MAGIC", "magic"),
    Mutant("example", None, 8, u16(2), "VERSION", "VERSION", "major version 2"),
    Mutant("example", None, 10, u16(9), "OK", "OK", "minor version 9: readers do not check it"),
    Mutant("capture", None, 10, u16(0), "OK", "OK", "minor version 0 with a section of 1.6"),
    Mutant("example", None, 12, u32(488), "TRUNCATED", "TRUNCATED", "total_size beyond the file"),
    Mutant("example", None, 12, u32(92), "HEADER", "HEADER", "total_size ends within the table"),
    Mutant("example", None, 16, u16(0), "HEADER", "HEADER", "no section"),
    Mutant("example", None, 18, u16(36), "HEADER", "HEADER", "header_size 36"),
    Mutant("example", None, 24, u32(1), "RESERVED", "OK", "reserved field of the header"),
    Mutant("example", None, entry_field(3, 12), b"\0", "HEADER_CRC", "HEADER_CRC",
           "a byte of the section table", "kept"),
    Mutant("example", GRID, 40, b"\0", "SECTION_CRC", "SECTION_CRC",
           "a byte of a section", "kept"),
    Mutant("example", None, entry_field(1, 4), u32(172), "SECTION_TABLE", "SECTION_TABLE",
           "a gap before a section"),
    Mutant("example", None, entry_field(0, 2), u16(0), "SECTION_FLAGS", "OK",
           "camera section not critical"),
    Mutant("example", None, entry_field(3, 2), u16(2), "SECTION_FLAGS", "OK", "unknown flag"),
    Mutant("example", None, entry_field(3, 0), u16(77), "OK", "OK",
           "section of an unknown type"),
    Mutant("example", None, entry_field(3, 0), u16(77) + u16(1), "SECTION_UNKNOWN",
           "SECTION_UNKNOWN", "critical section of an unknown type"),
    *(Mutant("example", None, entry_field(3, 0), u16(kind) + u16(1), "SECTION_UNKNOWN",
             "SECTION_UNKNOWN", f"section of type {kind} marked critical")
      for kind in (9, 11, 12, 13)),
    Mutant("example", None, entry_field(2, 0), u16(4), "SECTION_DUPLICATE", "OK",
           "two quality sections"),
    Mutant("example", None, entry_field(1, 0), u16(99) + u16(0), "SECTION_MISSING",
           "SECTION_MISSING", "no central grid"),
    Mutant("example", CAMERA, 0, u16(0), "IMAGE_SIZE", "REMAP_SIZE", "image width 0"),
    Mutant("example", CAMERA, 4, u32(1), "RESERVED", "OK", "reserved field of the camera"),
    Mutant("example", CAMERA, 39, b"x", "TEXT", "OK", "name without a final zero"),
    Mutant("example", GRID, 16, u16(3), "GRID_SIZE", "GRID_SIZE", "3 columns"),
    Mutant("example", GRID, 20, u32(68174085), "GRID_SCALE", "GRID_SCALE", "scale_x 1 too high"),
    Mutant("example", GRID, 28, u16(2), "GRID_CHART", "GRID_CHART", "unknown chart"),
    Mutant("example", GRID, 32, u32(36), "DATA_OFFSET", "DATA_OFFSET",
           "control points within the fields"),
    Mutant("example", GRID, 32, u32(44), "SECTION_SIZE", "SECTION_SIZE",
           "control points end too late"),
    Mutant("example", GRID, 40, u32(0x7f000001), "CONTROL_POINT", "OK",
           "a control point beyond the chart's limit"),
    Mutant("example", REMAP, 0, u16(8193), "REMAP_SIZE", "REMAP_SIZE", "output 8193 px wide"),
    Mutant("example", REMAP, 8, b"\2", "REMAP_BLOCK", "REMAP_BLOCK", "blocks of 4 px"),
    Mutant("example", REMAP, 9, b"\x0b", "REMAP_SHIFT", "REMAP_SHIFT", "residual_shift 11"),
    Mutant("example", REMAP, 12, u32(-1), "REMAP_SOURCE", "REMAP_SOURCE", "min_x -1"),
    Mutant("example", REMAP, 52, u32(0), "REMAP_CAMERA", "OK", "fx 0"),
    Mutant("example", REMAP, 28, u32(1 << 25), "REMAP_VERTEX", "OK/REMAP_VERTEX",
           "a vertex right of 8192 px"),
    Mutant("example", REMAP, -1, b"\x80", "OK", "OK", "padding of the empty-block mask"),
    Mutant("wide", INVERSE, 36, u32(0x7fffffff), "OK", "OK", "cos_limit: any value"),
    Mutant("wide", INVERSE, 30, u16(29), "GRID_CHART", "GRID_CHART",
           "inverse grid of 32 bits"),
    Mutant("lines", (reference.TYPE_LINE_POINTS, 0), 0, u16(27), "LINE_POINT", "LINE_POINT",
           "line points in q27"),
    Mutant("wide", (reference.TYPE_MASK, 0), 4, b"\1", "MASK", "OK", "mask cells of 2 px"),
    Mutant("wide", (reference.TYPE_UNCERTAINTY, 0), 0, u16(1), "UNCERTAINTY", "OK",
           "one column of uncertainties"),
    Mutant("modes", (reference.TYPE_MODES, 0), 20, b"\2", "MODE", "OK", "flip_x 2"),
    Mutant("modes", REMAP, 81, b"\x09", "MODE", "OK",
           "a table of a mode that does not exist: boards accept it"),
    Mutant("modes", REMAP, 82, b"\2", "RESERVED", "OK", "direction 2"),
    Mutant("views", REMAP, 80, b"\5", "REMAP_CAMERA", "OK", "projection 5"),
    Mutant("capture", (reference.TYPE_CAPTURE, 0), 29, b"\x09", "CAPTURE", "OK",
           "orientation 9"),
    Mutant("row_time", (reference.TYPE_ROW_TIME, 0), 0, u32((1 << 30) + 1), "ROW_TIME", "OK",
           "a row time above a millisecond"),
    Mutant("stack", STACK, 0, u16(3), "STACK", "OK", "unknown condition"),
    Mutant("stack", REMAP, 52, u32(1 << 16), "STACK", "OK", "fx that is not that of the knots"),
    Mutant("stack", STACK, END_OF_A_MASK, b"\xff", "STACK", "OK",
           "padding of a knot's empty-block mask, which is compared"),
)


def start_of(data: bytes, section: tuple[int, int] | None) -> tuple[int, int]:
    """Offsets of a section's first byte and of its end."""
    if section is None:
        return 0, reference.HEADER.size
    kind, index = section
    entries = [entry for entry in table_of(data) if entry.type == kind]
    return entries[index].offset, entries[index].offset + entries[index].size


def table_of(data: bytes) -> list[reference.Entry]:
    """The section table of a sound blob."""
    return reference.read_table(data, reference.read_header(data))


def with_crcs(data: bytes, sound: list[reference.Entry]) -> bytes:
    """All CRCs recomputed, with the sections where they were in the sound blob."""
    fixed = bytearray(data)
    for index, entry in enumerate(sound):
        crc = zlib.crc32(reference.section_bytes(data, entry))
        fixed[entry_field(index, 12):entry_field(index + 1, 0)] = u32(crc)
    fixed[28:32] = u32(reference.header_crc(bytes(fixed), len(sound)))
    return bytes(fixed)


def mutate(mutant: Mutant, data: bytes) -> tuple[int, bytes]:
    """The offset of the new bytes in the blob, and the blob with them."""
    start, end = start_of(data, mutant.section)
    offset = mutant.offset + (end if mutant.offset < 0 else start)
    changed = data[:offset] + mutant.new_bytes + data[offset + len(mutant.new_bytes):]
    return offset, with_crcs(changed, table_of(data)) if mutant.crcs == "recomputed" else changed


def status_of(data: bytes) -> str:
    """What the reference reader, a whole one, says."""
    try:
        reference.parse(data)
    except reference.BlobError as error:
        return error.status.removeprefix("RG_ERR_")
    return "OK"


def mutant_lines(blobs: dict[str, reference.Blob]) -> Iterator[str]:
    """mutants.csv."""
    yield "blob,offset,bytes,crcs,whole_reader,board,fault"
    for mutant in MUTANTS:
        offset, data = mutate(mutant, reference.serialize(blobs[mutant.blob]))
        found = status_of(data)
        assert found == mutant.whole_reader, f"{mutant.fault}: {found}"
        yield csv_line((mutant.blob, offset, mutant.new_bytes.hex(), mutant.crcs,
                        mutant.whole_reader, mutant.board, mutant.fault))


def example_lines(example: reference.Blob) -> Iterator[str]:
    """The worked example of SPEC.md: hex dump and results."""
    yield from reference.hexdump_lines(reference.serialize(example))
    yield ""
    yield from example_results(example)


def example_results(example: reference.Blob) -> Iterator[str]:
    """Directions of some pixels, and an undistorted frame."""
    grid = example.grid
    yield "x_q16,y_q16,dx_q30,dy_q30,dz_q30"
    for pixel in ((grid.x0, grid.y0), (2064384, 1540096), (grid.x1, grid.y1), (grid.x1 + 1, 0)):
        direction = reference.unproject_q16(example, *pixel)
        yield ",".join(map(str, (*pixel, *(direction or ("", "", "")))))
    size = golden.source_size(example)
    frame = bytes(x + y for y in range(size.height) for x in range(size.width))
    yield ""
    output = reference.remap_grey(example, frame, golden.BORDER)
    for start in range(0, len(output), example.remap.width):
        yield " ".join(f"{value:3d}" for value in output[start:start + example.remap.width])


def expected_files() -> dict[Path, bytes]:
    """The contents of the files of the folder."""
    blobs = make_blobs()
    files = {FOLDER / f"{name}.raygrid": reference.serialize(blob) for name, blob in blobs.items()}
    for name, lines in (("rays", ray_lines), ("projections", projection_lines),
                        ("frames", frame_lines), ("mutants", mutant_lines)):
        files[FOLDER / f"{name}.csv"] = ("\n".join(lines(blobs)) + "\n").encode()
    files[FOLDER / "example.txt"] = ("\n".join(example_lines(blobs["example"])) + "\n").encode()
    return files


def check(path: Path, contents: bytes) -> bool:
    """Whether the file holds the contents."""
    same = path.exists() and path.read_bytes() == contents
    if not same:
        print(f"{path} is not what {Path(sys.argv[0]).name} would write")
    return same


def write(path: Path, contents: bytes) -> bool:
    """Make the file hold the contents."""
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(contents)
    return True


def main() -> int:
    """Write or compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true",
                        help="compare only; exit 1 where a file differs")
    handle = check if parser.parse_args().check else write
    results = [handle(path, contents) for path, contents in expected_files().items()]
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
