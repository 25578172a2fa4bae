#!/usr/bin/env python3
"""A slow, independent reader and writer of raygrid blobs, version 1.

Written from SPEC.md alone, for comparison with the implementation in C. Section names in the
docstrings ("Header", "Central grid", ...) are those of SPEC.md. All arithmetic is in integers,
except "Meaning": unprojection in double precision, to which ray arithmetic is an approximation.
"""

import argparse
import csv
import dataclasses
import functools
import itertools
import math
import struct
import sys
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

Pair = tuple[int, int]

MAGIC = b"RAYGRID\0"
MAJOR = 1
MAX_SECTIONS = 16

# written by tools/blob_format; not for editing
HEADER = struct.Struct("<8sHHIHHIII")
ENTRY = struct.Struct("<HHIII")
CAMERA = struct.Struct("<HHI32s32s")
GRID = struct.Struct("<iiiiHHIIHHII")
PLANE = struct.Struct("<2i2i2i")
REMAP = struct.Struct("<HHHHBBBBiiii2i2i2iIIiiIII")
VIEW = struct.Struct("<BBBB9iHH")
VERTEX = struct.Struct("<hhbbbb")
MODE = struct.Struct("<HHiiIIBBHII32s")
QUALITY = struct.Struct("<IIIIIIIIII")
LINE_POINTS = struct.Struct("<HHI")
LINE_POINT = struct.Struct("<iii")
MASK = struct.Struct("<HHBBHI")
UNCERTAINTY = struct.Struct("<HHIII")
INVERSE = struct.Struct("<iiiiHHIIHHIi")
CAPTURE = struct.Struct("<iIiiIIIBBHiII")
STACK = struct.Struct("<HH")
STACK_SAMPLE = struct.Struct("<i")
ROW_TIME = struct.Struct("<iI")

TYPE_CAMERA = 1
TYPE_CENTRAL_GRID = 2
TYPE_REMAP = 3
TYPE_QUALITY = 4
TYPE_LINE_POINTS = 5
TYPE_MASK = 6
TYPE_UNCERTAINTY = 7
TYPE_MODES = 8
TYPE_INVERSE = 10
TYPE_CAPTURE = 11
TYPE_STACK = 12
TYPE_ROW_TIME = 13
CRITICAL = 1
FLAGS_OF_TYPE = {1: 1, 2: 1, 3: 0, 4: 0, 5: 1, 6: 0, 7: 0, 8: 0, 10: 0, 11: 0, 12: 0, 13: 0}
MINOR_OF_TYPE = {1: 0, 2: 0, 3: 0, 4: 0, 5: 1, 6: 1, 7: 1, 8: 5, 10: 3, 11: 6, 12: 6, 13: 6}
REQUIRED_TYPES = (1, 2)
SINGLE_TYPES = (1, 2, 4, 5, 6, 7, 8, 10, 11, 12, 13)
TYPES_SKIPPED_BY_BOARDS = (11, 12, 13)
# end of what is written
REMAP_WITH_VIEW = struct.Struct(REMAP.format + VIEW.format[1:])
CRC_COVERED_HEADER = 28

MAX_IMAGE_SIDE = 16384
MAX_REMAP_SIDE = 8192
MIN_REMAP_SOURCE = 2
TEXT_SIZE = 32
HALF_PIXEL_Q16 = 1 << 15
CONTROL_POINT_COUNTS = range(4, 1028)
CHART_STEREOGRAPHIC = 1
FRACTION_BITS = 29
NARROW_FRACTION_BITS = range(14, 29)
CONTROL_POINT_LIMIT = 0x7F000000
LAST_FRACTION = 1 - 2.0**-32
BLOCK_LOG2S = (3, 4, 5)
MAX_RESIDUAL_SHIFT = 10
BENT_BLOCK_LOG2S = (4, 5, 6)
MIN_PART_LOG2 = 3
MAX_BEND_SHIFT = 10
HAS_VIEW = 0x80  # of bend_shift's byte
PROJECTIONS = ("pinhole", "cylindrical", "equirectangular", "stereographic", "equidistant")
ONE_Q30 = 1 << 30
ROTATION_TOLERANCE_Q30 = 1 << 10
UNDISTORT, DISTORT = 0, 1
MODE_SCALES_Q16 = range(1 << 10, (64 << 16) + 1)
MODE_OFFSET_LIMIT_Q16 = 1 << 30
MAX_MODES = 255
CHROMA_PART_LOG2 = 4
VERTEX_LIMIT_Q12 = 1 << 25
CHART_LIMIT_Q27 = 1 << 29
LINE_POINT_BITS = 28
LINE_POINT_LIMIT = 0x7F000000
MASK_CELL_LOG2S = range(2, 9)
UNCERTAINTY_COUNTS = range(2, 66)
UNKNOWN_UNCERTAINTY = 0xFFFF
LENS_POSITION_LIMIT_Q16 = 1024 << 16
CROP_LIMIT = 65536
MAX_CROP_SCALE = 64
ZOOMS_Q16 = range(1 << 16, (1024 << 16) + 1)
ORIENTATIONS = range(1, 9)
TEMPERATURE_LIMIT_Q16 = 1024 << 16
EXPOSURES_US = range(1, (1 << 30) + 1)
ANALOGUE_GAINS_Q16 = range(1, (1024 << 16) + 1)
CONDITIONS = (LENS_POSITION, TEMPERATURE) = (1, 2)
KNOT_COUNTS = range(2, 65)
CONDITION_LIMIT_Q16 = 1024 << 16
WEIGHT_BITS = 14
ROW_TIME_LIMIT_Q10 = 1 << 30
KNOWS_LENS_POSITION, KNOWS_CROP, KNOWS_ZOOM, KNOWS_ORIENTATION = 1, 2, 4, 8
KNOWS_TEMPERATURE, KNOWS_EXPOSURE, KNOWS_GAIN = 16, 32, 64

EXIT_FAILURE = 1
EXIT_INVALID = 8


class BlobError(Exception):
    """A fault; `status` is the identifier of rg_status.h."""

    def __init__(self, status: str, message: str) -> None:
        super().__init__(f"{status} {message}")
        self.status = status
        self.message = message


def require(condition: bool, status: str, message: str) -> None:
    """Raise the fault unless the condition holds."""
    if not condition:
        raise BlobError(status, message)


# The data of a blob


class Header(NamedTuple):
    """Header: the fields in the order of the bytes."""

    magic: bytes
    major: int
    minor: int
    total_size: int
    section_count: int
    header_size: int
    reserved_20: int
    reserved_24: int
    header_crc: int


class Entry(NamedTuple):
    """Header: one entry of the section table."""

    type: int
    flags: int
    offset: int
    size: int
    crc: int


@dataclass(frozen=True)
class Camera:
    """Camera (type 1)."""

    width: int
    height: int
    name: str
    serial: str


@dataclass(frozen=True)
class CentralGrid:
    """Central grid (type 2); `control_points` row by row from the top, (a, b) in q29."""

    x0: int
    y0: int
    x1: int
    y1: int
    columns: int
    rows: int
    control_points: tuple[Pair, ...]
    fraction_bits: int = FRACTION_BITS  # fewer: a plane and residuals of 16 bits
    plane: tuple[int, ...] = ()  # origin, column step, row step: each a, b in q29

    @functools.cached_property
    def scale_x(self) -> int:
        """Central grid: scale_x, q32 cells per pixel."""
        return grid_scale(self.columns, self.x0, self.x1)

    @functools.cached_property
    def scale_y(self) -> int:
        """Central grid: scale_y, q32 cells per pixel."""
        return grid_scale(self.rows, self.y0, self.y1)

    @functools.cached_property
    def residuals(self) -> tuple[Pair, ...]:
        """Central grid: residuals of narrow control points relative to their plane, as stored."""
        shift = FRACTION_BITS - self.fraction_bits
        return tuple((a - plane_a >> shift, b - plane_b >> shift)
                     for (a, b), (plane_a, plane_b)
                     in zip(self.control_points, plane_points(self, self.plane)))


class Size(NamedTuple):
    """A frame's size in pixels."""

    width: int
    height: int


@dataclass(frozen=True)
class View:
    """Views: an index of PROJECTIONS, the rotation's nine numbers in q30, row by row, the size of
    the source, the mode's number or 0, and UNDISTORT or DISTORT."""

    projection: int
    rotation: tuple[int, ...]
    source: Size
    mode: int = 0
    direction: int = UNDISTORT


@dataclass(frozen=True)
class Remap:
    """Remap (type 3); `vertices` are the residuals, `empty_blocks` the bits of the mask, `bends`
    hx, hy, vx, vy of each vertex, if part_log2 is not 0."""

    width: int
    height: int
    block_log2: int
    residual_shift: int
    min_x: int
    min_y: int
    max_x: int
    max_y: int
    origin: Pair
    column_step: Pair
    row_step: Pair
    fx: int
    fy: int
    cx: int
    cy: int
    bound_upx: int
    max_error_upx: int
    vertices: tuple[Pair, ...]
    empty_blocks: tuple[bool, ...]
    part_log2: int = 0
    bend_shift: int = 0
    bends: tuple[tuple[int, int, int, int], ...] = ()
    view: View | None = None  # a pinhole in camera axes

    @property
    def columns(self) -> int:
        """Remap: vertices across."""
        return ceil_divide(self.width, 1 << self.block_log2) + 1

    @property
    def rows(self) -> int:
        """Remap: vertices down."""
        return ceil_divide(self.height, 1 << self.block_log2) + 1


@dataclass(frozen=True)
class Mode:
    """Sensor modes (type 8): one of them. Offsets and scales are q16."""

    width: int
    height: int
    offset: Pair
    scale: Pair
    flips: Pair
    name: str


@dataclass(frozen=True)
class Quality:
    """Quality (type 4); FFFFFFFFh where a value is not known."""

    training_median_upx: int
    training_rms_upx: int
    training_max_upx: int
    training_count: int
    held_out_median_upx: int
    held_out_rms_upx: int
    held_out_max_upx: int
    held_out_count: int
    packing_error_npx: int
    packing_error_prad: int


@dataclass(frozen=True)
class InverseGrid:
    """Inverse grid (type 10): a narrow `grid` over the chart in q27, whose control points are
    (x, y) in q17 px."""

    grid: CentralGrid
    cos_limit: int


@dataclass(frozen=True)
class Mask:
    """Validity mask (type 6); `bits` row by row."""

    columns: int
    rows: int
    cell_log2: int
    bits: tuple[bool, ...]


@dataclass(frozen=True)
class Uncertainty:
    """Uncertainty (type 7); `values` row by row in q12 px."""

    columns: int
    rows: int
    values: tuple[int, ...]

    def scales(self, grid: CentralGrid) -> Pair:
        """Uncertainty: scale_x and scale_y, q32 intervals per pixel."""
        return (((self.columns - 1) << 48) // (grid.x1 - grid.x0),
                ((self.rows - 1) << 48) // (grid.y1 - grid.y0))


@dataclass(frozen=True)
class Capture:
    """Capture (type 11), field by field; None or () if unknown. Dioptres are q16."""

    lens_position: int | None = None
    lens_tolerance: int | None = None
    crop: tuple[int, ...] = ()  # x, y, width, height
    zoom: int | None = None
    orientation: int | None = None
    temperature: int | None = None  # q16 degrees Celsius
    exposure: int | None = None  # microseconds
    gain: int | None = None  # q16


@dataclass(frozen=True)
class Knot:
    """Operating points: the camera at one value of the condition."""

    grid: CentralGrid
    inverse: InverseGrid | None
    remaps: tuple[Remap, ...]


@dataclass(frozen=True)
class Stack:
    """Operating points (type 12); `values` in q16, of the knots in their order."""

    condition: int
    values: tuple[int, ...]
    knots: tuple[Knot, ...]


@dataclass(frozen=True)
class BlendedGrid(CentralGrid):
    """Operating points, "Rays at an operating point": a grid of the lower sample, to be
    blended with that of the upper sample."""

    upper: CentralGrid | None = None
    weight: int = 0  # weight of the upper sample, q14


@dataclass(frozen=True)
class RowTime:
    """Line delay (type 13), q10 nanoseconds."""

    row_time: int
    deviation: int


@dataclass(frozen=True)
class Blob:
    """The contents that this reader takes from a blob; `remap` is the first remap section."""


    camera: Camera
    grid: CentralGrid
    remap: Remap | None = None
    quality: Quality | None = None
    inverse: InverseGrid | None = None
    more_remaps: tuple[Remap, ...] = ()
    line_points: tuple[tuple[int, int, int], ...] | None = None
    mask: Mask | None = None
    uncertainty: Uncertainty | None = None
    modes: tuple[Mode, ...] = ()
    capture: Capture | None = None
    stack: Stack | None = None
    row_time: RowTime | None = None

    @property
    def remaps(self) -> tuple[Remap, ...]:
        """All remap sections."""
        return () if self.remap is None else (self.remap, *self.more_remaps)


def ceil_divide(a: int, b: int) -> int:
    """Return a / b, rounded up."""
    return -(-a // b)


def grid_scale(count: int, low: int, high: int) -> int:
    """Central grid: q32 cells per pixel of an axis from its control points and its area."""
    require(low < high, "RG_ERR_AREA", "the calibrated area is empty")
    return ((count - 3) << 48) // (high - low)


def mask_size(blocks: int) -> int:
    """Remap: bytes of the empty-block mask, padded to a multiple of 4."""
    return ceil_divide(blocks, 32) * 4


def block_count(remap: Remap) -> int:
    """Remap: number of bits of the empty-block mask that correspond to a block."""
    return (remap.columns - 1) * (remap.rows - 1)


# Reading: header and section table


def read_header(data: bytes) -> Header:
    """Requirements, "A reader": from the magic to the section count."""
    require(len(data) >= HEADER.size, "RG_ERR_TRUNCATED", f"{len(data)} bytes hold no header")
    header = Header(*HEADER.unpack_from(data))
    require(header.magic == MAGIC, "RG_ERR_MAGIC", f"magic is {header.magic.hex(' ')}")
    require(header.major == MAJOR, "RG_ERR_VERSION", f"major version is {header.major}")
    check_total_size(header.total_size, len(data))
    require(header.header_size == HEADER.size, "RG_ERR_HEADER",
            f"header_size is {header.header_size}")
    check_section_count(header)
    return header


def check_total_size(total_size: int, given: int) -> None:
    """Header: total_size against the bytes given, which may be more."""
    require(total_size <= given, "RG_ERR_TRUNCATED",
            f"total_size is {total_size}, but {given} bytes are given")
    require(total_size % 4 == 0, "RG_ERR_HEADER",
            f"total_size {total_size} is not a multiple of 4")


def check_section_count(header: Header) -> None:
    """Header: section_count in its limits, and the table within total_size."""
    count = header.section_count
    require(1 <= count <= MAX_SECTIONS, "RG_ERR_HEADER", f"section_count is {count}")
    require(table_end(count) <= header.total_size, "RG_ERR_HEADER",
            f"total_size {header.total_size} cannot hold a table of {count} sections")


def table_end(section_count: int) -> int:
    """Header: the offset of the first byte after the section table."""
    return HEADER.size + section_count * ENTRY.size


def header_crc(data: bytes, section_count: int) -> int:
    """Header: CRC over bytes 0 to 27, continued over the section table."""
    crc = zlib.crc32(data[:CRC_COVERED_HEADER])
    return zlib.crc32(data[HEADER.size:table_end(section_count)], crc)


def read_table(data: bytes, header: Header) -> list[Entry]:
    """Requirements, "A reader": from header_crc to the duplicate and missing sections."""
    crc = header_crc(data, header.section_count)
    require(crc == header.header_crc, "RG_ERR_HEADER_CRC",
            f"header_crc is {header.header_crc:08x}, not {crc:08x}")
    require(header.reserved_20 == 0 and header.reserved_24 == 0, "RG_ERR_RESERVED",
            "a reserved field of the header is not 0")
    table_bytes = data[HEADER.size:table_end(header.section_count)]
    table = [Entry(*fields) for fields in ENTRY.iter_unpack(table_bytes)]
    check_tiling(table, header.total_size)
    check_section_crcs(data, table)
    check_flags(table)
    check_occurrence([entry.type for entry in table])
    return table


def check_tiling(table: list[Entry], total_size: int) -> None:
    """Header: the sections tile the rest of the blob, in the order of the table."""
    position = table_end(len(table))
    for index, entry in enumerate(table):
        require(entry.offset == position, "RG_ERR_SECTION_TABLE",
                f"section {index} starts at {entry.offset}, not at {position}")
        require(entry.size > 0 and entry.size % 4 == 0, "RG_ERR_SECTION_TABLE",
                f"section {index} has a size of {entry.size}")
        position += entry.size
        require(position <= total_size, "RG_ERR_SECTION_TABLE",
                f"section {index} ends at {position}, beyond total_size {total_size}")
    require(position == total_size, "RG_ERR_SECTION_TABLE",
            f"the last section ends at {position}, not at total_size {total_size}")


def section_bytes(data: bytes, entry: Entry) -> bytes:
    """The bytes of one section."""
    return data[entry.offset:entry.offset + entry.size]


def check_section_crcs(data: bytes, table: list[Entry]) -> None:
    """Header: CRC over each section's bytes."""
    for index, entry in enumerate(table):
        crc = zlib.crc32(section_bytes(data, entry))
        require(crc == entry.crc, "RG_ERR_SECTION_CRC",
                f"the crc of section {index} is {entry.crc:08x}, not {crc:08x}")


def check_flags(table: list[Entry]) -> None:
    """Header: flags of each section, and no unknown section that is critical."""
    for index, entry in enumerate(table):
        require(entry.flags & ~CRITICAL == 0, "RG_ERR_SECTION_FLAGS",
                f"section {index} has flags {entry.flags:#x}")
        if entry.type in FLAGS_OF_TYPE and entry.type not in TYPES_SKIPPED_BY_BOARDS:
            require(entry.flags == FLAGS_OF_TYPE[entry.type], "RG_ERR_SECTION_FLAGS",
                    f"section {index} of type {entry.type} has flags {entry.flags:#x}")
        else:
            require(entry.flags != CRITICAL, "RG_ERR_SECTION_UNKNOWN",
                    f"section {index} is critical and of unknown type {entry.type}")


def check_occurrence(types: list[int]) -> None:
    """Header: types that occur at most once, and required types."""
    for single in SINGLE_TYPES:
        require(types.count(single) <= 1, "RG_ERR_SECTION_DUPLICATE",
                f"there are {types.count(single)} sections of type {single}")
    for required in REQUIRED_TYPES:
        require(required in types, "RG_ERR_SECTION_MISSING",
                f"there is no section of type {required}")


# Reading: sections


def parse(data: bytes) -> Blob:
    """Requirements, "A reader": perform all checks in the specified order."""
    table = read_table(data, read_header(data))
    camera = read_camera(first_section(data, table, TYPE_CAMERA))
    grid = read_grid(first_section(data, table, TYPE_CENTRAL_GRID), camera)
    sizes = mode_sizes(next(sections(data, table, TYPE_MODES), b""))
    readers = {TYPE_REMAP: lambda section: read_remap(section, camera, sizes),
               TYPE_MODES: read_modes,
               TYPE_QUALITY: read_quality,
               TYPE_LINE_POINTS: lambda section: read_line_points(section, grid),
               TYPE_MASK: lambda section: read_valid_mask(section, camera),
               TYPE_UNCERTAINTY: lambda section: read_uncertainty(section, grid),
               TYPE_INVERSE: read_inverse,
               TYPE_CAPTURE: lambda section: read_capture(section, camera),
               TYPE_STACK: lambda section: read_stack(section, data, table),
               TYPE_ROW_TIME: read_row_time}
    found = {kind: [] for kind in readers}
    for entry in table:
        if entry.type in readers:
            found[entry.type].append(readers[entry.type](section_bytes(data, entry)))
    first = {kind: next(iter(values), None) for kind, values in found.items()}
    return Blob(camera, grid, first[TYPE_REMAP], first[TYPE_QUALITY], first[TYPE_INVERSE],
                tuple(found[TYPE_REMAP][1:]), first[TYPE_LINE_POINTS], first[TYPE_MASK],
                first[TYPE_UNCERTAINTY], first[TYPE_MODES] or (), first[TYPE_CAPTURE],
                first[TYPE_STACK], first[TYPE_ROW_TIME])


def sections(data: bytes, table: list[Entry], wanted: int) -> Iterator[bytes]:
    """The sections of a type, in the order of the table."""
    return (section_bytes(data, entry) for entry in table if entry.type == wanted)


def first_section(data: bytes, table: list[Entry], wanted: int) -> bytes:
    """The first section of a type that is present."""
    return next(sections(data, table, wanted))


def unpack_fields(layout: struct.Struct, section: bytes, what: str) -> tuple:
    """Sections: the fields at the start of a section, which may be followed by other data."""
    require(len(section) >= layout.size, "RG_ERR_SECTION_SIZE",
            f"the {what} section has {len(section)} bytes, fewer than {layout.size}")
    return layout.unpack_from(section)


def check_data_offset(data_offset: int, layout: struct.Struct, what: str) -> None:
    """Sections: data_offset is a multiple of 4 and at least the size of the fields."""
    require(data_offset % 4 == 0 and data_offset >= layout.size, "RG_ERR_DATA_OFFSET",
            f"data_offset of the {what} is {data_offset}")


def array_bytes(section: bytes, data_offset: int, size: int, what: str) -> bytes:
    """Sections: the arrays, which fill the section exactly from data_offset to its end."""
    require(len(section) == data_offset + size, "RG_ERR_SECTION_SIZE",
            f"the {what} section has {len(section)} bytes, not {data_offset} + {size}")
    return section[data_offset:]


def read_camera(section: bytes) -> Camera:
    """Camera (type 1)."""
    width, height, reserved, name, serial = unpack_fields(CAMERA, section, "camera")
    for side in (width, height):
        require(1 <= side <= MAX_IMAGE_SIDE, "RG_ERR_IMAGE_SIZE",
                f"the image has {width} x {height} pixels")
    require(reserved == 0, "RG_ERR_RESERVED", "the reserved field of the camera is not 0")
    return Camera(width, height, read_text(name, "name"), read_text(serial, "serial"))


def read_text(field: bytes, what: str) -> str:
    """Camera: text up to the first zero; invalid UTF-8 is accepted."""
    require(field[-1] == 0, "RG_ERR_TEXT", f"{what} does not end with a zero")
    text = field.partition(b"\0")[0]
    return text.decode("utf-8", errors="replace")


def read_grid(section: bytes, camera: Camera) -> CentralGrid:
    """Central grid (type 2)."""
    fields = unpack_fields(GRID, section, "grid")
    grid = CentralGrid(*fields[:6], control_points=())
    scale_x, scale_y, chart, fraction_bits, data_offset, reserved = fields[6:]
    check_area(grid.x0, grid.x1, camera.width, "x")
    check_area(grid.y0, grid.y1, camera.height, "y")
    check_grid_size(grid)
    check_grid_scale(grid, scale_x, scale_y)
    require(chart == CHART_STEREOGRAPHIC
            and fraction_bits in (*NARROW_FRACTION_BITS, FRACTION_BITS),
            "RG_ERR_GRID_CHART", f"chart is {chart}, fraction_bits {fraction_bits}")
    check_data_offset(data_offset, GRID, "grid")
    require(reserved == 0, "RG_ERR_RESERVED", "the reserved field of the grid is not 0")
    if fraction_bits == FRACTION_BITS:
        array = array_bytes(section, data_offset, 8 * grid.columns * grid.rows, "grid")
        return dataclasses.replace(grid, control_points=read_control_points(array))
    return read_narrow_points(section, data_offset, grid, fraction_bits)


def read_narrow_points(section: bytes, data_offset: int, grid: CentralGrid,
                       fraction_bits: int) -> CentralGrid:
    """Central grid: a plane and residuals of 16 bits."""
    array = array_bytes(section, data_offset, PLANE.size + 4 * grid.columns * grid.rows, "grid")
    plane = PLANE.unpack_from(array)
    check_plane(grid, plane, fraction_bits)
    residuals = struct.iter_unpack("<hh", array[PLANE.size:])
    points = tuple((a + r, b + s) for (a, b), r, s in zip(
        plane_points(grid, plane), *zip(*(
            (r << FRACTION_BITS - fraction_bits, s << FRACTION_BITS - fraction_bits)
            for r, s in residuals))))
    return dataclasses.replace(grid, control_points=points, fraction_bits=fraction_bits,
                               plane=plane)


def plane_points(grid: CentralGrid, plane: tuple[int, ...]) -> Iterator[Pair]:
    """Central grid: origin + i column_step + j row_step, q29, row by row."""
    for j in range(grid.rows):
        for i in range(grid.columns):
            yield tuple(plane[c] + i * plane[2 + c] + j * plane[4 + c] for c in (0, 1))


def check_plane(grid: CentralGrid, plane: tuple[int, ...], fraction_bits: int) -> None:
    """Central grid: at the corners, the plane plus any residual is within the limit."""
    limit = CONTROL_POINT_LIMIT - (1 << 44 - fraction_bits)
    for point in plane_points(grid, plane):
        require(max(map(abs, point)) <= limit, "RG_ERR_CONTROL_POINT",
                f"the plane reaches {point}")


def check_area(low: int, high: int, side: int, axis: str) -> None:
    """Central grid: -1/2 <= low < high <= side - 1/2, in q16."""
    require(-HALF_PIXEL_Q16 <= low < high <= (side << 16) - HALF_PIXEL_Q16, "RG_ERR_AREA",
            f"the area reaches in {axis} from {low / 65536} to {high / 65536} of {side} px")


def check_grid_size(grid: CentralGrid) -> None:
    """Central grid: limits of columns and rows."""
    for count in (grid.columns, grid.rows):
        require(count in CONTROL_POINT_COUNTS, "RG_ERR_GRID_SIZE",
                f"there are {grid.columns} x {grid.rows} control points")


def check_grid_scale(grid: CentralGrid, scale_x: int, scale_y: int) -> None:
    """Central grid: the stored scale_x and scale_y follow from area and size."""
    require((scale_x, scale_y) == (grid.scale_x, grid.scale_y), "RG_ERR_GRID_SCALE",
            f"the scales are {scale_x}, {scale_y}, not {grid.scale_x}, {grid.scale_y}")


def read_control_points(array: bytes) -> tuple[Pair, ...]:
    """Central grid: control points, each coordinate of magnitude at most 7F000000h."""
    points = tuple(struct.iter_unpack("<ii", array))
    for index, (a, b) in enumerate(points):
        require(max(abs(a), abs(b)) <= CONTROL_POINT_LIMIT, "RG_ERR_CONTROL_POINT",
                f"control point {index} is ({a}, {b})")
    return points


def mode_sizes(section: bytes) -> list[Size]:
    """Sensor modes: sizes for the checks of tables, regardless of the order of sections."""
    whole = section[:len(section) // MODE.size * MODE.size]
    return [Size(*fields[:2]) for fields in MODE.iter_unpack(whole)]


def read_modes(section: bytes) -> tuple[Mode, ...]:
    """Sensor modes (type 8)."""
    require(len(section) % MODE.size == 0 and 1 <= len(section) // MODE.size <= MAX_MODES,
            "RG_ERR_SECTION_SIZE", f"the modes have {len(section)} bytes")
    return tuple(map(read_mode, MODE.iter_unpack(section)))


def read_mode(fields: tuple) -> Mode:
    """Sensor modes: one of them."""
    width, height, *numbers, name = fields
    offset, scale, flips, reserved = numbers[:2], numbers[2:4], numbers[4:6], numbers[6:]
    require(not any(reserved), "RG_ERR_RESERVED", f"reserved fields of the mode are {reserved}")
    text = read_text(name, "mode")
    require(all(1 <= side <= MAX_IMAGE_SIDE for side in (width, height))
            and all(abs(edge) < MODE_OFFSET_LIMIT_Q16 for edge in offset)
            and all(size in MODE_SCALES_Q16 for size in scale)
            and all(flip in (0, 1) for flip in flips), "RG_ERR_MODE", f"the mode is {fields}")
    return Mode(width, height, tuple(offset), tuple(scale), tuple(flips), text)


def read_remap(section: bytes, camera: Camera, modes: list[Size]) -> Remap:
    """Remap (type 3)."""
    fields = unpack_fields(REMAP, section, "remap")
    layout = REMAP_WITH_VIEW if fields[7] & HAS_VIEW else REMAP
    fields = unpack_fields(layout, section, "remap")
    width, height, columns, rows, block_log2, residual_shift, part_log2 = fields[:7]
    bend_shift = fields[7] & ~HAS_VIEW
    remap = Remap(width, height, block_log2, residual_shift, *fields[8:12], fields[12:14],
                  fields[14:16], fields[16:18], *fields[18:24], vertices=(), empty_blocks=(),
                  part_log2=part_log2, bend_shift=bend_shift, view=read_view(fields[25:]))
    data_offset = fields[24]
    source = camera if remap.view is None else remap.view.source
    check_remap_size(remap)
    check_remap_blocks(remap, columns, rows)
    require(residual_shift <= MAX_RESIDUAL_SHIFT, "RG_ERR_REMAP_SHIFT",
            f"residual_shift is {residual_shift}")
    require(bend_shift <= MAX_BEND_SHIFT, "RG_ERR_REMAP_SHIFT", f"bend_shift is {bend_shift}")
    check_data_offset(data_offset, layout, "remap")
    remap = read_remap_arrays(section, data_offset, remap)
    check_source(remap, source)
    require(remap.fx != 0 and remap.fy != 0, "RG_ERR_REMAP_CAMERA", "fx or fy is 0")
    if remap.view is not None:
        check_view(remap, camera, modes)
    return remap


def read_view(fields: tuple[int, ...]) -> View | None:
    """Views: projection, reserved fields and rotation."""
    if not fields:
        return None
    projection, mode, direction, reserved = fields[:4]
    require(reserved == 0, "RG_ERR_RESERVED", f"the reserved field of the view is {reserved}")
    return View(projection, fields[4:13], Size(*fields[13:]), mode, direction)


def check_view(remap: Remap, camera: Camera, modes: list[Size]) -> None:
    """Views: projection, rotation and direction; real frames have the size of the
    specified mode, or of the camera's images."""
    view = remap.view
    rotation = view.rotation
    require(view.direction in (UNDISTORT, DISTORT), "RG_ERR_RESERVED",
            f"direction is {view.direction}")
    require(view.projection < len(PROJECTIONS), "RG_ERR_REMAP_CAMERA",
            f"projection is {view.projection}")
    require(is_rotation([rotation[:3], rotation[3:6], rotation[6:]]), "RG_ERR_REMAP_CAMERA",
            f"{rotation} is no rotation")
    require(view.mode <= len(modes), "RG_ERR_MODE", f"there is no mode {view.mode}")
    real = modes[view.mode - 1] if view.mode else camera
    frames = remap if view.direction == DISTORT else view.source
    require((frames.width, frames.height) == (real.width, real.height), "RG_ERR_REMAP_SIZE",
            f"real frames have {frames.width} x {frames.height} pixels")


def is_rotation(rows: list[tuple[int, ...]]) -> bool:
    """Views: the rotation matrix is orthonormal within the tolerance, with determinant 1."""
    def product(a: Iterable[int], b: Iterable[int]) -> int:
        total = sum(x * y for x, y in zip(a, b))
        return abs(total) // ONE_Q30 * (1 if total > 0 else -1)
    if any(abs(value) > ONE_Q30 for row in rows for value in row):
        return False
    (a, b, c), (d, e, f), third = rows
    return product((b * f - c * e, c * d - a * f, a * e - b * d), third) > 0 and all(
        abs(product(rows[i], rows[j]) - (i == j) * ONE_Q30) <= ROTATION_TOLERANCE_Q30
        for i in range(3) for j in range(i, 3))


def check_remap_size(remap: Remap) -> None:
    """Remap: limits of the size of the output."""
    for side in (remap.width, remap.height):
        require(1 <= side <= MAX_REMAP_SIDE, "RG_ERR_REMAP_SIZE",
                f"the output has {remap.width} x {remap.height} pixels")


def check_source(remap: Remap, source: Camera | Size) -> None:
    """Remap: limits of the source's size, and its rectangle."""
    for side in (source.width, source.height):
        require(MIN_REMAP_SOURCE <= side <= MAX_REMAP_SIDE, "RG_ERR_REMAP_SIZE",
                f"the source has {source.width} x {source.height} pixels")
    check_source_range(remap.min_x, remap.max_x, source.width, "x")
    check_source_range(remap.min_y, remap.max_y, source.height, "y")


def check_remap_blocks(remap: Remap, columns: int, rows: int) -> None:
    """Remap: block_log2, part_log2, and columns and rows, which follow from the size of the
    output."""
    if remap.part_log2 == 0:
        require(remap.bend_shift == 0, "RG_ERR_RESERVED", "bend_shift without bends")
        allowed = remap.block_log2 in BLOCK_LOG2S
    else:
        allowed = (remap.block_log2 in BENT_BLOCK_LOG2S
                   and MIN_PART_LOG2 <= remap.part_log2 < remap.block_log2)
    require(allowed, "RG_ERR_REMAP_BLOCK",
            f"block_log2 is {remap.block_log2}, part_log2 {remap.part_log2}")
    require((columns, rows) == (remap.columns, remap.rows), "RG_ERR_REMAP_BLOCK",
            f"there are {columns} x {rows} vertices, not {remap.columns} x {remap.rows}")


def check_source_range(low: int, high: int, side: int, axis: str) -> None:
    """Remap: 0 <= low <= high <= side - 1, in q12."""
    require(0 <= low <= high <= (side - 1) << 12, "RG_ERR_REMAP_SOURCE",
            f"the source reaches in {axis} from {low / 4096} to {high / 4096} of {side} px")


def read_remap_arrays(section: bytes, data_offset: int, remap: Remap) -> Remap:
    """Remap: the vertices, with their bends, and the empty-block mask."""
    blocks = block_count(remap)
    layout = vertex_layout(remap)
    vertices_size = layout.size * remap.columns * remap.rows
    array = array_bytes(section, data_offset, vertices_size + mask_size(blocks), "remap")
    entries = tuple(layout.iter_unpack(array[:vertices_size]))
    full = dataclasses.replace(
        remap, vertices=tuple(entry[:2] for entry in entries),
        bends=tuple(entry[2:] for entry in entries) if remap.part_log2 else ())
    check_vertices(full)
    return dataclasses.replace(full, empty_blocks=read_mask(array[vertices_size:], blocks))


def vertex_layout(remap: Remap) -> struct.Struct:
    """Remap: a vertex with or without bends."""
    return VERTEX if remap.part_log2 else struct.Struct("<2h")


def check_vertices(remap: Remap) -> None:
    """Remap: every source position lies strictly between -2^25 and 2^25."""
    for index, position in enumerate(vertex_positions(remap)):
        require(max(map(abs, position)) < VERTEX_LIMIT_Q12, "RG_ERR_REMAP_VERTEX",
                f"vertex {index} lies at {position[0] / 4096}, {position[1] / 4096} px")


def read_mask(mask: bytes, blocks: int) -> tuple[bool, ...]:
    """Remap: bit k of the mask is bit k mod 8 of byte floor(k / 8); the padding is zero."""
    bits = [bool(byte >> bit & 1) for byte in mask for bit in range(8)]
    return tuple(bits[:blocks])


def read_quality(section: bytes) -> Quality:
    """Quality (type 4)."""
    return Quality(*unpack_fields(QUALITY, section, "quality"))


def read_inverse(section: bytes) -> InverseGrid:
    """Inverse grid (type 10)."""
    fields = unpack_fields(INVERSE, section, "inverse grid")
    grid = CentralGrid(*fields[:6], control_points=())
    scale_a, scale_b, chart, fraction_bits, data_offset, cos_limit = fields[6:]
    for low, high in ((grid.x0, grid.x1), (grid.y0, grid.y1)):
        require(-CHART_LIMIT_Q27 <= low < high <= CHART_LIMIT_Q27, "RG_ERR_AREA",
                f"the inverse grid reaches from {low} to {high}")
    check_grid_size(grid)
    check_grid_scale(grid, scale_a, scale_b)
    require(chart == CHART_STEREOGRAPHIC and fraction_bits in NARROW_FRACTION_BITS,
            "RG_ERR_GRID_CHART", f"chart is {chart}, fraction_bits {fraction_bits}")
    check_data_offset(data_offset, INVERSE, "inverse grid")
    return InverseGrid(read_narrow_points(section, data_offset, grid, fraction_bits), cos_limit)


def read_line_points(section: bytes, grid: CentralGrid) -> tuple[tuple[int, int, int], ...]:
    """Line points (type 5)."""
    bits, reserved, data_offset = unpack_fields(LINE_POINTS, section, "line points")
    require(bits == LINE_POINT_BITS, "RG_ERR_LINE_POINT", f"fraction_bits is {bits}")
    require(reserved == 0, "RG_ERR_RESERVED", "the reserved field of the line points is not 0")
    check_data_offset(data_offset, LINE_POINTS, "line points")
    array = array_bytes(section, data_offset, 12 * grid.columns * grid.rows, "line points")
    points = tuple(LINE_POINT.iter_unpack(array))
    for index, point in enumerate(points):
        require(max(map(abs, point)) <= LINE_POINT_LIMIT, "RG_ERR_LINE_POINT",
                f"line point {index} is {point}")
    return points


def read_valid_mask(section: bytes, camera: Camera) -> Mask:
    """Validity mask (type 6)."""
    columns, rows, log2, reserved_5, reserved_6, data_offset = unpack_fields(
        MASK, section, "mask")
    require(reserved_5 == 0 and reserved_6 == 0, "RG_ERR_RESERVED",
            "a reserved field of the mask is not 0")
    require(log2 in MASK_CELL_LOG2S and columns == ceil_divide(camera.width, 1 << log2)
            and rows == ceil_divide(camera.height, 1 << log2), "RG_ERR_MASK",
            f"the mask has {columns} x {rows} cells of 2^{log2} px")
    check_data_offset(data_offset, MASK, "mask")
    array = array_bytes(section, data_offset, mask_size(columns * rows), "mask")
    return Mask(columns, rows, log2, read_mask(array, columns * rows))


def read_uncertainty(section: bytes, grid: CentralGrid) -> Uncertainty:
    """Uncertainty (type 7)."""
    columns, rows, *scales, data_offset = unpack_fields(UNCERTAINTY, section, "uncertainty")
    found = Uncertainty(columns, rows, ())
    require(columns in UNCERTAINTY_COUNTS and rows in UNCERTAINTY_COUNTS
            and found.scales(grid) == tuple(scales), "RG_ERR_UNCERTAINTY",
            f"there are {columns} x {rows} uncertainties, scales {scales}")
    check_data_offset(data_offset, UNCERTAINTY, "uncertainty")
    count = columns * rows
    array = array_bytes(section, data_offset, ceil_divide(count, 2) * 4, "uncertainty")
    values = struct.unpack(f"<{len(array) // 2}H", array)
    return dataclasses.replace(found, values=values[:count])


def read_capture(section: bytes, camera: Camera) -> Capture:
    """Capture (type 11)."""
    fields = unpack_fields(CAPTURE, section, "capture")
    position, tolerance, *crop, zoom, known, orientation, reserved, degrees, exposure, gain = fields
    require(reserved == 0, "RG_ERR_RESERVED", "the reserved field of the capture is not 0")
    require(0 < known <= 127 and all(
        in_range if known & bit else not any(values) for bit, values, in_range in (
            (KNOWS_LENS_POSITION, (position, tolerance),
             max(abs(position), tolerance) <= LENS_POSITION_LIMIT_Q16),
            (KNOWS_CROP, crop, is_crop(crop, camera)),
            (KNOWS_ZOOM, (zoom,), zoom in ZOOMS_Q16),
            (KNOWS_ORIENTATION, (orientation,), orientation in ORIENTATIONS),
            (KNOWS_TEMPERATURE, (degrees,), abs(degrees) <= TEMPERATURE_LIMIT_Q16),
            (KNOWS_EXPOSURE, (exposure,), exposure in EXPOSURES_US),
            (KNOWS_GAIN, (gain,), gain in ANALOGUE_GAINS_Q16))),
        "RG_ERR_CAPTURE", f"the capture is {fields}")
    return Capture(*(value if known & bit else None for bit, value in (
        (KNOWS_LENS_POSITION, position), (KNOWS_LENS_POSITION, tolerance))),
        tuple(crop) if known & KNOWS_CROP else (),
        zoom if known & KNOWS_ZOOM else None,
        *(value if known & bit else None for bit, value in (
            (KNOWS_ORIENTATION, orientation), (KNOWS_TEMPERATURE, degrees),
            (KNOWS_EXPOSURE, exposure), (KNOWS_GAIN, gain))))


def knot_parts(data: bytes, table: list[Entry]) -> list[tuple[int, bytes]]:
    """Operating points: type and bytes of the blob's own sections that also occur in samples."""
    entries = [entry for entry in table if entry.type in (TYPE_CENTRAL_GRID, TYPE_INVERSE, TYPE_REMAP)]
    require(entries[0].type == TYPE_CENTRAL_GRID and table[-1].type == TYPE_STACK
            and entries == table[-1 - len(entries):-1],
            "RG_ERR_STACK", "sections that knots have a part for are not together in front of the stack")
    return [(entry.type, section_bytes(data, entry)) for entry in entries]


def read_stack(section: bytes, data: bytes, table: list[Entry]) -> Stack:
    """Operating points (type 12)."""
    condition, count = unpack_fields(STACK, section, "stack")
    require(condition in CONDITIONS and count in KNOT_COUNTS
            and not any(sections(data, table, TYPE_LINE_POINTS)), "RG_ERR_STACK",
            f"the stack has {count} knots of condition {condition}")
    own = knot_parts(data, table)
    parts_size = sum(len(part) for _, part in own)
    knot_size = parts_size + STACK_SAMPLE.size
    array = array_bytes(section, STACK.size, count * knot_size, "stack")
    whole = [array[k * knot_size:(k + 1) * knot_size] for k in range(count)]
    values = tuple(STACK_SAMPLE.unpack_from(knot, parts_size)[0] for knot in whole)
    require(all(low < high for low, high in zip(values, values[1:]))
            and max(map(abs, values)) <= CONDITION_LIMIT_Q16, "RG_ERR_STACK",
            f"the values are {values}")
    camera = read_camera(first_section(data, table, TYPE_CAMERA))
    sizes = mode_sizes(next(sections(data, table, TYPE_MODES), b""))
    knots = []
    for knot in whole:
        position = 0
        found = {TYPE_CENTRAL_GRID: [], TYPE_INVERSE: [], TYPE_REMAP: []}
        for kind, like in own:
            part = knot[position:position + len(like)]
            position += len(like)
            found[kind].append(read_knot_part(kind, part, like, camera, sizes))
        knots.append(Knot(found[TYPE_CENTRAL_GRID][0], next(iter(found[TYPE_INVERSE]), None),
                          tuple(found[TYPE_REMAP])))
    return Stack(condition, values, tuple(knots))


def read_knot_part(kind: int, part: bytes, like: bytes, camera: Camera,
                   sizes: list[Size]) -> CentralGrid | InverseGrid | Remap:
    """Operating points: a grid or a table of a sample, with the blob's own fields and mask."""
    if kind == TYPE_REMAP:
        read = read_remap(part, camera, sizes)
        data_offset = REMAP.unpack_from(part)[24]
        mask = len(part) - mask_size(block_count(read))
        same = part[mask:] == like[mask:]
    else:
        read = read_grid(part, camera) if kind == TYPE_CENTRAL_GRID else read_inverse(part)
        data_offset = GRID.unpack_from(part)[10]
        same = True
    require(same and knot_fields(kind, part, data_offset) == knot_fields(kind, like, data_offset),
            "RG_ERR_STACK", "a knot has other fields than the blob")
    return read


def knot_fields(kind: int, section: bytes, data_offset: int) -> bytes:
    """Operating points: the bytes before the arrays, without the tables' max_error_upx."""
    fields = section[:data_offset]
    return fields[:72] + fields[76:] if kind == TYPE_REMAP else fields


def read_row_time(section: bytes) -> RowTime:
    """Line delay (type 13)."""
    row_time = RowTime(*unpack_fields(ROW_TIME, section, "row time"))
    require(max(abs(row_time.row_time), row_time.deviation) <= ROW_TIME_LIMIT_Q10,
            "RG_ERR_ROW_TIME", f"the row time is {row_time}")
    return row_time


def is_crop(crop: list[int], camera: Camera) -> bool:
    """Capture: whether the crop is within the limits."""
    return all(abs(start) <= CROP_LIMIT and 1 <= span <= CROP_LIMIT
               and span <= MAX_CROP_SCALE * side and side <= MAX_CROP_SCALE * span
               for start, span, side in zip(crop[:2], crop[2:], (camera.width, camera.height)))


# Conditions


def weight_at(stack: Stack, value: int) -> Pair:
    """Operating points, "Selecting samples": the lower sample, and the upper one's weight, q14."""
    values = stack.values
    clamped = min(max(value, values[0]), values[-1])
    lower = max(k for k, knot_value in enumerate(values) if knot_value <= clamped)
    if lower == len(values) - 1:
        return lower, 0
    return lower, ((clamped - values[lower]) << WEIGHT_BITS) // (values[lower + 1] - values[lower])


def at_condition(blob: Blob, value: int) -> Blob:
    """Operating points: the camera at a value of the condition, in q16."""
    if blob.stack is None:
        raise BlobError("RG_ERR_NO_STACK", "the blob has no stack")
    k, weight = weight_at(blob.stack, value)
    lower, upper = blob.stack.knots[k], blob.stack.knots[k + (weight != 0)]
    inverse = lower.inverse and dataclasses.replace(
        lower.inverse, grid=blended_grid(lower.inverse.grid, upper.inverse.grid, weight))
    remap, *others = (*map(functools.partial(blended_remap, weight=weight),
                           lower.remaps, upper.remaps), None)
    return dataclasses.replace(
        blob, grid=blended_grid(lower.grid, upper.grid, weight), inverse=inverse, remap=remap,
        more_remaps=tuple(others[:-1]), stack=None)


def blended_grid(lower: CentralGrid, upper: CentralGrid, weight: int) -> CentralGrid:
    """Operating points, "Rays at an operating point": two grids as one."""
    if weight == 0:
        return lower
    fields = {field.name: getattr(lower, field.name) for field in dataclasses.fields(lower)}
    return BlendedGrid(**fields, upper=upper, weight=weight)


def blended_remap(lower: Remap, upper: Remap, weight: int) -> Remap:
    """Operating points, "A table at an operating point": with blended residuals and bends."""
    def blend(pairs: tuple, others: tuple) -> tuple:
        return tuple(tuple(blended(p, q, weight) for p, q in zip(*both))
                     for both in zip(pairs, others))
    return dataclasses.replace(lower, vertices=blend(lower.vertices, upper.vertices),
                               bends=blend(lower.bends, upper.bends))


def blended(p: int, q: int, weight: int) -> int:
    """Operating points, "A table at an operating point": a residual or a bend."""
    return p + (fit(weight * (q - p) + (1 << WEIGHT_BITS - 1), 32) >> WEIGHT_BITS)


# Meaning


def unproject(blob: Blob, x_px: float, y_px: float) -> tuple[float, float, float] | None:
    """Central grid, "Meaning": the direction of a pixel, None outside the area."""
    grid = blob.grid
    across = locate(x_px, grid.x0, grid.x1, grid.scale_x, grid.columns)
    down = locate(y_px, grid.y0, grid.y1, grid.scale_y, grid.rows)
    if across is None or down is None:
        return None
    return direction(*chart_position(grid, across, down))


def locate(value: float, low: int, high: int, scale: int, count: int) -> tuple[int, float] | None:
    """Central grid, "Meaning": the cell i and the fraction t in it, along one axis."""
    if not low / 65536 <= value <= high / 65536:
        return None
    u = (value - low / 65536) * (scale / 2**32)
    cell = math.floor(u)
    if cell == count - 3:
        return cell - 1, LAST_FRACTION
    return cell, u - cell


def basis(t: float) -> tuple[float, float, float, float]:
    """Central grid, "Meaning": B_0 to B_3."""
    return ((1 - t)**3 / 6,
            (3 * t**3 - 6 * t**2 + 4) / 6,
            (-3 * t**3 + 3 * t**2 + 3 * t + 1) / 6,
            t**3 / 6)


def chart_position(grid: CentralGrid, across: tuple[int, float],
                   down: tuple[int, float]) -> tuple[float, float]:
    """Central grid, "Meaning": (a, b) of the B-spline surface."""
    (i, t), (j, s) = across, down
    a = b = 0.0
    for m, weight_down in enumerate(basis(s)):
        for n, weight_across in enumerate(basis(t)):
            point = grid.control_points[(j + m) * grid.columns + i + n]
            a += weight_down * weight_across * point[0]
            b += weight_down * weight_across * point[1]
    return a / 2**FRACTION_BITS, b / 2**FRACTION_BITS


def line_point(blob: Blob, x_px: float, y_px: float) -> tuple[float, ...] | None:
    """Line points: the point of a pixel's line in metres, None outside the area."""
    grid = blob.grid
    across = locate(x_px, grid.x0, grid.x1, grid.scale_x, grid.columns)
    down = locate(y_px, grid.y0, grid.y1, grid.scale_y, grid.rows)
    if across is None or down is None or blob.line_points is None:
        return None
    (i, t), (j, s) = across, down
    return tuple(sum(weight_down * weight_across
                     * blob.line_points[(j + m) * grid.columns + i + n][axis]
                     for m, weight_down in enumerate(basis(s))
                     for n, weight_across in enumerate(basis(t))) / 2**LINE_POINT_BITS
                 for axis in range(3))


def direction(a: float, b: float) -> tuple[float, float, float]:
    """Central grid, "Meaning": the inverse of the stereographic projection."""
    square = a * a + b * b
    return 2 * a / (1 + square), 2 * b / (1 + square), (1 - square) / (1 + square)


# Ray arithmetic


Vector = tuple[int, int, int]

SIXTH_Q31 = 357913941
AREA_TOLERANCE = 128
LAST_STEP = 1 << 10
FIRST_STEP = 1 << 18
SAME_LINE = 128
LAST_CLOSENESS = 22
POINT_MAX_BITS = 27


def high(a: int, b: int) -> int:
    """Ray arithmetic: hi(a, b)."""
    return a * b + (1 << 31) >> 32


def leading_zeros(value: int) -> int:
    """Ray arithmetic: zeros(v)."""
    return 32 - value.bit_length()


class Place(NamedTuple):
    """Ray arithmetic, "Cells": cell (i, j), fractions t and s, and the weights of columns
    and of rows."""

    i: int
    j: int
    t: int
    s: int
    across: tuple[int, int, int, int]
    down: tuple[int, int, int, int]


def find_place(grid: CentralGrid, x: int, y: int) -> Place | None:
    """Ray arithmetic, "Cells": None outside."""
    if not (grid.x0 <= x <= grid.x1 and grid.y0 <= y <= grid.y1):
        return None
    i, t = cell_of((x - grid.x0) * grid.scale_x, grid.columns)
    j, s = cell_of((y - grid.y0) * grid.scale_y, grid.rows)
    return Place(i, j, t, s, weights_q31(t), weights_q31(s))


def cell_of(cells_q48: int, count: int) -> Pair:
    """Ray arithmetic, "Cells": cell and fraction in q30."""
    cell = min(cells_q48 >> 48, count - 4)
    return cell, cells_q48 - (cell << 48) >> 18


def weights_q31(t: int) -> tuple[int, int, int, int]:
    """Ray arithmetic, "Cells": W_0 to W_3."""
    square = 4 * high(t, t)
    cube = high(square, t)
    even = SIXTH_Q31 + square
    w3 = cube + high(cube, 4 * SIXTH_Q31)
    w2 = even - 4 * cube + t
    return even - t - w3, (1 << 31) - (even - t) - w2, w2, w3


def spline_sum(points: tuple, columns: int, place: Place) -> tuple[int, ...]:
    """Ray arithmetic, "Values": of wide control points, or points of lines."""
    sums = [0] * len(points[0])
    first = place.j * columns + place.i
    for weight_down in place.down:
        row = points[first:first + 4]
        for c in range(len(sums)):
            sums[c] += high(sum(high(point[c], weight)
                                for point, weight in zip(row, place.across)), weight_down)
        first += columns
    return tuple(fit(value, 32) for value in sums)


def value_at(grid: CentralGrid, place: Place) -> tuple[int, ...]:
    """Ray arithmetic, "Values", and Operating points, "Rays at an operating point"."""
    value = value_of_grid(grid, place)
    if not isinstance(grid, BlendedGrid):
        return value
    return tuple(fit(p + high(fit(2 * (q - p), 32), fit(grid.weight << 31 - WEIGHT_BITS, 32)), 32)
                 for p, q in zip(value, value_of_grid(grid.upper, place)))


def value_of_grid(grid: CentralGrid, place: Place) -> tuple[int, ...]:
    """Ray arithmetic, "Values": both coordinates, in 2 bits less than the control points."""
    if grid.fraction_bits == FRACTION_BITS:
        return spline_sum(grid.control_points, grid.columns, place)
    result = []
    for c in (0, 1):
        total = 1 << grid.fraction_bits - 14
        first = place.j * grid.columns + place.i
        for weight_down in place.down:
            row = grid.residuals[first:first + 4]
            total += high(sum(weight * point[c] >> 16
                              for point, weight in zip(row, place.across)), weight_down)
            first += grid.columns
        result.append(fit(plane_value(grid, place, c) + (fit(total, 32) >> grid.fraction_bits - 13),
                          32))
    return tuple(result)


def plane_value(grid: CentralGrid, place: Place, c: int) -> int:
    """Ray arithmetic, "Values": the plane of narrow control points."""
    origin, column_step, row_step = grid.plane[c], grid.plane[2 + c], grid.plane[4 + c]
    corner = fit(origin + (place.i + 1) * column_step + (place.j + 1) * row_step, 32)
    return (corner + 2 >> 2) + high(column_step, place.t) + high(row_step, place.s)


def reciprocal(d: int) -> int:
    """Ray arithmetic: 1 / d in q29, d in q31 from 1/2 to 1."""
    r = 1515870810 - high(d, 2021161080)
    for _ in range(3):
        excess = fit(16 * high(d, r) - (1 << 32), 32)
        r += (1 << 31) - r * excess >> 32
    return r


def inverse_root(u: int) -> int:
    """Ray arithmetic: 1 / sqrt(u) in q29, u in q31 from 1/4 to 1."""
    r = 1433893831 - 2 * high(u, 1763812404 - high(u, 1759398850))
    for _ in range(3):
        r += high(r, fit((1 << 31) - 16 * high(u, 4 * high(r, r)), 32))
    return r


def chart_direction(a_q27: int, b_q27: int) -> Vector:
    """Ray arithmetic, "Directions": q30."""
    a, b = 4 * a_q27, 4 * b_q27
    total = (1 << 26) + high(a, a) + high(b, b)
    zeros = leading_zeros(total)
    r = reciprocal((total << zeros) >> 1) >> 5 - zeros
    return 16 * high(a, r), 16 * high(b, r), 2 * r - (1 << 30)


def unproject_q16(blob: Blob, x: int, y: int) -> Vector | None:
    """Ray arithmetic, "Directions": of a pixel in q16, in q30; None outside the area."""
    place = find_place(blob.grid, x, y)
    return None if place is None else chart_direction(*value_at(blob.grid, place))


def unproject_line_q16(blob: Blob, x: int, y: int) -> tuple[Vector, Vector] | None:
    """Ray arithmetic, "Directions": the point in q28 m and the direction in q30 of a pixel's
    line; the point is 0 without line points."""
    place = find_place(blob.grid, x, y)
    if place is None:
        return None
    point = (0, 0, 0)
    if blob.line_points is not None:
        point = tuple(fit(4 * value, 32)
                      for value in spline_sum(blob.line_points, blob.grid.columns, place))
    return point, chart_direction(*value_at(blob.grid, place))


def bits_of(vector: Vector) -> int:
    """Ray arithmetic: bits(x) | bits(y) | bits(z)."""
    x, y, z = (value ^ value >> 31 for value in vector)
    return x | y | z


def chart_of_direction(direction_q: Vector, cos_limit: int) -> Pair | None:
    """Ray arithmetic, "Chart coordinates": q27; None if the angle from the z axis is too large."""
    if not any(direction_q):
        return None
    shift = leading_zeros(bits_of(direction_q) | 1) - 1
    x, y, z = ((value << shift) >> 1 for value in direction_q)
    z_square = high(z, z)
    square = z_square + high(x, x) + high(y, y)
    if (-z_square if z < 0 else z_square) < 2 * high(cos_limit, 2 * square):
        return None
    length = square_root(square)
    total = length + (z >> 1)
    if total <= length >> 3:
        return None
    zeros = leading_zeros(total)
    r = reciprocal((total << zeros) >> 1)
    return tuple(fit(high(value, r) << zeros - 1, 32) >> 2 for value in (x, y))


def square_root(square_q28: int) -> int:
    """Ray arithmetic, "Chart coordinates": q29."""
    u, shift = 2 * square_q28, 2
    if u < 1 << 29:
        u, shift = 4 * u, 1
    return high(u, inverse_root(u)) << shift


def slopes_at(grid: CentralGrid, place: Place) -> tuple[Pair, Pair]:
    """Ray arithmetic, "Projection": derivatives of x and y of an inverse grid with respect
    to a, then to b, in q5 px."""
    x, y = place.t >> 23, place.s >> 23
    shift = grid.fraction_bits - NARROW_FRACTION_BITS.start

    def residual(n: int, m: int, c: int) -> int:
        return grid.residuals[(place.j + m) * grid.columns + place.i + n][c]

    def across(n: int, m: int, c: int) -> int:
        return residual(n + 2, m, c) - residual(n, m, c)

    def down(n: int, m: int, c: int) -> int:
        return residual(n, m + 2, c) - residual(n, m, c)

    def blend(first: int, second: int, t: int) -> int:
        return fit(128 * first + t * (second - first), 32)

    result = []
    for difference, (n, m), step, scale in ((across, (0, 1), 2, grid.scale_x),
                                            (down, (1, 0), 4, grid.scale_y)):
        result.append(tuple(
            high(grid.plane[step + c] + (blend(
                blend(difference(n, m, c), difference(n + 1, m, c), x),
                blend(difference(n, m + 1, c), difference(n + 1, m + 1, c), x), y) >> shift),
                 scale >> 1) for c in (0, 1)))
    return result[0], result[1]


def move_inside(grid: CentralGrid, pixel: Pair, tolerance: int) -> Pair | None:
    """Ray arithmetic, "Projection": the pixel clamped to the area; None if farther outside."""
    x, y = pixel
    inside = min(max(x, grid.x0), grid.x1), min(max(y, grid.y0), grid.y1)
    return inside if max(abs(x - inside[0]), abs(y - inside[1])) <= tolerance else None


def project_q16(blob: Blob, direction_q: Vector) -> Pair | None:
    """Ray arithmetic, "Projection": the pixel, in q16, that observes a direction; None if
    there is none."""
    if blob.inverse is None:
        raise BlobError("RG_ERR_NO_INVERSE", "the blob has no inverse grid")
    target = chart_of_direction(direction_q, blob.inverse.cos_limit)
    place = None if target is None else find_place(blob.inverse.grid, *target)
    if place is None:
        return None
    x, y = (2 * value for value in value_at(blob.inverse.grid, place))
    return solve(blob.grid, target, (x, y), slopes_at(blob.inverse.grid, place))


def solve(grid: CentralGrid, target: Pair, start: Pair, slopes: tuple[Pair, Pair]) -> Pair | None:
    """Ray arithmetic, "Projection": Newton's method."""
    limit = FIRST_STEP
    pixel = move_inside(grid, start, limit)
    while pixel is not None and limit >= LAST_STEP:
        a, b = value_at(grid, find_place(grid, *pixel))
        rest_a, rest_b = target[0] - a, target[1] - b
        steps = [slopes[0][c] * rest_a + slopes[1][c] * rest_b + (1 << 15) >> 16 for c in (0, 1)]
        size = abs(steps[0]) | abs(steps[1])
        if size > limit:
            return None
        limit = AREA_TOLERANCE if size < LAST_STEP else limit >> 2
        pixel = move_inside(grid, (pixel[0] + steps[0], pixel[1] + steps[1]), limit)
    return pixel if limit == AREA_TOLERANCE else None


def project_point_q16(blob: Blob, point: Vector, fraction_bits: int) -> Pair | None:
    """Ray arithmetic, "Points": the pixel, in q16, that observes a point; None if there is none."""
    require(0 <= fraction_bits <= POINT_MAX_BITS, "RG_ERR_ARGUMENT",
            f"a point has {fraction_bits} fraction bits")
    if blob.line_points is None:
        return project_q16(blob, point)
    seen, last = point, None
    for closeness in range(0, LAST_CLOSENESS + 1, 2):
        found = project_q16(blob, seen)
        if found is not None and (closeness == LAST_CLOSENESS or are_near(found, last)):
            return found
        if found is None:
            pulled = wrap32(seen[2] + (bits_of(seen) >> closeness))
            found = project_q16(blob, (seen[0], seen[1], pulled))
            if found is None:
                return None
        last = found
        seen = look_from(unproject_line_q16(blob, *found), point, LINE_POINT_BITS - fraction_bits)
    return None


def are_near(pixel: Pair, last: Pair | None) -> bool:
    """Ray arithmetic, "Points": whether two pixels have the same line."""
    return last is not None and all(-SAME_LINE <= here - there < SAME_LINE
                                    for here, there in zip(pixel, last))


def look_from(line: tuple[Vector, Vector], point: Vector, shift: int) -> Vector:
    """Ray arithmetic, "Points": the direction of a point from the line's point closest to the
    camera's centre."""
    origin, ray = line
    along = wrap32(4 * sum(high(o, d) for o, d in zip(origin, ray)))
    return tuple(wrap32(p - (wrap32(o - 4 * high(along, d)) >> shift))
                 for p, o, d in zip(point, origin, ray))


# Validity and uncertainty


def is_valid_q16(blob: Blob, x: int, y: int) -> bool:
    """Validity mask: whether a pixel in q16 is valid."""
    grid, mask = blob.grid, blob.mask
    if not (grid.x0 <= x <= grid.x1 and grid.y0 <= y <= grid.y1):
        return False
    if mask is None:
        return True
    shift = 16 + mask.cell_log2
    column = min(x + HALF_PIXEL_Q16 >> shift, mask.columns - 1)
    row = min(y + HALF_PIXEL_Q16 >> shift, mask.rows - 1)
    return mask.bits[row * mask.columns + column]


def uncertainty_q12(blob: Blob, x: int, y: int) -> int | None:
    """Uncertainty: the value at a pixel in q16, in q12 px; None if unknown or outside the area."""
    grid, found = blob.grid, blob.uncertainty
    if found is None or not (grid.x0 <= x <= grid.x1 and grid.y0 <= y <= grid.y1):
        return None
    scale_x, scale_y = found.scales(grid)
    i, t = cell_of((x - grid.x0) * scale_x, found.columns + 2)
    j, s = cell_of((y - grid.y0) * scale_y, found.rows + 2)
    first = j * found.columns + i
    rows = [found.values[start:start + 2] for start in (first, first + found.columns)]
    if UNKNOWN_UNCERTAINTY in rows[0] + rows[1]:
        return None
    above, below = (256 * left + (t >> 22) * (right - left) for left, right in rows)
    return 256 * above + (s >> 22) * (below - above) + (1 << 15) >> 16


# Remapping


def fit(value: int, bits: int) -> int:
    """Remap arithmetic: the value, asserted to fit a two's complement integer of `bits` bits."""
    assert -(1 << bits - 1) <= value < 1 << bits - 1, f"{value} does not fit {bits} bits"
    return value


def rounded(v: int, n: int) -> int:
    """Remap arithmetic: round(v, n)."""
    return fit(fit(v, 32) + (1 << n - 1), 32) >> n


def wrap32(value: int) -> int:
    """Remap: the two's complement number of 32 bits that is congruent modulo 2^32."""
    return (value + (1 << 31)) % (1 << 32) - (1 << 31)


def vertex_positions(remap: Remap) -> list[Pair]:
    """Remap: source positions of all vertices, q12, row by row."""
    return [(vertex_coordinate(remap, index, 0), vertex_coordinate(remap, index, 1))
            for index in range(len(remap.vertices))]


def vertex_coordinate(remap: Remap, index: int, axis: int) -> int:
    """Remap: origin + i column_step + j row_step + residual 2^residual_shift, modulo 2^32."""
    j, i = divmod(index, remap.columns)
    return wrap32(remap.origin[axis] + i * remap.column_step[axis] + j * remap.row_step[axis]
                  + (remap.vertices[index][axis] << remap.residual_shift))


def remap_grey(blob: Blob, source: bytes, border: int) -> bytes:
    """Remap arithmetic: the whole output of a source image of 8 bits a pixel."""
    require(0 <= border <= 255, "RG_ERR_ARGUMENT", f"the border value is {border}")
    view = blob.remap.view
    size = blob.camera if view is None else view.source
    require(len(source) == size.width * size.height, "RG_ERR_FRAME_SIZE",
            f"{len(source)} bytes are not a frame of {size.width} x {size.height}")
    rows = remap_lattice(blob, Lattice(0, 0, 0, 0), sample_rows(source, size.width),
                         bits=8, border=border)
    return bytes(value for row in rows for value in row)


class Lattice(NamedTuple):
    """Components: pixel (i, j) is at (2^lx i + hx / 2, 2^ly j + hy / 2)."""

    lx: int
    ly: int
    hx: int
    hy: int


BORDER_CLAMP = "clamp"
Samples = list[list[int | None]]


def remap_lattice(blob: Blob, lattice: Lattice, source: Samples, bits: int,
                  border: int | str | None, nearest: bool = False) -> Samples:
    """Remap arithmetic, "Components": rows of samples to rows of samples.

    border is a value, BORDER_CLAMP, or None, which stands for pixels left as they are.
    """
    remap = blob.remap
    if remap is None:
        raise BlobError("RG_ERR_NO_REMAP", "the blob has no remap")
    outside = None if border == BORDER_CLAMP else border
    output = [[outside] * (remap.width >> lattice.lx) for _ in range(remap.height >> lattice.ly)]
    positions = vertex_positions(remap)
    for block, empty in enumerate(remap.empty_blocks):
        if empty and border != BORDER_CLAMP:
            continue
        for (x, y), position in lattice_positions(remap, lattice, positions, block):
            value = sample_at(remap, lattice, source, position, bits, border, nearest)
            if value is not None:
                output[y][x] = value
    return output


def sample_rows(source: bytes, width: int) -> Samples:
    """The rows of a source image without gaps between them."""
    return [list(source[start:start + width]) for start in range(0, len(source), width)]


def lattice_positions(remap: Remap, lattice: Lattice, positions: list[Pair],
                      block: int) -> Iterator[tuple[Pair, Pair]]:
    """Components: output pixel and source position of each lattice pixel of a block."""
    block_row, block_column = divmod(block, remap.columns - 1)
    logs = part_log2s(remap, lattice)
    width_log2, height_log2 = logs[0] - lattice.lx, logs[1] - lattice.ly
    across, down = (1 << remap.block_log2 - log2 for log2 in logs)
    for j, i in itertools.product(range(down), range(across)):
        corners = lattice_corners(lattice, [
            part_corner(remap, block_corners(remap, positions, block_row, block_column),
                        (block_row, block_column), logs, (i + (k & 1), j + (k >> 1)))
            for k in range(4)], logs[0])
        left = (block_column * across + i) << width_log2
        top = (block_row * down + j) << height_log2
        for y in range(top, min(top + (1 << height_log2), remap.height >> lattice.ly)):
            ends = row_ends(corners, y - top, height_log2)
            for x in range(left, min(left + (1 << width_log2), remap.width >> lattice.lx)):
                yield (x, y), row_position(ends, x - left, width_log2)


def part_log2s(remap: Remap, lattice: Lattice) -> Pair:
    """Components: log2 of a tile's width and height in output pixels."""
    if remap.part_log2 == 0:
        return remap.block_log2, remap.block_log2
    width, height = (max(remap.part_log2, CHROMA_PART_LOG2) if half == 1 else remap.part_log2
                     for half in (lattice.hx, lattice.hy))
    return width, height


def part_corner(remap: Remap, corners: list[Pair], block: Pair, logs: Pair, place: Pair) -> Pair:
    """Bends: the source position of tile corner (i, j) of block (row, column)."""
    across, down = (remap.block_log2 - log2 for log2 in logs)
    i, j = place
    if remap.part_log2 == 0:
        return corners[2 * j + i]
    row, column = block
    index = row * remap.columns + column
    below = index + remap.columns
    result = []
    for axis, (p00, p10, p01, p11) in enumerate(zip(*corners)):
        left = along_edge(p00, p01, bend_of(remap, below, 2 + axis, logs[1]), j, down)
        right = along_edge(p10, p11, bend_of(remap, below + 1, 2 + axis, logs[1]), j, down)
        bend = along_edge(bend_of(remap, index + 1, axis, logs[0]),
                          bend_of(remap, below + 1, axis, logs[0]), 0, j, down)
        result.append(along_edge(left, right, bend, i, across))
    return result[0], result[1]


def bend_of(remap: Remap, vertex: int, which: int, log2: int) -> int:
    """Bends: one of hx, hy, vx, vy of a vertex, for parts of 2^log2 output pixels."""
    return remap.bends[vertex][which] << remap.bend_shift + log2 - remap.part_log2


def along_edge(start: int, end: int, bend: int, k: int, log2: int) -> int:
    """Bends: point k of 2^log2 along a bent edge."""
    return fit(start + halved(fit(k * (end - start + bend * ((1 << log2) - k)), 32), log2), 32)


def lattice_corners(lattice: Lattice, corners: list[Pair], log2: int) -> list[Pair]:
    """Components: Q00, Q10, Q01, Q11."""
    result = []
    for k, corner in enumerate(corners):
        left, right = corners[k & 2], corners[k | 1]
        top, bottom = corners[k & 1], corners[k | 2]
        moved = [here + rounded((r - l) * lattice.hx + (b - t) * lattice.hy, log2 + 1)
                 for here, l, r, t, b in zip(corner, left, right, top, bottom)]
        result.append((halved(moved[0] - 2048 * lattice.hx, lattice.lx),
                       halved(moved[1] - 2048 * lattice.hy, lattice.ly)))
    return result


def halved(value: int, log2: int) -> int:
    """round(value, log2); round(value, 0) is value."""
    return rounded(value, log2) if log2 else value


def row_position(ends: list[Pair], k: int, width_log2: int) -> Pair:
    """Remap arithmetic: p of pixel k of a row."""
    x, y = (fit(left + k * rounded(fit(right - left, 32), width_log2), 32)
            for left, right in ends)
    return x, y


def lattice_rectangle(remap: Remap, lattice: Lattice) -> tuple[Pair, Pair]:
    """Components: (min, max) of x and of y."""
    result = []
    for low, high, log2, half in ((remap.min_x, remap.max_x, lattice.lx, lattice.hx),
                                  (remap.min_y, remap.max_y, lattice.ly, lattice.hy)):
        low, high = low - 2048 * half, high - 2048 * half
        result.append((halved(low, log2), high >> log2))
    return result[0], result[1]


def sample_at(remap: Remap, lattice: Lattice, source: Samples, position: Pair, bits: int,
              border: int | str | None, nearest: bool) -> int | None:
    """Components: the value of one lattice pixel; None if the pixel is not written."""
    moved = []
    for value, (low, high), count in zip(position, lattice_rectangle(remap, lattice),
                                         (len(source[0]), len(source))):
        if not low <= value <= high:
            if border != BORDER_CLAMP:
                return border
            value = min(max(value, low), high)
        value = min(max(value, 0), (count - 1) << 12)
        moved.append((value + 2048) & ~4095 if nearest else value)
    return (sample if bits == 8 else sample_16)(source, *moved)


def block_positions(remap: Remap, positions: list[Pair],
                    block: int) -> Iterator[tuple[int, Pair]]:
    """Remap arithmetic: index in the output and source position of each pixel of a block."""
    for (x, y), position in lattice_positions(remap, Lattice(0, 0, 0, 0), positions, block):
        yield y * remap.width + x, position


def block_corners(remap: Remap, positions: list[Pair], row: int, column: int) -> list[Pair]:
    """Remap arithmetic: P00, P10, P01, P11."""
    top = row * remap.columns + column
    bottom = top + remap.columns
    return [positions[top], positions[top + 1], positions[bottom], positions[bottom + 1]]


def row_ends(corners: list[Pair], r: int, log2: int) -> list[Pair]:
    """Remap arithmetic: (left, right) of row r, for x and for y."""
    return [(row_end(p00, p01, r, log2), row_end(p10, p11, r, log2))
            for p00, p10, p01, p11 in zip(*corners)]


def row_end(top: int, bottom: int, r: int, log2: int) -> int:
    """Remap arithmetic: left or right."""
    return fit(top + rounded(wrap32((bottom - top) * r), log2), 32)


def in_source(remap: Remap, position: Pair) -> bool:
    """Remap arithmetic: whether the position is in the source rectangle."""
    x, y = position
    return remap.min_x <= x <= remap.max_x and remap.min_y <= y <= remap.max_y


def sample(image: Samples, x: int, y: int) -> int:
    """Remap arithmetic: the value at a position of the source rectangle."""
    c, r = (x + 16) >> 12, y >> 12
    wx, wy = ((x + 16) >> 5) & 127, fit((y & 4095) << 3, 16)
    h0 = blend_row(image[r], c, wx)
    h1 = blend_row(image[r + 1], c, wx) if wy else 0
    v = fit(h0 - ((fit(fit(h0 - h1, 16) * wy, 32) + 16384) >> 15), 16)
    output = fit(v + 64, 16) >> 7
    assert 0 <= output <= 255, f"{output} does not fit a pixel"
    return output


def blend_row(row: list[int], c: int, wx: int) -> int:
    """Remap arithmetic: h0 or h1; a neighbour of weight zero is not read."""
    neighbour = row[c + 1] * wx if wx else 0
    return fit(row[c] * (128 - wx) + neighbour, 16)


def sample_16(image: Samples, x: int, y: int) -> int:
    """Remap arithmetic: the value of samples of more than 8 bits."""
    x, y = (x + 8) >> 4, (y + 8) >> 4
    (c, wx), (r, wy) = divmod(x, 256), divmod(y, 256)
    rows = (image[r], image[r + 1] if wy else image[r])
    h0, h1 = (row[c] * (256 - wx) + (row[c + 1] * wx if wx else 0) for row in rows)
    total = h0 * (256 - wy) + h1 * wy + 32768
    assert 0 <= total < 1 << 32, f"{total} does not fit 32 bits"
    return total >> 16


# Writing


def serialize(blob: Blob) -> bytes:
    """Requirements, "A writer": a blob, opened with the reader before it is returned.

    The sequences in the blob must be tuples, as returned by `parse`.
    """
    try:
        data = assemble(list(packed_sections(blob)))
    except struct.error as error:
        raise BlobError("RG_ERR_ARGUMENT", f"a value does not fit its field: {error}") from error
    require(parse(data) == blob, "RG_ERR_ARGUMENT", "the blob does not read back as given")
    return data


def packed_sections(blob: Blob) -> Iterator[tuple[int, bytes]]:
    """Type and bytes of each section. The operating points are last, directly after the sections
    that also occur in their samples."""
    yield TYPE_CAMERA, pack_camera(blob.camera)
    if blob.modes:
        yield TYPE_MODES, b"".join(map(pack_mode, blob.modes))
    if blob.stack is None:
        yield from packed_parts(blob)
    yield from packed_lone_sections(blob)
    if blob.stack is not None:
        yield from packed_parts(blob)
        yield TYPE_STACK, pack_stack(blob.stack)


def packed_parts(blob: Blob) -> Iterator[tuple[int, bytes]]:
    """Operating points: the sections that also occur in samples."""
    yield TYPE_CENTRAL_GRID, pack_grid(blob.grid)
    for remap in blob.remaps:
        yield TYPE_REMAP, pack_remap(remap)
    if blob.inverse is not None:
        yield TYPE_INVERSE, pack_inverse(blob.inverse)


def packed_lone_sections(blob: Blob) -> Iterator[tuple[int, bytes]]:
    """Sections, other than camera and modes, that do not occur in samples."""
    if blob.quality is not None:
        yield TYPE_QUALITY, QUALITY.pack(*dataclasses.astuple(blob.quality))
    if blob.line_points is not None:
        yield TYPE_LINE_POINTS, pack_line_points(blob.line_points)
    if blob.mask is not None:
        yield TYPE_MASK, pack_valid_mask(blob.mask)
    if blob.uncertainty is not None:
        yield TYPE_UNCERTAINTY, pack_uncertainty(blob.uncertainty, blob.grid)
    if blob.capture is not None:
        yield TYPE_CAPTURE, pack_capture(blob.capture)
    if blob.row_time is not None:
        yield TYPE_ROW_TIME, ROW_TIME.pack(*dataclasses.astuple(blob.row_time))


def minor_version(packed: list[tuple[int, bytes]]) -> int:
    """Requirements, "A writer": the minor version whose fields it uses."""
    versions = [MINOR_OF_TYPE[kind] for kind, _ in packed]
    for kind, section in packed:
        if kind == TYPE_CENTRAL_GRID and GRID.unpack_from(section)[9] != FRACTION_BITS:
            versions.append(2)
        if kind == TYPE_REMAP:
            fields = REMAP.unpack_from(section)
            versions.append(5 if fields[7] & HAS_VIEW else 4 if fields[6] else 0)
    return max(versions)


def assemble(packed: list[tuple[int, bytes]]) -> bytes:
    """Header: the header, the section table and the contiguous sections."""
    table = b""
    position = table_end(len(packed))
    for kind, section in packed:
        table += ENTRY.pack(kind, FLAGS_OF_TYPE[kind], position, len(section),
                            zlib.crc32(section))
        position += len(section)
    fields = (MAGIC, MAJOR, minor_version(packed), position, len(packed), HEADER.size, 0, 0)
    crc = header_crc(HEADER.pack(*fields, 0) + table, len(packed))
    return HEADER.pack(*fields, crc) + table + b"".join(section for _, section in packed)


def pack_camera(camera: Camera) -> bytes:
    """Camera (type 1)."""
    return CAMERA.pack(camera.width, camera.height, 0,
                       pack_text(camera.name), pack_text(camera.serial))


def pack_text(text: str) -> bytes:
    """Camera: UTF-8 and then zeros, at least one."""
    try:
        field = text.encode("utf-8")
    except UnicodeEncodeError as error:
        raise BlobError("RG_ERR_TEXT", f"{text!r} is not Unicode text") from error
    require(len(field) < TEXT_SIZE, "RG_ERR_TEXT", f"{text!r} is longer than 31 bytes")
    return field.ljust(TEXT_SIZE, b"\0")


def pack_grid(grid: CentralGrid) -> bytes:
    """Central grid (type 2)."""
    fields = GRID.pack(grid.x0, grid.y0, grid.x1, grid.y1, grid.columns, grid.rows,
                       grid.scale_x, grid.scale_y, CHART_STEREOGRAPHIC, grid.fraction_bits,
                       GRID.size, 0)
    if grid.fraction_bits == FRACTION_BITS:
        return fields + pack_pairs("<ii", grid.control_points)
    return fields + pack_narrow_points(grid)


def pack_narrow_points(grid: CentralGrid) -> bytes:
    """Central grid: a plane and residuals of 16 bits."""
    return PLANE.pack(*grid.plane) + pack_pairs("<hh", grid.residuals)


def pack_remap(remap: Remap) -> bytes:
    """Remap (type 3)."""
    view = ()
    if remap.view is not None:
        view = (remap.view.projection, remap.view.mode, remap.view.direction, 0,
                *remap.view.rotation, remap.view.source.width, remap.view.source.height)
    layout = REMAP_WITH_VIEW if view else REMAP
    fields = layout.pack(remap.width, remap.height, remap.columns, remap.rows,
                         remap.block_log2, remap.residual_shift, remap.part_log2,
                         remap.bend_shift | (HAS_VIEW if view else 0),
                         remap.min_x, remap.min_y, remap.max_x, remap.max_y,
                         *remap.origin, *remap.column_step, *remap.row_step,
                         remap.fx, remap.fy, remap.cx, remap.cy,
                         remap.bound_upx, remap.max_error_upx, layout.size, *view)
    layout = vertex_layout(remap)
    bends = remap.bends or ((),) * len(remap.vertices)
    return (fields + b"".join(layout.pack(*vertex, *bend)
                              for vertex, bend in zip(remap.vertices, bends))
            + pack_mask(remap.empty_blocks))


def pack_line_points(points: tuple[tuple[int, int, int], ...]) -> bytes:
    """Line points (type 5)."""
    return LINE_POINTS.pack(LINE_POINT_BITS, 0, LINE_POINTS.size) + pack_pairs("<iii", points)


def pack_valid_mask(mask: Mask) -> bytes:
    """Validity mask (type 6)."""
    fields = MASK.pack(mask.columns, mask.rows, mask.cell_log2, 0, 0, MASK.size)
    return fields + pack_mask(mask.bits)


def pack_uncertainty(uncertainty: Uncertainty, grid: CentralGrid) -> bytes:
    """Uncertainty (type 7)."""
    fields = UNCERTAINTY.pack(uncertainty.columns, uncertainty.rows,
                              *uncertainty.scales(grid), UNCERTAINTY.size)
    values = uncertainty.values + (0,) * (len(uncertainty.values) % 2)
    return fields + struct.pack(f"<{len(values)}H", *values)


def pack_inverse(inverse: InverseGrid) -> bytes:
    """Inverse grid (type 10)."""
    grid = inverse.grid
    fields = INVERSE.pack(grid.x0, grid.y0, grid.x1, grid.y1, grid.columns, grid.rows,
                          grid.scale_x, grid.scale_y, CHART_STEREOGRAPHIC, grid.fraction_bits,
                          INVERSE.size, inverse.cos_limit)
    return fields + pack_narrow_points(grid)


def pack_capture(capture: Capture) -> bytes:
    """Capture (type 11)."""
    known = sum(bit for bit, is_known in (
        (KNOWS_LENS_POSITION, capture.lens_position is not None), (KNOWS_CROP, capture.crop != ()),
        (KNOWS_ZOOM, capture.zoom is not None),
        (KNOWS_ORIENTATION, capture.orientation is not None),
        (KNOWS_TEMPERATURE, capture.temperature is not None),
        (KNOWS_EXPOSURE, capture.exposure is not None),
        (KNOWS_GAIN, capture.gain is not None)) if is_known)
    return CAPTURE.pack(capture.lens_position or 0, capture.lens_tolerance or 0,
                        *(capture.crop or (0, 0, 0, 0)), capture.zoom or 0, known,
                        capture.orientation or 0, 0, capture.temperature or 0,
                        capture.exposure or 0, capture.gain or 0)


def pack_stack(stack: Stack) -> bytes:
    """Operating points (type 12)."""
    return STACK.pack(stack.condition, len(stack.values)) + b"".join(
        pack_knot(knot) + STACK_SAMPLE.pack(value)
        for knot, value in zip(stack.knots, stack.values))


def pack_knot(knot: Knot) -> bytes:
    """Operating points: a knot's grids and tables, in the order of packed_parts()."""
    inverse = b"" if knot.inverse is None else pack_inverse(knot.inverse)
    return pack_grid(knot.grid) + b"".join(map(pack_remap, knot.remaps)) + inverse


def pack_mode(mode: Mode) -> bytes:
    """Sensor modes: one of them."""
    return MODE.pack(mode.width, mode.height, *mode.offset, *mode.scale, *mode.flips, 0, 0, 0,
                     pack_text(mode.name))


def pack_pairs(layout: str, pairs: Iterable[Pair]) -> bytes:
    """Control points or residuals, one after the other."""
    return b"".join(struct.pack(layout, *pair) for pair in pairs)


def pack_mask(empty_blocks: tuple[bool, ...]) -> bytes:
    """Remap: the empty-block mask, padded with zero bits."""
    mask = bytearray(mask_size(len(empty_blocks)))
    for k, empty in enumerate(empty_blocks):
        mask[k // 8] |= empty << k % 8
    return bytes(mask)


# Command line


def field_lines(title: str, record: object) -> Iterator[str]:
    """A dataclass as text, one field per line; of arrays, only the length."""
    yield f"{title}:"
    for field in dataclasses.fields(record):
        value = getattr(record, field.name)
        if field.name in ("control_points", "vertices", "bends", "knots") or (
                field.name == "values" and title == "uncertainty"):
            value = f"{len(value)}"
        elif field.name in ("empty_blocks", "bits"):
            value = f"{sum(value)} of {len(value)}"
        yield f"  {field.name}: {value}"


def derived_lines(record: object, names: tuple[str, ...]) -> Iterator[str]:
    """Fields of a section that follow from its others, as text."""
    return (f"  {name}: {getattr(record, name)}" for name in names)


def inspect_lines(data: bytes) -> Iterator[str]:
    """All fields of a blob as text."""
    blob = parse(data)
    header = read_header(data)
    yield f"version: {header.major}.{header.minor}"
    yield f"total_size: {header.total_size}"
    yield f"header_crc: {header.header_crc:08x}"
    for entry in read_table(data, header):
        yield (f"section: type {entry.type}, flags {entry.flags}, offset {entry.offset}, "
               f"size {entry.size}, crc {entry.crc:08x}")
    yield from field_lines("camera", blob.camera)
    yield from field_lines("grid", blob.grid)
    yield from derived_lines(blob.grid, ("scale_x", "scale_y"))
    for remap in blob.remaps:
        yield from field_lines("remap", remap)
        yield from derived_lines(remap, ("columns", "rows"))
    if blob.quality is not None:
        yield from field_lines("quality", blob.quality)
    if blob.line_points is not None:
        yield f"line_points: {len(blob.line_points)}"
    for title, section in (("mask", blob.mask), ("uncertainty", blob.uncertainty),
                           ("inverse grid", blob.inverse and blob.inverse.grid)):
        if section is not None:
            yield from field_lines(title, section)
    if blob.inverse is not None:
        yield f"  cos_limit: {blob.inverse.cos_limit}"
    for mode in blob.modes:
        yield from field_lines("mode", mode)
    if blob.capture is not None:
        yield from field_lines("capture", blob.capture)
    if blob.stack is not None:
        yield from field_lines("stack", blob.stack)
    if blob.row_time is not None:
        yield from field_lines("row time", blob.row_time)


def hexdump_lines(data: bytes) -> Iterator[str]:
    """A hex dump of 16 bytes a line."""
    for offset in range(0, len(data), 16):
        yield f"{offset:08x}  {data[offset:offset + 16].hex(' ')}"


def run_inspect(arguments: argparse.Namespace) -> int:
    """Print the fields of a blob."""
    print("\n".join(inspect_lines(arguments.file.read_bytes())))
    return 0


def run_hexdump(arguments: argparse.Namespace) -> int:
    """Print the bytes of a file."""
    print("\n".join(hexdump_lines(arguments.file.read_bytes())))
    return 0


def run_check(arguments: argparse.Namespace) -> int:
    """Print a status for each file."""
    result = 0
    for path in arguments.files:
        try:
            parse(path.read_bytes())
            print(f"{path}: RG_OK")
        except BlobError as error:
            print(f"{path}: {error}")
            result = EXIT_INVALID
    return result


def csv_rows(lines: Iterable[str], columns: tuple[str, ...], kind: type) -> Iterator[tuple]:
    """Text files: numbers of some columns of a CSV without quotes."""
    contents = (line.strip() for line in lines if not line.startswith("#"))
    for row in csv.DictReader(line for line in contents if line):
        try:
            yield tuple(kind(row[column]) for column in columns)
        except (KeyError, TypeError) as error:
            raise ValueError(f"the CSV needs the columns {', '.join(columns)}") from error


def run_unproject(arguments: argparse.Namespace) -> int:
    """Print the direction of each pixel that standard input lists."""
    blob = parse(arguments.file.read_bytes())
    if arguments.bits:
        return print_lines(blob)
    print("x,y,dx,dy,dz")
    for x, y in csv_rows(sys.stdin, ("x", "y"), float):
        ray = unproject(blob, x, y)
        tail = ["", "", ""] if ray is None else [f"{value:.17g}" for value in ray]
        print(",".join([f"{x:.17g}", f"{y:.17g}", *tail]))
    return 0


def print_lines(blob: Blob) -> int:
    """Print the line of each pixel in q16 that standard input lists, in the runtime's bits."""
    print("x_q16,y_q16,dx_q30,dy_q30,dz_q30,ox_q28,oy_q28,oz_q28")
    for x, y in csv_rows(sys.stdin, ("x_q16", "y_q16"), int):
        line = unproject_line_q16(blob, x, y)
        tail = [""] * 6 if line is None else [*line[1], *line[0]]
        print(",".join(map(str, [x, y, *tail])))
    return 0


def run_project(arguments: argparse.Namespace) -> int:
    """Print the pixel of each direction or point that standard input lists."""
    blob = parse(arguments.file.read_bytes())
    print("x,y,z,x_q16,y_q16")
    for point in csv_rows(sys.stdin, ("x", "y", "z"), int):
        pixel = project_point_q16(blob, point, arguments.fraction_bits)
        print(",".join(map(str, [*point, *(pixel or ("", ""))])))
    return 0


def run_remap(arguments: argparse.Namespace) -> int:
    """Remap one frame of raw bytes."""
    blob = parse(arguments.file.read_bytes())
    output = remap_grey(blob, arguments.input.read_bytes(), arguments.border)
    arguments.output.write_bytes(output)
    return 0


def build_parser() -> argparse.ArgumentParser:
    """The command line's syntax."""
    parser = argparse.ArgumentParser(description="Reference reader of raygrid blobs.")
    commands = parser.add_subparsers(dest="command", required=True)
    for name, run, summary in (
            ("inspect", run_inspect, "print the fields"),
            ("check", run_check, "print a status for each file; exit 8 if one is refused"),
            ("unproject", run_unproject, "directions of the pixels of a CSV on standard input"),
            ("project", run_project, "pixels of the directions of a CSV on standard input"),
            ("remap", run_remap, "remap a frame of width * height bytes"),
            ("hexdump", run_hexdump, "print the bytes")):
        command = commands.add_parser(name, help=summary, description=summary)
        command.set_defaults(run=run)
        add_arguments(command, name)
    return parser


def add_arguments(command: argparse.ArgumentParser, name: str) -> None:
    """The arguments of one command."""
    if name == "check":
        command.add_argument("files", type=Path, nargs="+", metavar="FILE")
        return
    command.add_argument("file", type=Path, metavar="FILE")
    if name == "unproject":
        command.add_argument("--bits", action="store_true",
                             help="columns x_q16, y_q16: lines in the runtime's bits")
    if name == "project":
        command.add_argument("--fraction-bits", type=int, default=0, metavar="N",
                             help="points are in metres times 2^N, directions any")
    if name == "remap":
        command.add_argument("input", type=Path, metavar="IN.raw")
        command.add_argument("output", type=Path, metavar="OUT.raw")
        command.add_argument("--border", type=int, default=0, metavar="N", help="0 to 255")


def main() -> int:
    """Run one command."""
    arguments = build_parser().parse_args()
    try:
        return arguments.run(arguments)
    except BlobError as error:
        print(f"{arguments.file}: {error}", file=sys.stderr)
        return EXIT_INVALID
    except (OSError, ValueError) as error:
        print(f"blob_reference.py: {error}", file=sys.stderr)
        return EXIT_FAILURE


if __name__ == "__main__":
    sys.exit(main())
