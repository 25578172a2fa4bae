#!/usr/bin/env python3
"""Golden cameras, and golden_blobs.h: the blobs of formats/vectors and the results expected of them.

    make_golden.py FILE    writes golden_blobs.h
"""

import csv
import dataclasses
import functools
import math
import sys
import tomllib
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "formats"))
import blob_reference as reference  # noqa: E402

VECTORS = ROOT / "formats" / "vectors"

Pair = tuple[int, int]
Point = tuple[float, float]
Ray = tuple[float, float, float]

UNKNOWN = 0xFFFFFFFF
Q12, Q16, Q17, Q24 = 1 << 12, 1 << 16, 1 << 17, 1 << 24
Q27, Q28, Q29, Q30 = 1 << 27, 1 << 28, 1 << 29, 1 << 30
BORDER = 201
FRAME_SEED = 2025
CHART_POINTS = ((0, 0), (1, -1), (0.25, 0.5), (-0.5, 0.125), (1, 0), (-1, 1),
                (1.5, -2), (0, 3), (-3.5, 0.75), (2.5, 3.25),
                (3.96875, 3.96875), (-3.96875, 3.96875))


class Lcg:
    """The generator of pseudo-random numbers that the C tests have too."""

    def __init__(self, seed: int) -> None:
        self.state = seed

    def next(self) -> int:
        """32 bits, of which the upper ones are the better."""
        self.state = (self.state * 1664525 + 1013904223) % (1 << 32)
        return self.state

    def below(self, limit: int) -> int:
        """A number from 0 to limit - 1."""
        return self.next() * limit >> 32


# Lenses


@dataclass(frozen=True)
class Lens:
    """radius = focal / k tan(k theta) around the centre: k = 1 is a pinhole,
    0.5 stereographic, 0 would be equidistant. The sensor is turned by roll."""

    centre: Point
    focal: float
    k: float
    roll: float

    def chart(self, x: float, y: float) -> Point:
        """tan(theta / 2) (cos phi, sin phi) of a pixel's direction."""
        x, y = rotate((x - self.centre[0], y - self.centre[1]), self.roll)
        radius = math.hypot(x, y)
        theta = math.atan(self.k * radius / self.focal) / self.k
        scale = math.tan(theta / 2) / radius
        return x * scale, y * scale

    def project(self, ray: Ray) -> Point:
        """The pixel that looks along a direction."""
        across = math.hypot(ray[0], ray[1])
        theta = math.atan2(across, ray[2])
        scale = self.focal / self.k * math.tan(self.k * theta) / across
        x, y = rotate((ray[0] * scale, ray[1] * scale), -self.roll)
        return x + self.centre[0], y + self.centre[1]


def rotate(point: Point, angle: float) -> Point:
    """The point turned around the origin."""
    c, s = math.cos(angle), math.sin(angle)
    return c * point[0] - s * point[1], s * point[0] + c * point[1]


def make_grid(lens: Lens, area: tuple[float, float, float, float],
              cells: tuple[int, int]) -> reference.CentralGrid:
    """A grid whose surface is the lens's chart to third order."""
    x0, y0, x1, y1 = area
    columns, rows = cells[0] + 3, cells[1] + 3
    step_x, step_y = (x1 - x0) / cells[0], (y1 - y0) / cells[1]
    points = tuple(
        tuple(round(value * Q29) for value in control_point(
            lens.chart, (x0 + i * step_x, y0 + j * step_y), step_x, step_y))
        for j in range(-1, rows - 1) for i in range(-1, columns - 1))
    corners = (round(value * Q16) for value in area)
    return reference.CentralGrid(*corners, columns, rows, points)


def control_point(function: Callable[[float, float], Point], place: Point, step_x: float,
                  step_y: float) -> Point:
    """The function's value less a sixth of the second differences."""
    x, y = place
    around = [function(*neighbour) for neighbour in (
        (x - step_x, y), (x + step_x, y), (x, y - step_y), (x, y + step_y))]
    middle = function(x, y)
    a, b = (middle[axis] - (sum(point[axis] for point in around)
                            - 4 * middle[axis]) / 6 for axis in (0, 1))
    return a, b


def project(blob: reference.Blob, lens: Lens, ray: Ray) -> Point:
    """The pixel that the blob's grid sees a direction in.

    The lens, corrected by what the grid's pixels differ from it; beyond the
    area by what the nearest pixel of the area does.
    """
    target = lens.project(ray)
    x, y = target
    for _ in range(12):
        nearest = clamp_to_area(blob.grid, x, y)
        seen = lens.project(reference.unproject(blob, *nearest))
        x = target[0] + nearest[0] - seen[0]
        y = target[1] + nearest[1] - seen[1]
    return x, y


def clamp_to_area(grid: reference.CentralGrid, x: float, y: float) -> Point:
    """The nearest pixel of the calibrated area."""
    return (min(max(x, grid.x0 / Q16), grid.x1 / Q16),
            min(max(y, grid.y0 / Q16), grid.y1 / Q16))


# Remap tables


@dataclass(frozen=True)
class View:
    """The view that a remap table is made for."""

    width: int
    height: int
    block_log2: int
    residual_shift: int
    focal: float
    bound_upx: int
    source: tuple[float, float, float, float] | None = None  # or the area
    part_log2: int = 0
    projection: str = "pinhole"
    angles: tuple[float, float, float] = (0, 0, 0)  # yaw, pitch, roll, in degrees
    mode: int = 0  # of SENSOR_MODES, counted from 1; 0: frames as calibrated
    distorts: bool = False

    def ray(self, u: float, v: float) -> Ray:
        """The direction in which the output pixel (u, v) looks."""
        a = (u - (self.width - 1) / 2) / self.focal
        b = (v - (self.height - 1) / 2) / self.focal
        if self.angles == (0, 0, 0) and self.projection == "pinhole":
            return a, b, 1.0
        ray = plane_ray(self.projection, a, b)
        x, y, z = (sum(m * r for m, r in zip(row, ray)) for row in rotation_of(*self.angles))
        return x, y, z

    def stored(self) -> reference.View | None:
        """The view's fields in a table."""
        if (self.angles == (0, 0, 0) and self.projection == "pinhole" and self.mode == 0
                and not self.distorts):
            return None
        return reference.View(
            reference.PROJECTIONS.index(self.projection),
            tuple(round(value * Q30) for row in rotation_of(*self.angles) for value in row),
            reference.Size(self.width, self.height) if self.distorts else self.real_size(),
            self.mode, reference.DISTORT if self.distorts else reference.UNDISTORT)

    def real_size(self) -> reference.Size:
        """Size of the real frames."""
        if self.mode == 0:
            return reference.Size(320, 240)
        return reference.Size(SENSOR_MODES[self.mode - 1].width, SENSOR_MODES[self.mode - 1].height)

    def pixel(self, ray: Ray) -> Point:
        """Where the view shows a direction in camera axes."""
        columns = list(zip(*rotation_of(*self.angles)))
        turned = tuple(sum(m * r for m, r in zip(column, ray)) for column in columns)
        a, b = plane_point(self.projection, turned)
        return self.focal * a + (self.width - 1) / 2, self.focal * b + (self.height - 1) / 2


def plane_ray(projection: str, a: float, b: float) -> Ray:
    """The direction of a point of the view's plane, in axes of the view."""
    r = math.hypot(a, b)
    if projection == "pinhole":
        return a, b, 1.0
    if projection == "cylindrical":
        return math.sin(a), b, math.cos(a)
    if projection == "equirectangular":
        return math.sin(a) * math.cos(b), math.sin(b), math.cos(a) * math.cos(b)
    if projection == "stereographic":
        return a, b, 1 - r * r / 4
    return a * math.sin(r) / r, b * math.sin(r) / r, math.cos(r)


def plane_point(projection: str, ray: Ray) -> Point:
    """The point of the plane at which a view shows a direction of length 1; infinite if none."""
    x, y, z = ray
    across, around = math.hypot(x, y), math.hypot(x, z)
    if projection == "pinhole":
        return (x / z, y / z) if z > 1e-3 else (math.inf, math.inf)
    if projection == "cylindrical":
        return math.atan2(x, z), y / around
    if projection == "equirectangular":
        return math.atan2(x, z), math.atan2(y, around)
    if projection == "stereographic":
        return 2 * x / (1 + z), 2 * y / (1 + z)
    scale = math.atan2(across, z) / across
    return x * scale, y * scale


def rotation_of(yaw: float, pitch: float, roll: float) -> tuple[Ray, Ray, Ray]:
    """Axes of a view that is turned to the right, then up, then clockwise to camera axes."""
    sines, cosines = zip(*((math.sin(t), math.cos(t)) for t in map(math.radians,
                                                                   (yaw, pitch, roll))))
    about_y = ((cosines[0], 0, sines[0]), (0, 1, 0), (-sines[0], 0, cosines[0]))
    about_x = ((1, 0, 0), (0, cosines[1], -sines[1]), (0, sines[1], cosines[1]))
    about_z = ((cosines[2], -sines[2], 0), (sines[2], cosines[2], 0), (0, 0, 1))
    return times(about_y, times(about_x, about_z))


def times(a: tuple[Ray, Ray, Ray], b: tuple[Ray, Ray, Ray]) -> tuple[Ray, Ray, Ray]:
    """The product of two matrices."""
    return tuple(tuple(sum(x * y for x, y in zip(row, column)) for column in zip(*b))
                 for row in a)


def make_remap(blob: reference.Blob, lens: Lens, view: View) -> reference.Remap:
    """The table that undistorts the blob's camera to the view."""
    remap = empty_remap(blob, view)
    block = 1 << view.block_log2
    exact = [source_of(blob, lens, view, block * i, block * j)
             for j in range(remap.rows) for i in range(remap.columns)]
    remap = with_vertices(remap, exact)
    if view.part_log2 != 0:
        remap = with_bends(blob, lens, view, remap)
    remap = dataclasses.replace(remap, empty_blocks=find_empty_blocks(remap))
    return dataclasses.replace(
        remap, max_error_upx=measure_error(blob, lens, view, remap))


def source_of(blob: reference.Blob, lens: Lens, view: View, u: float, v: float) -> Point:
    """The source of an output pixel: of the view, or of a real frame if the table distorts."""
    if not view.distorts:
        return mode_pixel(view.mode, project(blob, lens, view.ray(u, v)))
    return view.pixel(reference.unproject(blob, *clamp_to_area(blob.grid, u, v)))


def mode_pixel(number: int, pixel: Point) -> Point:
    """A calibrated pixel in frames of a mode."""
    if number == 0:
        return pixel
    mode = SENSOR_MODES[number - 1]
    x, y = ((value + 0.5 - mode.offset[axis] / Q16) / (mode.scale[axis] / Q16) - 0.5
            for axis, value in enumerate(pixel))
    return (mode.width - 1 - x if mode.flips[0] else x,
            mode.height - 1 - y if mode.flips[1] else y)


def source_rectangle(blob: reference.Blob, view: View) -> tuple[int, int, int, int]:
    """The calibrated area, or what the view says, as far as frames of the source reach; q16."""
    grid = blob.grid
    if view.source is not None:
        x0, y0, x1, y1 = (round(value * Q16) for value in view.source)
        return x0, y0, x1, y1
    if view.distorts:
        return 0, 0, (view.width - 1) * Q16, (view.height - 1) * Q16
    corners = [mode_pixel(view.mode, (x / Q16, y / Q16))
               for x, y in ((grid.x0, grid.y0), (grid.x1, grid.y1))]
    size = view.real_size() if view.mode else reference.Size(blob.camera.width, blob.camera.height)
    (x0, x1), (y0, y1) = (
        (max(0.0, min(ends)), min(side - 1.0, max(ends))) for ends, side in zip(zip(*corners), size))
    return round(x0 * Q16), round(y0 * Q16), round(x1 * Q16), round(y1 * Q16)


def empty_remap(blob: reference.Blob, view: View) -> reference.Remap:
    """The fields that the view gives."""
    x0, y0, x1, y1 = source_rectangle(blob, view)
    width, height = view.real_size() if view.distorts else (view.width, view.height)
    return reference.Remap(
        width, height, view.block_log2, view.residual_shift,
        min_x=-(-x0 // 16), min_y=-(-y0 // 16),
        max_x=x1 // 16, max_y=y1 // 16,
        origin=(0, 0), column_step=(0, 0), row_step=(0, 0),
        fx=round(view.focal * Q16), fy=round(view.focal * Q16),
        cx=(view.width - 1) * Q16 // 2, cy=(view.height - 1) * Q16 // 2,
        bound_upx=view.bound_upx, max_error_upx=UNKNOWN, vertices=(),
        empty_blocks=(), view=view.stored())


def with_vertices(remap: reference.Remap,
                  exact: list[Point]) -> reference.Remap:
    """Steps from edge to edge, residuals what they leave."""
    axes = [affine_fit(remap, [point[axis] * Q12 for point in exact])
            for axis in (0, 1)]
    return dataclasses.replace(
        remap, vertices=tuple(zip(*(axis[3] for axis in axes))),
        origin=(axes[0][0], axes[1][0]),
        column_step=(axes[0][1], axes[1][1]),
        row_step=(axes[0][2], axes[1][2]))


def with_bends(blob: reference.Blob, lens: Lens, view: View,
               remap: reference.Remap) -> reference.Remap:
    """How far the middles of the edges to the left of each vertex and above it lie from the
    straight line, with the smallest shift that lets all fit."""
    block, parts = 1 << view.block_log2, 1 << view.block_log2 - view.part_log2

    def exact(i: float, j: float) -> Point:
        return source_of(blob, lens, view, block * i, block * j)

    def bend(i: int, j: int, di: int, dj: int) -> Point:
        if i < di or j < dj:
            return 0, 0
        ends, middle = (exact(i - di, j - dj), exact(i, j)), exact(i - di / 2, j - dj / 2)
        x, y = (4 / parts * Q12 * (middle[c] - (ends[0][c] + ends[1][c]) / 2) for c in (0, 1))
        return x, y

    values = [(*bend(i, j, 1, 0), *bend(i, j, 0, 1))
              for j in range(remap.rows) for i in range(remap.columns)]
    largest = max(abs(value) for vertex in values for value in vertex)
    shift = max(0, math.ceil(math.log2(largest / 127)))
    return dataclasses.replace(
        remap, part_log2=view.part_log2, bend_shift=shift,
        bends=tuple(tuple(round(value / (1 << shift)) for value in vertex)
                    for vertex in values))


def affine_fit(remap: reference.Remap,
               values: list[float]) -> tuple[int, int, int, list[int]]:
    """Origin, column step, row step and residuals of one coordinate."""
    columns, rows = remap.columns, remap.rows
    left, right = values[::columns], values[columns - 1::columns]
    top, bottom = values[:columns], values[-columns:]
    across = round((sum(right) - sum(left)) / rows / (columns - 1))
    down = round((sum(bottom) - sum(top)) / columns / (rows - 1))
    plane = [i * across + j * down
             for j in range(rows) for i in range(columns)]
    origin = round((sum(values) - sum(plane)) / len(values))
    unit = 1 << remap.residual_shift
    return origin, across, down, [
        round((value - origin - base) / unit)
        for value, base in zip(values, plane)]


def block_sources(remap: reference.Remap,
                  block: int) -> list[tuple[int, reference.Pair]]:
    """Index and source position of the pixels of a block that have one."""
    positions = reference.vertex_positions(remap)
    return [(index, position) for index, position
            in reference.block_positions(remap, positions, block)
            if reference.in_source(remap, position)]


def find_empty_blocks(remap: reference.Remap) -> tuple[bool, ...]:
    """The blocks of which no pixel has a source."""
    return tuple(not block_sources(remap, block)
                 for block in range(reference.block_count(remap)))


def measure_error(blob: reference.Blob, lens: Lens, view: View,
                  remap: reference.Remap) -> int:
    """max_error_upx."""
    worst = 0.0
    for block in range(reference.block_count(remap)):
        for index, (x, y) in block_sources(remap, block):
            v, u = divmod(index, remap.width)
            exact = source_of(blob, lens, view, u, v)
            worst = max(worst, math.dist((x / Q12, y / Q12), exact))
    return math.ceil(worst * 1e6)


# The blobs


TURNED_LENS = Lens(centre=(81.3, 57.9), focal=72.0, k=0.25,
                   roll=math.radians(170))
# 1.92 rad or 110 degrees at the middle of the left and right edge.
WIDE_LENS = Lens(centre=(158.2, 121.4), focal=74.0, k=0.25,
                 roll=math.radians(-3))


def make_blob(camera: reference.Camera, lens: Lens,
              area: tuple[float, float, float, float], cells: tuple[int, int],
              view: View, quality: reference.Quality) -> reference.Blob:
    """A whole camera."""
    blob = reference.Blob(camera, make_grid(lens, area, cells))
    return dataclasses.replace(blob, remap=make_remap(blob, lens, view),
                               quality=quality)


def make_example() -> reference.Blob:
    """The worked example of SPEC.md: 60 degrees across, nearly a pinhole."""
    lens = Lens(centre=(31.7, 23.6), focal=55.0, k=0.95, roll=0.0)
    view = View(16, 8, block_log2=3, residual_shift=0, focal=28.0,
                bound_upx=100000)
    return make_blob(
        reference.Camera(64, 48, "example", "0001"), lens,
        (0.0, 0.0, 63.0, 47.0), (1, 1), view,
        reference.Quality(*[UNKNOWN] * 8, packing_error_npx=1308,
                          packing_error_prad=20580))


def make_lens() -> reference.Blob:
    """150 degrees across the diagonal, on a sensor that is turned by 170, seen
    by a pinhole that reaches beyond the calibrated area."""
    view = View(120, 90, block_log2=4, residual_shift=3, focal=24.0,
                bound_upx=4000000)
    return make_blob(
        reference.Camera(160, 120, "Weitwinkel \u00df", "L-150/7"), TURNED_LENS,
        (2.5, 1.25, 157.0, 118.5), (6, 5), view,
        reference.Quality(31000, 42000, 350000, 12345, 33000, 45000, 410000,
                          6789, 1729, 21835))


def make_wide() -> reference.Blob:
    """220 degrees across, off centre, with an inverse grid."""
    lens = WIDE_LENS
    camera = reference.Camera(320, 240, "wide", "")
    grid = make_grid(lens, (0.0, 0.0, 319.0, 239.0), (16, 12))
    blob = reference.Blob(camera, grid)
    views = (View(48, 36, block_log2=3, residual_shift=4, focal=9.0,
                  bound_upx=4000000, source=(60.3, 40.7, 250.2, 190.9)),
             View(36, 28, block_log2=4, residual_shift=6, focal=10.0,
                  bound_upx=4000000))
    first, second = (make_remap(blob, lens, view) for view in views)
    return dataclasses.replace(blob, inverse=make_inverse(blob, lens, (14, 11)),
                               remap=first, more_remaps=(second,), mask=make_mask(),
                               uncertainty=make_uncertainty())


def make_bent(wide: reference.Blob) -> reference.Blob:
    """The wide camera with control points of 16 bits and two tables with bends."""
    blob = reference.Blob(wide.camera, narrow_grid(wide.grid))
    views = (View(48, 36, block_log2=5, residual_shift=4, focal=9.0, bound_upx=4000000,
                  source=(60.3, 40.7, 250.2, 190.9), part_log2=3),
             View(48, 36, block_log2=6, residual_shift=6, focal=10.0, bound_upx=4000000,
                  part_log2=4))
    first, second = (make_remap(blob, WIDE_LENS, view) for view in views)
    return dataclasses.replace(blob, remap=first, more_remaps=(second,))


# A view of each projection; the pinhole looks to the right and up, and is rolled.
VIEWS = tuple(
    View(40, 30, block_log2=3, residual_shift=5, focal=focal, bound_upx=4000000,
         part_log2=0, projection=projection, angles=angles)
    for projection, focal, angles in (
        ("pinhole", 20.0, (40, 25, 10)), ("cylindrical", 12.0, (-30, 10, 0)),
        ("equirectangular", 11.0, (0, 0, 0)), ("stereographic", 9.0, (0, 0, -90)),
        ("equidistant", 10.0, (5, -20, 180))))


def make_views(wide: reference.Blob) -> reference.Blob:
    """The wide camera with control points of 16 bits and a table of each of VIEWS."""
    blob = reference.Blob(wide.camera, narrow_grid(wide.grid))
    first, *others = (make_remap(blob, WIDE_LENS, view) for view in VIEWS)
    return dataclasses.replace(blob, remap=first, more_remaps=tuple(others))


# Modes of the wide camera: a crop, binning by two that is mirrored, and a scaled crop upside down.
SENSOR_MODES = (
    reference.Mode(120, 100, (90 * Q16, 60 * Q16), (Q16, Q16), (0, 0), "crop"),
    reference.Mode(160, 120, (0, 0), (2 * Q16, 2 * Q16), (1, 0), "binned"),
    reference.Mode(96, 72, (40 * Q16, 30 * Q16), (5 * Q16 // 2, 5 * Q16 // 2), (0, 1), "scaled"))
MODE_VIEWS = (
    View(40, 30, block_log2=3, residual_shift=5, focal=20.0, bound_upx=4000000, mode=1),
    View(48, 32, block_log2=3, residual_shift=5, focal=9.0, bound_upx=4000000,
         projection="stereographic", angles=(20, 0, 0), mode=2),
    View(40, 30, block_log2=4, residual_shift=5, focal=16.0, bound_upx=4000000,
         projection="equidistant", mode=3, part_log2=3),
    View(64, 48, block_log2=5, residual_shift=6, focal=18.0, bound_upx=9000000,
         projection="equidistant", angles=(10, 0, 0), distorts=True))


def make_modes(wide: reference.Blob) -> reference.Blob:
    """The wide camera with control points of 16 bits, SENSOR_MODES, and a table of each of MODE_VIEWS."""
    blob = reference.Blob(wide.camera, narrow_grid(wide.grid), modes=SENSOR_MODES)
    first, *others = (make_remap(blob, WIDE_LENS, view) for view in MODE_VIEWS)
    return dataclasses.replace(blob, remap=first, more_remaps=tuple(others))


def make_mask() -> reference.Mask:
    """Cells of 32 px of make_wide(): valid but for two corners."""
    return reference.Mask(10, 8, 5, tuple(3 < i + j < 13 for j in range(8) for i in range(10)))


def make_uncertainty() -> reference.Uncertainty:
    """Values of make_wide() that grow to the right and downwards; the last is not known."""
    values = [40 + 3 * i * i + 7 * j for j in range(3) for i in range(5)]
    return reference.Uncertainty(5, 3, (*values[:-1], reference.UNKNOWN_UNCERTAINTY))


def make_lines(example: reference.Blob) -> reference.Blob:
    """The example's camera with points up to 5 cm from its centre, and two of
    the largest."""
    lcg = Lcg(3)
    points = [tuple((lcg.next() - (1 << 31)) * 5 // 100 >> 3 for _ in range(3))
              for _ in range(16)]
    limit = reference.LINE_POINT_LIMIT
    points[5], points[15] = (limit, -limit, limit), (-limit, -limit, limit)
    return dataclasses.replace(example, remap=None, quality=None, line_points=tuple(points))


def make_capture(example: reference.Blob) -> reference.Blob:
    """The example's camera, focused to half a metre, of the middle of a sensor of 264 x 200 pixels,
    upside down, at 5 degrees below zero."""
    capture = reference.Capture(2 * Q16, Q16 // 10, (4, 4, 256, 192), 66191, 3,
                                -5 * Q16, 8333, 3 * Q16 // 2)
    return dataclasses.replace(example, remap=None, quality=None, capture=capture)


STACK_LENSES = tuple(
    Lens(centre=(158.2 + x, 121.4 + y), focal=144.0 * scale, k=0.25, roll=math.radians(-3))
    for x, y, scale in ((-0.9, 0.6, 0.98), (0.0, 0.0, 1.0), (1.3, -0.4, 1.025)))
STACK_VALUES = (-Q16 // 2, 2 * Q16, 6 * Q16 + 12345)
# Before the range, at its ends and at a knot, and between: close to a knot, too.
STACK_CONDITIONS = (-3 * Q16, STACK_VALUES[0], STACK_VALUES[0] + 7, Q16, STACK_VALUES[1],
                    5 * Q16 + 1, STACK_VALUES[2] - 1, STACK_VALUES[2], 9 * Q16)
FORMATS_CONDITION = STACK_CONDITIONS[3]  # that of frames of all formats
STACK_VIEWS = (
    View(48, 36, block_log2=5, residual_shift=4, focal=24.0, bound_upx=9000000,
         source=(60.3, 40.7, 250.2, 190.9), part_log2=3),
    View(48, 36, block_log2=3, residual_shift=5, focal=7.0, bound_upx=9000000),
    View(40, 30, block_log2=4, residual_shift=4, focal=22.0, bound_upx=9000000, part_log2=3,
         projection="cylindrical", angles=(8, 3, 0)))


def make_stack(wide: reference.Blob) -> reference.Blob:
    """A camera as large as the wide one, of 150 degrees, whose focal length and centre change with
    the position of the lens, with control points of 16 bits. The blob's own sections are the camera at 2 dioptres."""
    area = (0.0, 0.0, 319.0, 239.0)
    blobs = [reference.Blob(wide.camera, narrow_grid(make_grid(optics, area, (6, 5))))
             for optics in STACK_LENSES]
    seen = [chart for blob in blobs for chart in area_charts(blob)]
    whole = [dataclasses.replace(blob, inverse=make_inverse(blob, optics, (8, 6), seen))
             for blob, optics in zip(blobs, STACK_LENSES)]
    tables = [[make_remap(blob, optics, view) for blob, optics in zip(blobs, STACK_LENSES)]
              for view in STACK_VIEWS]
    grids = alike_grids([blob.grid for blob in whole])
    inverses = alike_grids([blob.inverse.grid for blob in whole])
    knots = tuple(
        reference.Knot(grid, reference.InverseGrid(inverse, blob.inverse.cos_limit), remaps)
        for blob, grid, inverse, remaps in zip(whole, grids, inverses,
                                               zip(*map(alike_tables, tables))))
    own = knots[1]
    return reference.Blob(
        wide.camera, own.grid, own.remaps[0], inverse=own.inverse, more_remaps=own.remaps[1:],
        stack=reference.Stack(reference.LENS_POSITION, STACK_VALUES, knots))


def alike_grids(grids: list[reference.CentralGrid]) -> list[reference.CentralGrid]:
    """Narrow grids with the fraction bits of the one that has fewest."""
    bits = min(grid.fraction_bits for grid in grids)
    unit = 1 << 29 - bits
    return [dataclasses.replace(grid, fraction_bits=bits, control_points=tuple(
        tuple(base + (value - base) // unit * unit for value, base in zip(point, plane))
        for point, plane in zip(grid.control_points, reference.plane_points(grid, grid.plane))))
            for grid in grids]


def alike_tables(tables: list[reference.Remap]) -> list[reference.Remap]:
    """Tables whose fields and masks are those of the middle one: residuals hold how they differ."""
    middle = tables[len(tables) // 2]
    shift = max(table.bend_shift for table in tables)
    plane = reference.vertex_positions(
        dataclasses.replace(middle, vertices=((0, 0),) * len(middle.vertices)))
    unit = 1 << middle.residual_shift
    empty = tuple(map(all, zip(*(table.empty_blocks for table in tables))))
    return [dataclasses.replace(
        middle, empty_blocks=empty, bend_shift=shift, max_error_upx=table.max_error_upx,
        vertices=tuple(tuple(round((p - base) / unit) for p, base in zip(*pair))
                       for pair in zip(reference.vertex_positions(table), plane)),
        bends=tuple(tuple(bend << table.bend_shift >> shift for bend in bends)
                    for bends in table.bends)) for table in tables]


def make_row_time(example: reference.Blob) -> reference.Blob:
    """The example's camera, whose last row is read first, 20 microseconds a row, known to 31 ns."""
    row_time = reference.RowTime(-20000 << 10, 31 << 10)
    return dataclasses.replace(example, remap=None, quality=None, row_time=row_time)


def make_narrow(lens: reference.Blob) -> reference.Blob:
    """The lens's camera with control points of 16 bits, and an inverse grid."""
    blob = reference.Blob(lens.camera, narrow_grid(lens.grid))
    return dataclasses.replace(blob, inverse=make_inverse(blob, TURNED_LENS, (8, 6)))


def make_seen_lines(narrow: reference.Blob) -> reference.Blob:
    """The narrow camera with lines through an entrance pupil that moves outwards and backwards, by
    up to 6 mm: from the centre, what the edge sees looks as if it were outside."""
    grid = narrow.grid
    points = []
    for j in range(-1, grid.rows - 1):
        for i in range(-1, grid.columns - 1):
            a = 1.6 * i / (grid.columns - 3) - 0.8
            b = 1.2 * j / (grid.rows - 3) - 0.6
            points.append(tuple(round(value * Q28) for value in (
                0.0004 + 0.003 * a - 0.001 * b, 0.002 * b - 0.0003, -0.006 * (a * a + b * b))))
    return dataclasses.replace(narrow, line_points=tuple(points))


def narrow_grid(grid: reference.CentralGrid) -> reference.CentralGrid:
    """A grid's control points as a plane and 16 bits."""
    fits = [narrow_fit(grid, axis) for axis in (0, 1)]
    plane = tuple(fits[axis][k] for k in range(3) for axis in (0, 1))
    planes = list(reference.plane_points(grid, plane))
    left = [tuple(point[axis] - base[axis] for axis in (0, 1))
            for point, base in zip(grid.control_points, planes)]
    largest = max(abs(value) for pair in left for value in pair)
    fraction_bits = max(bits for bits in reference.NARROW_FRACTION_BITS
                        if largest < 32767 << 29 - bits)
    unit = 1 << 29 - fraction_bits
    points = tuple(tuple(base[axis] + round(pair[axis] / unit) * unit for axis in (0, 1))
                   for pair, base in zip(left, planes))
    return dataclasses.replace(grid, control_points=points, fraction_bits=fraction_bits,
                               plane=plane)


def narrow_fit(grid: reference.CentralGrid, axis: int) -> tuple[int, int, int]:
    """Origin, column step and row step of one coordinate, from edge to edge."""
    values = [point[axis] for point in grid.control_points]
    columns, rows = grid.columns, grid.rows
    across = round((sum(values[columns - 1::columns]) - sum(values[::columns]))
                   / rows / (columns - 1))
    down = round((sum(values[-columns:]) - sum(values[:columns])) / columns / (rows - 1))
    plane = [i * across + j * down for j in range(rows) for i in range(columns)]
    return round((sum(values) - sum(plane)) / len(values)), across, down


def line_lines(blob: reference.Blob) -> Iterator[str]:
    """Entries of a table of pixels and their lines' points, q28."""
    for x, y in golden_pixels(blob.grid)[:40]:
        point = reference.line_point(blob, x / Q16, y / Q16)
        if point is not None:
            yield table_line((x, y), [round(value * Q28) for value in point])


def area_charts(blob: reference.Blob) -> list[Point]:
    """Chart positions that pixels of the area look along."""
    return [chart_of(reference.unproject(blob, x, y)) for x, y in area_samples(blob.grid)]


def make_inverse(blob: reference.Blob, lens: Lens, cells: tuple[int, int],
                 seen: list[Point] | None = None) -> reference.InverseGrid:
    """The grid of pixels that see chart positions in the blob's grid, to third order; over the
    rectangle of those chart positions, or of what the blob sees."""
    charts = seen or area_charts(blob)
    corners = []
    for axis in (0, 1):
        values = [chart[axis] for chart in charts]
        margin = 0.01 * (max(values) - min(values))
        corners.append((round((min(values) - margin) * Q27),
                        round((max(values) + margin) * Q27)))
    (a0, a1), (b0, b1) = corners
    columns, rows = cells[0] + 3, cells[1] + 3
    step_a, step_b = (a1 - a0) / cells[0] / Q27, (b1 - b0) / cells[1] / Q27

    def pixel_of(a: float, b: float) -> Point:
        return project(blob, lens, reference.direction(a, b))

    nodes = [(a0 / Q27 + i * step_a, b0 / Q27 + j * step_b)
             for j in range(-1, rows - 1) for i in range(-1, columns - 1)]
    values = [pixel_of(*node) for node in nodes]
    points = [control_point(pixel_of, node, step_a, step_b) for node in nodes]
    for _ in range(6):
        points = closer_points(points, values, columns)
    grid = reference.CentralGrid(a0, b0, a1, b1, columns, rows, tuple(
        (round(x * Q17), round(y * Q17)) for x, y in points))
    return reference.InverseGrid(narrow_grid(grid), cos_limit(charts))


def closer_points(points: list[Point], values: list[Point], columns: int) -> list[Point]:
    """Control points, moved by what their spline lacks of the values at the nodes inside."""
    closer = list(points)
    for k in range(columns + 1, len(points) - columns - 1):
        if 0 < k % columns < columns - 1:
            around = [(points[k + row + column], (4 if row == 0 else 1) * (4 if column == 0 else 1))
                      for row in (-columns, 0, columns) for column in (-1, 0, 1)]
            closer[k] = tuple(points[k][c] + values[k][c]
                              - sum(weight * point[c] for point, weight in around) / 36
                              for c in (0, 1))
    return closer


def cos_limit(charts: list[Point]) -> int:
    """A little beyond the widest of the directions."""
    cosine = min((1 - a * a - b * b) / (1 + a * a + b * b) for a, b in charts)
    return math.floor((cosine * abs(cosine) - 1e-3) * Q30)


def area_samples(grid: reference.CentralGrid) -> Iterator[Point]:
    """Pixels of the area: its edge at every quarter, its inside more coarsely."""
    x0, y0, x1, y1 = (value / Q16 for value in (grid.x0, grid.y0, grid.x1, grid.y1))
    for k in range(0, 4 * int(x1 - x0) + 1):
        yield from ((x0 + k / 4, y0), (x0 + k / 4, y1))
    for k in range(0, 4 * int(y1 - y0) + 1):
        yield from ((x0, y0 + k / 4), (x1, y0 + k / 4))
    for j in range(61):
        for i in range(81):
            yield x0 + (x1 - x0) * i / 80, y0 + (y1 - y0) * j / 60


def chart_of(ray: Ray) -> Point:
    """Stereographic coordinates of a direction."""
    scale = 1 / (math.hypot(*ray) + ray[2])
    return ray[0] * scale, ray[1] * scale


# Expected results


def golden_pixels(grid: reference.CentralGrid) -> list[reference.Pair]:
    """Corners, edges, cell borders and others of the area, q16."""
    xs = (grid.x0, (grid.x0 + grid.x1) // 2, grid.x1)
    ys = (grid.y0, (grid.y0 + grid.y1) // 2, grid.y1)
    pixels = [(x, y) for y in ys for x in xs]
    pixels += [(grid.x1 - 1, grid.y1 - 1), (grid.x0 + 1, grid.y0 + 1)]
    for cell in range(1, 5):
        x = grid.x0 + cell * (grid.x1 - grid.x0) // (grid.columns - 3)
        y = grid.y0 + cell * (grid.y1 - grid.y0) // (grid.rows - 3)
        pixels += [(x, y), (x - 1, y + 1), (x + 1, y - 1)]
    lcg = Lcg(1)
    pixels += [(grid.x0 + lcg.below(grid.x1 - grid.x0 + 1),
                grid.y0 + lcg.below(grid.y1 - grid.y0 + 1))
               for _ in range(60 - len(pixels))]
    return pixels


def ray_q30(ray: Ray) -> list[int]:
    """A direction as the tables hold it."""
    return [round(value * Q30) for value in ray]


def pixel_lines(blob: reference.Blob) -> Iterator[str]:
    """Entries of a table of pixels and their rays."""
    for x, y in golden_pixels(blob.grid):
        ray = reference.unproject(blob, x / Q16, y / Q16)
        yield table_line((x, y), ray_q30(ray))


def project_exactly(blob: reference.Blob, lens: Lens,
                    ray: Ray) -> Point | None:
    """The pixel of the area that looks along a direction, in double precision:
    the lens corrected by what the grid differs from it."""
    if angle_of(ray) > WIDE_LIMIT:
        return None
    x, y = project(blob, lens, ray)
    grid = blob.grid
    outside = max(grid.x0 / Q16 - x, x - grid.x1 / Q16,
                  grid.y0 / Q16 - y, y - grid.y1 / Q16)
    assert abs(outside) > 0.01, "too near to the edge to be told"
    return None if outside > 0 else (x, y)


WIDE_LIMIT = 2.7  # rad; no pixel of make_wide() sees farther


def angle_of(ray: Ray) -> float:
    """From the z axis."""
    return math.atan2(math.hypot(ray[0], ray[1]), ray[2])


def random_directions(count: int) -> Iterator[tuple[int, int, int]]:
    """Integer vectors of all directions and many lengths."""
    lcg = Lcg(17)
    for k in range(count):
        shift = k % 28
        yield tuple((lcg.next() - (1 << 31)) >> shift for _ in range(3))


def projection_lines(blob: reference.Blob, lens: Lens) -> Iterator[str]:
    """Entries of a table of directions and their pixels."""
    for vector in random_directions(400):
        if not any(vector):
            continue
        pixel = project_exactly(blob, lens, vector)
        x, y = (round(value * Q16) for value in pixel) if pixel else (UNSEEN, UNSEEN)
        yield table_line((x, y), list(vector))


UNSEEN = "INT32_MIN"


def seen_exactly(blob: reference.Blob, point: Ray, start: Point) -> Point:
    """The pixel whose line goes through a point, by Newton's method in double precision with
    differences of 1/64 px into the area; start is the nearest pixel of the area or close to it."""
    grid = blob.grid
    middle = ((grid.x0 + grid.x1) / 2 / Q16, (grid.y0 + grid.y1) / 2 / Q16)
    ends = ((grid.x0 / Q16, grid.x1 / Q16), (grid.y0 / Q16, grid.y1 / Q16))

    def miss(pixel: Point) -> Point:
        origin = reference.line_point(blob, *pixel)
        wanted = chart_of(tuple(p - o for p, o in zip(point, origin)))
        found = chart_of(reference.unproject(blob, *pixel))
        return wanted[0] - found[0], wanted[1] - found[1]

    x, y = start
    for _ in range(12):
        inside = tuple(min(max(value, low), high) for value, (low, high) in zip((x, y), ends))
        steps = [math.copysign(1 / 64, centre - value) for centre, value in zip(middle, inside)]
        here = miss(inside)
        across = [(value - base) / steps[0]
                  for value, base in zip(miss((inside[0] + steps[0], inside[1])), here)]
        down = [(value - base) / steps[1]
                for value, base in zip(miss((inside[0], inside[1] + steps[1])), here)]
        determinant = across[0] * down[1] - across[1] * down[0]
        x = inside[0] - (here[0] * down[1] - here[1] * down[0]) / determinant
        y = inside[1] - (across[0] * here[1] - across[1] * here[0]) / determinant
    return x, y


def point_lines(blob: reference.Blob) -> Iterator[str]:
    """Entries of a table of points in q24 m and the pixels that see them: on the lines of pixels
    inside and at the edge of the area, and up to 2 px outside of it."""
    lcg = Lcg(5)
    grid = blob.grid
    ends = ((grid.x0 / Q16, grid.x1 / Q16), (grid.y0 / Q16, grid.y1 / Q16))
    for k in range(240):
        start = [low + (high - low) * lcg.below(Q16) / Q16 for low, high in ends]
        if k % 3 != 0:  # near an edge
            axis, end = k % 2, k // 2 % 2
            inwards = 2 ** -(lcg.below(8)) * (1 - 2 * end)
            start[axis] = ends[axis][end] + inwards
        distance = 0.1 * 1.5 ** lcg.below(17)
        origin, ray = reference.line_point(blob, *start), reference.unproject(blob, *start)
        point = [o + distance * r for o, r in zip(origin, ray)]
        if k % 6 == 1:  # across that edge
            point = [value + distance * 0.02 * (lcg.below(3) - 1) for value in point]
        point_q24 = [round(value * Q24) for value in point]
        x, y = seen_exactly(blob, tuple(value / Q24 for value in point_q24), tuple(start))
        outside = max(max(low - value, value - high) for value, (low, high) in zip((x, y), ends))
        if abs(outside) < 0.004:
            continue  # too near to the edge to be told
        seen = (round(x * Q16), round(y * Q16)) if outside < 0 else (UNSEEN, UNSEEN)
        yield table_line(seen, point_q24)


# Frames of every format: the lattices of SPEC.md and where their samples lie


class Placement(NamedTuple):
    """A lattice's samples in a plane."""

    lattice: reference.Lattice
    plane: int
    kind: str  # u8, u16, 10p, 12p, 565
    first: int
    step: int
    channels: int
    border: int  # index of the first channel's value


def kind_of(samples: str) -> str:
    """A name of pixel_formats.toml in lower case, u8 for 8, u16 for 16."""
    return f"u{samples}" if samples in ("8", "16") else samples.lower()


def read_placements(samples: str, components: list[dict]) -> Iterator[Placement]:
    """A format's components; those of one format have their border values in turn."""
    border = 0
    for c in components:
        (lx, ly), (hx, hy) = c.get("log2", (0, 0)), c.get("half", (0, 0))
        channels = c.get("channels", 1)
        yield Placement(reference.Lattice(lx, ly, hx, hy), c.get("plane", 0), kind_of(samples),
                        c.get("first", 0), c["step"], channels, border)
        border += channels


DESCRIPTION = tomllib.loads((ROOT / "formats/pixel_formats.toml").read_text(encoding="utf-8"))
BYTES_PER_8_SAMPLES = {kind_of(name): kind["step"]
                       for name, kind in DESCRIPTION["samples"].items()}
# In the order of rg_format.
FORMAT_NAMES = tuple(DESCRIPTION["formats"])
FORMATS = tuple(tuple(read_placements(f["samples"], DESCRIPTION["layouts"][f["layout"]]))
                for f in DESCRIPTION["formats"].values())
# Shift and mask of red, green and blue: four samples are a word, the fourth of them nothing.
FIELDS_565 = ((11, 31), (5, 63), (0, 31))
BORDER_VALUES = (BORDER, 17, 130, 66)
KEPT_BYTE = 0xa5
# Border and sampling of the golden frames: value, clamp, keep.
MODES = (("value", False), (reference.BORDER_CLAMP, False), (None, True))


def plane_sizes(placements: tuple[Placement, ...], width: int,
                height: int) -> dict[int, Pair]:
    """Bytes a row and rows of each plane."""
    sizes = {}
    for lattice, plane, kind, _, step, _, _ in placements:
        samples = (width >> lattice.lx) * step
        is_bayer = len(placements) == 4
        rows = height if is_bayer else height >> lattice.ly
        sizes[plane] = (samples * BYTES_PER_8_SAMPLES[kind] // 8, rows)
    return sizes


def get_sample(kind: str, row: bytes, index: int) -> int:
    """A sample of a row of bytes."""
    if kind == "u8":
        return row[index]
    if kind == "u16":
        return row[2 * index] + 256 * row[2 * index + 1]
    if kind == "565":
        shift, mask = FIELDS_565[index % 4]
        return get_sample("u16", row, index // 4) >> shift & mask
    count, bits = (4, 2) if kind == "10p" else (2, 4)
    group = row[index // count * (count + 1):][:count + 1]
    low = group[count] >> (bits * (index % count)) & ((1 << bits) - 1)
    return group[index % count] << bits | low


def get_samples(kind: str, row: bytes, first: int, step: int, count: int) -> list[int]:
    """Every so many samples of a row of bytes."""
    if kind == "u8":
        return list(row[first:first + count * step:step])
    return [get_sample(kind, row, first + i * step) for i in range(count)]


def put_sample(kind: str, row: bytearray, index: int, value: int) -> None:
    """The other way round."""
    if kind == "u8":
        row[index] = value & 255
    elif kind == "u16":
        row[2 * index:2 * index + 2] = value.to_bytes(2, "little")
    elif kind == "565":
        shift, mask = FIELDS_565[index % 4]
        others = get_sample("u16", row, index // 4) & ~(mask << shift)
        put_sample("u16", row, index // 4, others | (value & mask) << shift)
    else:
        count, bits = (4, 2) if kind == "10p" else (2, 4)
        group, k = index // count * (count + 1), index % count
        mask = (1 << bits) - 1
        row[group + k] = value >> bits
        row[group + count] = (row[group + count] & ~(mask << bits * k)
                              | (value & mask) << bits * k)


def lattice_row(place: Placement, j: int) -> int:
    """The row of the plane that row j of the lattice lies in."""
    is_bayer = place.lattice.ly == 1 and place.lattice.hy != 1
    return 2 * j + place.lattice.hy // 2 if is_bayer else j


def format_crc(blob: reference.Blob, placements: tuple[Placement, ...],
               border: str | None, nearest: bool) -> int:
    """CRC of the planes of the test frame, undistorted."""
    remap = blob.remap
    source = {plane: [bytearray(row) for row in reference.sample_rows(make_frame(*size), size[0])]
              for plane, size in plane_sizes(placements, *source_size(blob)).items()}
    output = {plane: [bytearray([KEPT_BYTE]) * size[0] for _ in range(size[1])]
              for plane, size in plane_sizes(placements, remap.width, remap.height).items()}
    for place in placements:
        for channel in range(place.channels):
            remap_channel(blob, place, channel, source[place.plane], output[place.plane],
                          border, nearest)
    planes = (b"".join(rows) for _, rows in sorted(output.items()))
    return zlib.crc32(b"".join(planes))


def remap_channel(blob: reference.Blob, place: Placement, channel: int,
                  source: list[bytearray], output: list[bytearray],
                  border: str | None, nearest: bool) -> None:
    """One channel of a lattice."""
    first = place.first + channel
    width, height = source_size(blob)
    samples = [get_samples(place.kind, source[lattice_row(place, j)], first, place.step,
                           width >> place.lattice.lx)
               for j in range(height >> place.lattice.ly)]
    value = BORDER_VALUES[place.border + channel] if border == "value" else border
    bits = 8 if place.kind == "u8" else 16
    for j, row in enumerate(reference.remap_lattice(blob, place.lattice, samples, bits, value,
                                                    nearest)):
        for i, sample in enumerate(row):
            if sample is not None:
                put_sample(place.kind, output[lattice_row(place, j)], first + i * place.step,
                           sample)


def undistorted_lines(blob: reference.Blob) -> Iterator[str]:
    """Entries of a table of the pixels of pixel_lines() in the undistorted image."""
    for x, y in golden_pixels(blob.grid):
        ray = reference.unproject(blob, x / Q16, y / Q16)
        scaled = [blob.remap.fx * ray[0], blob.remap.fy * ray[1]]
        centre = (blob.remap.cx, blob.remap.cy)
        point = ([round(a / ray[2]) + c for a, c in zip(scaled, centre)]
                 if ray[2] > 1e-3 else [1 << 30])
        if max(map(abs, point)) >= 1 << 30:
            point = [UNSEEN, UNSEEN]
        yield f"    {{{point[0]}, {point[1]}}},"


def undistorted_view_lines(blob: reference.Blob, view: View) -> Iterator[str]:
    """Entries of a table of the pixels of the blob's grid in a view."""
    for x, y in golden_pixels(blob.grid):
        point = [p * Q16 for p in view.pixel(reference.unproject(blob, x / Q16, y / Q16))]
        seen = max(map(abs, point)) < 1 << 30
        yield f"    {{{', '.join(str(round(p) if seen else UNSEEN) for p in point)}}},"


def chart_lines() -> Iterator[str]:
    """Entries of a table of chart positions and their rays."""
    for a, b in CHART_POINTS:
        ray = reference.direction(a, b)
        yield table_line((round(a * Q29), round(b * Q29)), ray_q30(ray))


def table_line(pair: Iterable[int], ray: Iterable[int]) -> str:
    """One entry."""
    return (f"    {{{', '.join(map(str, pair))},"
            f" {{{', '.join(map(str, ray))}}}}},")


@functools.cache
def make_frame(width: int, height: int) -> bytes:
    """The test image: a gradient and noise."""
    lcg = Lcg(FRAME_SEED)
    return bytes((2 * x + y + (lcg.next() >> 27)) % 256
                 for y in range(height) for x in range(width))


def border_pixels(blob: reference.Blob) -> int:
    """How many pixels of the output have no source."""
    frame = bytes([1]) * (blob.camera.width * blob.camera.height)
    return reference.remap_grey(blob, frame, 0).count(0)


def remap_crc(blob: reference.Blob) -> int:
    """CRC of the test image, undistorted."""
    return zlib.crc32(reference.remap_grey(blob, make_frame(*source_size(blob)), BORDER))


def source_size(blob: reference.Blob) -> reference.Size:
    """Size of the frames that the blob's table takes."""
    if blob.remap.view is None:
        return reference.Size(blob.camera.width, blob.camera.height)
    return blob.remap.view.source


# Output


# Names of blobs without their suffix, in the order of the header, and what they are.
BLOBS = {
    "example": "The worked example of SPEC.md.",
    "lens": "A wide lens on a turned sensor.",
    "narrow": "The lens of kLensBlob with control points of 16 bits and an inverse grid.",
    "wide": "220 degrees, with an inverse grid: version 1.3.",
    "lines": "A non-central camera.",
    "seen_lines": "The narrow camera with lines instead of rays.",
    "bent": "The camera of kWideBlob with two tables with bends: version 1.4.",
    "views": "The camera of kWideBlob with a view of each projection: version 1.5.",
    "modes": "The camera of kWideBlob with three modes, a table of each, and one that distorts.",
    "capture": "The example's camera without tables, and how it stood: version 1.6.",
    "stack": "A lens of 150 degrees at three positions, with three tables: version 1.6.",
    "row_time": "The example's camera without tables, and its row time: version 1.6.",
}


def blob_name(name: str) -> str:
    """The array of a blob's bytes."""
    return f"k{name.title().replace('_', '')}Blob"


def array_lines(comment: str, declaration: str, rows: Iterable[str]) -> Iterator[str]:
    """A table in C."""
    yield from (f"/* {comment} */", f"static const {declaration} = {{", *rows, "};", "")


class Frames:
    """CRCs of frames.csv."""

    def __init__(self) -> None:
        with open(VECTORS / "frames.csv", encoding="utf-8", newline="") as file:
            self.rows = list(csv.DictReader(file))

    def crcs(self, blob: str, condition: str = "", **wanted: str) -> list[str]:
        """Those of a blob, as numbers in C, where columns have the wanted values."""
        wanted = {"blob": blob, "condition_q16": condition, **wanted}
        return [f"0x{row['crc32']}u" for row in self.rows if wanted.items() <= row.items()]

    def grey(self, blob: str, condition: str = "") -> list[str]:
        """Those of grey frames with the border GOLDEN_BORDER, by table."""
        return self.crcs(blob, condition, format="GREY8", border="value")

    def format_lines(self, blob: str, table: int, condition: str = "") -> Iterator[str]:
        """Entries of a table by format and mode."""
        for name in FORMAT_NAMES:
            crcs = self.crcs(blob, condition, table=str(table), format=name)
            yield f"    {{{', '.join(crcs)}}},"


def header_lines() -> Iterator[str]:
    """golden_blobs.h."""
    data = {name: (VECTORS / f"{name}.raygrid").read_bytes() for name in BLOBS}
    blobs = {name: reference.parse(blob) for name, blob in data.items()}
    frames = Frames()
    yield PREAMBLE
    yield f"#define GOLDEN_FRAME_SEED {FRAME_SEED}u"
    yield f"#define GOLDEN_BORDER {BORDER}u"
    yield f"#define GOLDEN_EXAMPLE_REMAP_CRC {frames.grey('example')[0]}"
    yield f"#define GOLDEN_LENS_REMAP_CRC {frames.grey('lens')[0]}"
    yield f"#define GOLDEN_LENS_BORDER_PIXELS {border_pixels(blobs['lens'])}u"
    yield "/* Frames of each rg_format: border of GOLDEN_BORDER_VALUES; clamped; kept bytes of GOLDEN_KEPT,"
    yield " * nearest. */"
    yield f"#define GOLDEN_BORDER_VALUES {', '.join(map(str, BORDER_VALUES))}"
    yield f"#define GOLDEN_KEPT 0x{KEPT_BYTE:02x}"
    yield f"#define GOLDEN_STACK_VALUE {FORMATS_CONDITION}"
    for name, comment in BLOBS.items():
        yield from array_lines(comment, f"uint8_t {blob_name(name)}[{len(data[name])}] GOLDEN_ALIGNED",
                               [",".join(map(str, data[name]))])
    for name in ("lens", "narrow", "views"):
        yield from array_lines(f"q16 pixels of {blob_name(name)}.", f"golden_ray k{name.title()}Rays[]",
                               pixel_lines(blobs[name]))
    yield from array_lines("The pixels of kLensRays in the undistorted image, q16, or INT32_MIN.",
                           "int32_t kLensUndistorted[][2]", undistorted_lines(blobs["lens"]))
    yield from array_lines("q16 pixels of kWideBlob, or INT32_MIN, of directions of any length.",
                           "golden_ray kWideProjections[]", projection_lines(blobs["wide"], WIDE_LENS))
    yield from array_lines("q16 pixels of kLinesBlob, and their lines' points in q28.",
                           "golden_ray kLinePoints[]", line_lines(blobs["lines"]))
    yield from array_lines("q16 pixels of kSeenLinesBlob, or INT32_MIN, that see points in q24 m.",
                           "golden_ray kSeenPoints[]", point_lines(blobs["seen_lines"]))
    yield from array_lines("The pixels of kViewsRays in the image of each table, q16, or INT32_MIN.",
                           "int32_t kViewsUndistorted[][sizeof kViewsRays / sizeof kViewsRays[0]][2]",
                           (f"{{{''.join(undistorted_view_lines(blobs['views'], view))}}}," for view in VIEWS))
    for array, blob, table, condition in (
            ("kFormatCrcs", "wide", 0, ""), ("kBentFormatCrcs", "bent", 0, ""),
            ("kMoreBentFormatCrcs", "bent", 1, ""), ("kStackFormatCrcs", "stack", 0, FORMATS_CONDITION),
            ("kStackPlainFormatCrcs", "stack", 1, FORMATS_CONDITION)):
        yield from array_lines(f"Frames of each format with table {table} of {blob_name(blob)}.",
                               f"uint32_t {array}[][3]", frames.format_lines(blob, table, str(condition)))
    for name in ("views", "modes"):
        yield from array_lines("Of grey frames, by table.", f"uint32_t k{name.title()}Crcs[]",
                               [",".join(frames.grey(name))])
    yield "typedef struct golden_stack_crcs {\n  int32_t value_q16;\n  uint32_t crcs[3];\n} golden_stack_crcs;"
    yield from array_lines("q16 dioptres, and the CRCs of what the three tables undistort there.",
                           "golden_stack_crcs kStackCrcs[]",
                           (f"{{{value}, {{{','.join(frames.grey('stack', str(value)))}}}}},"
                            for value in STACK_CONDITIONS))
    yield from array_lines("q29 chart positions, up to the limit.", "golden_ray kChartRays[]", chart_lines())
    yield from array_lines("All blobs.", "golden_blob kGoldenBlobs[]",
                           (f"{{{name}, sizeof({name})}}," for name in map(blob_name, BLOBS)))
    yield "#define NUM_GOLDEN_BLOBS (sizeof(kGoldenBlobs) / sizeof(kGoldenBlobs[0]))"
    yield "#endif /* RAYGRID_GOLDEN_BLOBS_H */"


PREAMBLE = """\
/* Generated by tests/golden/make_golden.py from formats/vectors. */
#ifndef RAYGRID_GOLDEN_BLOBS_H
#define RAYGRID_GOLDEN_BLOBS_H

#include <stdint.h>

#define GOLDEN_ALIGNED __attribute__((aligned(4)))

/* A position and its direction, computed in double precision and rounded. */
typedef struct golden_ray {
  int32_t x, y;
  int32_t ray_q30[3];
} golden_ray;

typedef struct golden_blob {
  const uint8_t* bytes;
  uint32_t size;
} golden_blob;

/* Test image: state = seed; pixel by pixel, row by row,
 *   state = 1664525 state + 1013904223, value = 2 x + y + (state >> 27)
 * and the CRC-32 of the images undistorted from it. */
"""


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    path = Path(sys.argv[1])
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(header_lines()) + "\n", encoding="utf-8")
