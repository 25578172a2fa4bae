#!/usr/bin/env python3
"""Rays, lines and projections of the runtime, bit for bit those of the reference reader."""
import dataclasses
import itertools
import os
import random
import unittest

import blob_reference as reference
import make_golden
import runtime_camera

COUNT = int(os.environ.get("RAYGRID_REFERENCE_COUNT", "10000"))  # or more: pixels, points
NONE = -2**31
CONDITIONS = {}  # of the camera that a stack is at a condition, by its id: the stack, and that value
LARGEST = 2**31 - 1


class Camera(runtime_camera.Camera):
    """Of the reference's blob; of a stack at a condition."""

    def __init__(self, blob):
        stack, condition = CONDITIONS.get(id(blob), (blob, None))
        super().__init__(reference.serialize(stack), condition)


def make_tele():
    """Two degrees across: the inverse grid's rectangle is small, and its scale large."""
    lens = make_golden.Lens(centre=(155.1, 123.3), focal=9000.0, k=0.9, roll=0.3)
    camera = reference.Camera(320, 240, "tele", "")
    blob = reference.Blob(camera, make_golden.make_grid(lens, (-0.5, -0.5, 319.5, 239.5), (5, 4)))
    return dataclasses.replace(blob, inverse=make_golden.make_inverse(blob, lens, (7, 5)))


def with_bits(grid, bits):
    """A narrow grid with fewer fraction bits."""
    unit = 1 << 29 - bits
    points = tuple(tuple(base + (value - base) // unit * unit for value, base in zip(point, plane))
                   for point, plane in zip(grid.control_points,
                                           reference.plane_points(grid, grid.plane)))
    return dataclasses.replace(grid, control_points=points, fraction_bits=bits)


def with_noise(inverse, noise_px, seed):
    """An inverse grid that leads beside the right pixels, with other slopes: Newton's method takes
    all its steps, and often longer ones than it may."""
    generator = random.Random(seed)
    grid = with_bits(inverse.grid, inverse.grid.fraction_bits - 1)
    unit = 1 << 29 - grid.fraction_bits
    points = tuple(tuple(value + round(generator.uniform(-noise_px, noise_px) * 2**17 / unit) * unit
                         for value in point) for point in grid.control_points)
    return dataclasses.replace(inverse, grid=dataclasses.replace(grid, control_points=points))


def with_wild_points(blob, seed):
    """Control points, and points of lines, of all sizes there may be."""
    generator = random.Random(seed)
    limit = reference.CONTROL_POINT_LIMIT

    def some():
        return generator.choice((-limit, limit, generator.randint(-limit, limit)))

    number = blob.grid.columns * blob.grid.rows
    points = tuple((some(), some()) for _ in range(number))
    grid = dataclasses.replace(blob.grid, control_points=points, fraction_bits=29, plane=())
    lines = tuple((some(), some(), some()) for _ in range(number))
    return dataclasses.replace(blob, grid=grid, line_points=lines)


def with_wild_residuals(blob, bits, seed):
    """A plane and residuals of all sizes there may be."""
    generator = random.Random(seed)
    grid = blob.grid
    room = reference.CONTROL_POINT_LIMIT - (1 << 44 - bits)
    parts = room // 3
    plane = tuple(generator.randint(-parts, parts) // number
                  for number in (1, 1, grid.columns, grid.columns, grid.rows, grid.rows))
    wild = dataclasses.replace(grid, plane=plane, fraction_bits=bits)
    unit = 1 << 29 - bits
    points = tuple(tuple(value + unit * generator.choice((-32768, 32767,
                                                          generator.randint(-32768, 32767)))
                         for value in base) for base in reference.plane_points(wild, plane))
    return dataclasses.replace(blob, grid=dataclasses.replace(wild, control_points=points))


def make_blobs():
    lens, wide = make_golden.make_lens(), make_golden.make_wide()
    narrow = make_golden.make_narrow(lens)
    seen = make_golden.make_seen_lines(narrow)
    bent = make_golden.make_bent(wide)
    coarse = dataclasses.replace(wide.inverse, grid=with_bits(wide.inverse.grid, 14))
    blobs = {"example": make_golden.make_example(), "lens": lens, "wide": wide, "narrow": narrow,
             "bent": bent, "lines": make_golden.make_lines(make_golden.make_example()),
             "seen lines": seen, "tele": make_tele(),
             "wide, 16 bits": dataclasses.replace(wide, grid=bent.grid),
             "wide, coarse": dataclasses.replace(wide, inverse=coarse),
             "wide, noisy": dataclasses.replace(wide, inverse=with_noise(wide.inverse, 8, 3)),
             "lines, 32 bits": dataclasses.replace(seen, grid=lens.grid)}
    for bits in (14, 21, 28):
        blobs[f"wild, {bits} bits"] = with_wild_residuals(seen, bits, bits)
    blobs["wild"] = with_wild_points(narrow, 5)
    limit = reference.LINE_POINT_LIMIT  # so far away that distances wrap
    far = tuple((limit - abs(x), y - limit // 2, abs(z) - limit) for x, y, z in seen.line_points)
    blobs["wild, far"] = dataclasses.replace(seen, line_points=far)
    stack = make_golden.make_stack(wide)
    for name, blob, values in (("stack", stack, make_golden.STACK_CONDITIONS),
                               ("stack, 32 bits", with_wide_knots(stack), (0, 3 << 16))):
        for value in values:
            there = reference.at_condition(blob, value)
            CONDITIONS[id(there)] = blob, value
            blobs[f"{name} at {value}"] = there
    return blobs


def with_wide_knots(stack):
    """With control points of 32 bits, of which the upper knots' differ as much as they may."""
    def widened(grid, sign):
        points = tuple(tuple(max(-reference.CONTROL_POINT_LIMIT, min(
            value + sign * index * 99999999, reference.CONTROL_POINT_LIMIT)) for value in point)
            for index, point in enumerate(grid.control_points))
        return dataclasses.replace(grid, control_points=points, fraction_bits=29, plane=())
    knots = tuple(dataclasses.replace(knot, grid=widened(knot.grid, k - 1))
                  for k, knot in enumerate(stack.stack.knots))
    return dataclasses.replace(stack, grid=widened(stack.grid, 0),
                               stack=dataclasses.replace(stack.stack, knots=knots))


def pixels_of(grid, count, generator):
    """Inside the area, at its edges and corners, and around it."""
    xs, ys = ([low - 1, low, low + 1, high - 1, high, high + 1, (low + high) // 2]
              for low, high in ((grid.x0, grid.x1), (grid.y0, grid.y1)))
    yield from itertools.product(xs, ys)
    yield from itertools.product((NONE, -1, 0, LARGEST), repeat=2)
    for _ in range(count - len(xs) * len(ys) - 16):
        yield (generator.choice((generator.choice(xs), generator.randint(xs[0], xs[5]))),
               generator.choice((generator.choice(ys), generator.randint(ys[0], ys[5]))))


def directions_of(blob, count, generator):
    """Directions of all lengths and ways, and more of those that the area sees."""
    yield from itertools.product((NONE, -1, 0, 1, LARGEST), repeat=3)
    for k in range(count - 125):
        if k % 4 == 0:
            yield tuple(generator.randint(NONE, LARGEST) >> generator.randrange(31)
                        for _ in range(3))
        elif k % 4 == 1:
            yield from_beyond_the_edge(blob, generator)
        else:
            ray = reference.unproject_q16(blob, generator.randint(blob.grid.x0, blob.grid.x1),
                                          generator.randint(blob.grid.y0, blob.grid.y1))
            shift = generator.randrange(16)
            yield tuple((value >> shift) + generator.randint(-9, 9) for value in ray)


def from_beyond_the_edge(blob, generator):
    """A direction from about as far outside the area as a projection may end."""
    y = generator.randint(blob.grid.y0, blob.grid.y1)
    edge = reference.unproject_q16(blob, blob.grid.x1, y)
    inside = reference.unproject_q16(blob, blob.grid.x1 - (1 << 16), y)
    part = (reference.AREA_TOLERANCE + generator.randint(-2, 2)) / 2**16
    return tuple(round(there + part * (there - here)) for there, here in zip(edge, inside))


def points_of(blob, count, generator):
    """With their fraction bits: of all sizes, and more of those on lines of the area's pixels and
    around its edge."""
    limit = 2**30 - 1
    for point in itertools.product((-limit, -1, 0, 1, limit), repeat=3):
        yield point, generator.randrange(28)
    grid = blob.grid
    for k in range(count - 125):
        bits = generator.randrange(28)
        if k % 4 == 0:
            yield tuple(generator.randint(-limit, limit) >> generator.randrange(29)
                        for _ in range(3)), bits
            continue
        x, y = generator.randint(grid.x0, grid.x1), generator.randint(grid.y0, grid.y1)
        if k % 4 == 1:
            x = generator.choice((grid.x0, grid.x1))
        origin, ray = reference.unproject_line_q16(blob, x, y)
        metres = min(0.05 * 2**generator.uniform(0, 12), 2**(29 - bits))
        point = [int((o / 2**28 + metres * e / 2**30 * generator.uniform(0.99, 1.01)) * 2**bits)
                 for o, e in zip(origin, ray)]
        yield tuple(max(-limit, min(limit, value)) for value in point), bits


class ReferenceBits(unittest.TestCase):
    """Each test takes COUNT pixels or points, shared among the blobs."""

    @classmethod
    def setUpClass(cls):
        cls.blobs = make_blobs()

    def compare(self, blobs, make_inputs, runtime, its_reference):
        """Returns which part of the inputs has a result."""
        number = found = 0
        for name, blob in blobs.items():
            camera = Camera(blob)
            with self.subTest(name):
                for given in make_inputs(blob, COUNT // len(blobs), random.Random(name)):
                    result = runtime(camera, given)
                    self.assertEqual(its_reference(blob, given), result, given)
                    number += 1
                    found += result is not None
        self.assertGreaterEqual(number, COUNT - len(blobs))
        return found / number

    @staticmethod
    def pixels(blob, count, generator):
        return pixels_of(blob.grid, count, generator)

    def test_lines(self):
        found = self.compare(self.blobs, self.pixels, lambda camera, pixel: camera.line(pixel),
                             lambda blob, pixel: reference.unproject_line_q16(blob, *pixel))
        self.assertGreater(found, 0.6)

    def test_directions(self):
        blobs = {name: blob for name, blob in self.blobs.items() if blob.line_points is None}
        found = self.compare(blobs, self.pixels, lambda camera, pixel: camera.ray(pixel),
                             lambda blob, pixel: reference.unproject_q16(blob, *pixel))
        self.assertGreater(found, 0.6)

    def test_projections(self):
        blobs = {name: blob for name, blob in self.blobs.items()
                 if blob.inverse and blob.line_points is None}
        found = self.compare(blobs, directions_of,
                             lambda camera, direction: camera.pixel_of(direction),
                             reference.project_q16)
        self.assertGreater(found, 0.4)

    def test_points_of_lines(self):
        blobs = {name: blob for name, blob in self.blobs.items()
                 if blob.inverse and blob.line_points}
        for is_wild, least in ((False, 0.3), (True, 0)):
            group = {name: blob for name, blob in blobs.items() if ("wild" in name) == is_wild}
            found = self.compare(group, points_of,
                                 lambda camera, point: camera.pixel_of_point(*point),
                                 lambda blob, point: reference.project_point_q16(blob, *point))
            self.assertGreaterEqual(found, least)

    def test_trust(self):
        wide = self.blobs["wide"]
        edge = dataclasses.replace(wide.grid, x1=(320 << 16) - (1 << 15),
                                   y1=(240 << 16) - (1 << 15))
        blobs = {"wide": wide, "to the edge": dataclasses.replace(wide, grid=edge),
                 "lens": self.blobs["lens"]}
        found = self.compare(blobs, self.pixels, lambda camera, pixel: (
            camera.is_valid(pixel), camera.uncertainty(pixel)), lambda blob, pixel: (
                reference.is_valid_q16(blob, *pixel), reference.uncertainty_q12(blob, *pixel)))
        self.assertEqual(found, 1)


if __name__ == "__main__":
    unittest.main(verbosity=2)
