#!/usr/bin/env python3
"""Meshes of dewarping units: each unit's interpolator, written from its documents, goes where the
view does, with the error that the export tells."""
import json
import math
import operator
import struct
import zipfile

from command_test import CommandTest, main, read, run, write

SIZE = (320, 240)
ALIGNED, RAGGED = SIZE, (328, 248)
WITHOUT_BORDER, WITH_BORDER = ("--hfov", 70), ("--hfov", 100)


def cells(place, step, end=None):
    """The vertex before a pixel, the next one, and the part of the way, of axes with a step."""
    k = place // step
    width = step if end is None else min(step, end - k * step)
    return k, k + 1, (place - k * step) / width


def between(vertex, x, y):
    """Bilinear between four corners."""
    (i0, i1, s), (j0, j1, t) = x, y
    weights = (1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t
    corners = vertex(i0, j0), vertex(i1, j0), vertex(i0, j1), vertex(i1, j1)
    return [sum(map(operator.mul, weights, numbers)) for numbers in zip(*corners)]


def parabola(place, step, middle):
    """The vertex before a middle one, and the weights of three of them."""
    t = place / step - middle
    return middle - 1, (t * (t - 1) / 2, 1 - t * t, t * (t + 1) / 2)


class Unit:
    """Places that a file says; `moved` is a mistake in source pixels, along x. Of several ways between
    vertices, `span` is its own."""
    ending, more, size, span = ".bin", (), RAGGED, None

    def __init__(self, path, moved=0):
        self.path, self.moved = path, moved
        self.load()

    def bytes(self, suffix=""):
        return read(self.path.replace(self.ending, suffix + self.ending))


class Dw100(Unit):
    """u32: y in the upper half, x in the lower, UQ12.4, at every 16th pixel and the view's end."""
    name = "dw100"

    def load(self):
        width, height = self.size
        self.columns = -(-width // 16) + 1
        rows = -(-height // 16) + 1
        self.words = struct.unpack(f"<{self.columns * rows}I", self.bytes())

    def vertex(self, i, j):
        word = self.words[j * self.columns + i]
        return ((word & 0xffff) / 16 + self.moved, (word >> 16) / 16)

    def place(self, x, y):
        return between(self.vertex, cells(x, 16, self.size[0]), cells(y, 16, self.size[1]))


class TiLdc(Unit):
    """Offsets from the output's pixel, S16Q3, y before x, in lines of multiples of 16 vertices."""
    name, step = "ti-ldc", 8
    more = ("--stride", step)

    def load(self):
        line = -(-self.size[0] // self.step) + 1
        self.line = -(-line // 16) * 16
        contents = self.bytes()
        assert len(contents) % (4 * self.line) == 0
        self.offsets = struct.unpack(f"<{len(contents) // 2}h", contents)

    def vertex(self, i, j):
        k = 2 * (j * self.line + i)
        return (self.offsets[k + 1] + 8 * self.moved, self.offsets[k])

    def place(self, x, y):
        dx, dy = between(self.vertex, cells(x, self.step), cells(y, self.step))
        return x + dx / 8, y + dy / 8


class Fec(Unit):
    """Whole and fractional parts apart; bands of 128 rows, in which columns run first."""
    name, step_x, step_y = "rockchip-fec", 16, 8

    def load(self):
        xi, yi = (self.bytes(f"_mesh{axis}i") for axis in "xy")
        xf, yf = (self.bytes(f"_mesh{axis}f") for axis in "xy")
        count = len(xf)
        self.x = [a + b / 256 for a, b in zip(struct.unpack(f"<{count}H", xi), xf)]
        self.y = [a + b / 256 for a, b in zip(struct.unpack(f"<{count}H", yi), yf)]
        columns = -(-self.size[0] // 32) * 32 // self.step_x + 1
        rows = -(-self.size[1] // 32) * 32
        self.heights = [min(128, rows - first) // self.step_y + 1 for first in range(0, rows, 128)]
        assert count == columns * sum(self.heights)
        self.columns = columns

    def place(self, x, y):
        band = y // 128
        first, height = self.columns * sum(self.heights[:band]), self.heights[band]
        def vertex(i, j):
            k = first + i * height + j
            return self.x[k] + self.moved, self.y[k]
        return between(vertex, cells(x, self.step_x), cells(y % 128, self.step_y))


class Ldch(Unit):
    """x alone, with 4 bits of fraction, behind a head of six numbers, in lines of even length."""
    name, size = "rockchip-ldch", ALIGNED

    def load(self):
        head = struct.unpack_from("<6H", self.bytes())
        width, height, self.line, rows, step_x, step_y = head
        assert (width, height, step_x, step_y) == (*self.size, 16, 8) and self.line % 2 == 0
        self.x = struct.unpack_from(f"<{self.line * rows}H", self.bytes(), 12)

    def place(self, x, y):
        vertex = lambda i, j: (self.x[j * self.line + i] / 16 + self.moved,)
        return between(vertex, cells(x, 16), cells(y, 8))[0], y


class Hailo(Unit):
    """Q15.16, x before y, at every 64th pixel."""
    name = "hailo"

    def load(self):
        self.columns, rows = (-(-length // 64) + 1 for length in self.size)
        self.numbers = struct.unpack(f"<{2 * self.columns * rows}i", self.bytes())

    def vertex(self, i, j):
        k = 2 * (j * self.columns + i)
        return self.numbers[k] / 65536 + self.moved, self.numbers[k + 1] / 65536

    def place(self, x, y):
        return between(self.vertex, cells(x, 64), cells(y, 64))


class DepthAi(Unit):
    """Floats, y before x, at every 16th pixel."""
    name, size = "depthai-mesh", ALIGNED

    def load(self):
        self.columns, rows = (length // 16 + 1 for length in self.size)
        self.numbers = struct.unpack(f"<{2 * self.columns * rows}f", self.bytes())

    def vertex(self, i, j):
        k = 2 * (j * self.columns + i)
        return self.numbers[k + 1] + self.moved, self.numbers[k]

    def place(self, x, y):
        return between(self.vertex, cells(x, 16), cells(y, 16))


class Vpi(Unit):
    """A point for each pixel."""
    name, ending = "vpi", ".npz"

    def load(self):
        with zipfile.ZipFile(self.path) as archive:
            contents = archive.read("keypoints.npy")
        head = contents.index(b"\n") + 1
        assert str((self.size[1], self.size[0], 2)).encode() in contents[:head]
        self.numbers = memoryview(contents[head:]).cast("f")

    def place(self, x, y):
        k = 2 * (y * self.size[0] + x)
        return self.numbers[k] + self.moved, self.numbers[k + 1]


class SparseVpi(Vpi):
    """A point for each 16th pixel, an odd number of them, and parabolas through nine points."""
    step, more, span = 16, ("--stride", 16), "patches"

    def load(self):
        ends = (-(-length // tile) * tile for length, tile in zip(self.size, (64, 16)))
        self.columns, rows = ((end // self.step + 1) // 2 * 2 + 1 for end in ends)
        with zipfile.ZipFile(self.path) as archive:
            contents = archive.read("keypoints.npy")
        head = contents.index(b"\n") + 1
        assert str((rows, self.columns, 2)).encode() in contents[:head]
        self.numbers = memoryview(contents[head:]).cast("f")

    def middle(self, place):
        return place // (2 * self.step) * 2 + 1

    def place(self, x, y):
        (i, weights), (j, heights) = (parabola(at, self.step, self.middle(at)) for at in (x, y))
        total = [self.moved, 0]
        for n, height in enumerate(heights):
            for m, weight in enumerate(weights):
                k = 2 * ((j + n) * self.columns + i + m)
                total[0] += height * weight * self.numbers[k]
                total[1] += height * weight * self.numbers[k + 1]
        return total


class NearestVpi(SparseVpi):
    """The same points, and the parabola around the nearest one."""
    span = "nearest"

    def middle(self, place):
        return max(1, (place + self.step // 2 - 1) // self.step)


UNITS = (Dw100, TiLdc, Fec, Hailo, DepthAi, Vpi, SparseVpi, NearestVpi)


LENS = """raygrid_camera: 1
model: opencv
image_size: [320, 240]
area: [0, 0, 319, 239]
parameters: {fx: 166.5, fy: 167, cx: 160.3, cy: 118.2, k1: -0.09, k2: 0.01, k3: 0, k4: 0.1, k5: 0,
  k6: 0, p1: 1e-3, p2: -2e-3}
"""


class Meshes(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.camera = write(cls.path("lens.yaml"), LENS)

    def export(self, unit, *more, camera=None, out=None, size=None):
        out = out or self.path(unit.__name__ + unit.ending)
        width, height = size or unit.size
        result = self.succeed("export", camera or self.camera, "--to", unit.name, "--size",
                              f"{width}x{height}", *unit.more, *more, "--json", "-o", out)
        return json.loads(result.stdout), out

    def sources(self, view, pixels, camera=None):
        """Where `project` sees pixels of a pinhole view; None where it does not."""
        (fx, _, cx), (_, fy, cy), _ = view["K"]
        points = write(self.path("p.csv"), "x,y,z\n" + "".join(
            f"{(x - cx) / fx!r},{(y - cy) / fy!r},1\n" for x, y in pixels))
        result = self.succeed("project", camera or self.camera, "--points", points)
        rows = [line.split(",") for line in result.stdout.split()[1:]]
        return [(float(u), float(v)) if valid == "1" else None for *_, u, v, valid in rows]

    def errors(self, unit, pixels, sources, least=1):
        """The largest and the RMS error of a unit at pixels that have a source: so many of all."""
        off = [math.dist(unit.place(*pixel), source) for pixel, source in zip(pixels, sources)
               if source]
        self.assertGreater(len(off), least * (len(pixels) - 1))
        return max(off), math.sqrt(sum(error ** 2 for error in off) / len(off))

    def check(self, told, largest, rms):
        """The stated error is that of all pixels, the largest of them among those measured."""
        rounding = 1e-5
        self.assertLess(abs(told["max_px"] - largest), 0.05 * largest + rounding)
        self.assertLess(abs(told["rms_px"] - rms), 0.05 * rms + rounding)

    def test_units_go_where_the_view_does(self):
        """At more than 10,000 pixels, with the error told; half a pixel is found."""
        for size in (ALIGNED, RAGGED):
            self.check_units([unit for unit in UNITS if unit.size == size], *WITHOUT_BORDER)

    def check_units(self, units, *more, camera=None):
        """Units that take a view of one size."""
        made = [self.export(unit, *more, camera=camera) for unit in units]
        view = made[0][0]["view"]
        width, height = view["size"]
        self.assertEqual((width, height), units[0].size)
        pixels = [(x, y) for y in range(0, height, 2) for x in range(0, width, 3)]
        self.assertGreater(len(pixels), 10000)
        errors = [told["mesh"]["by_interpolation"][unit.span] if unit.span else told["mesh"]
                  for unit, (told, _) in zip(units, made)]
        worst = [tuple(error["max_error_position_px"]) for error in errors]
        sources = self.sources(view, pixels + worst, camera)
        for k, (unit, error, (told, path)) in enumerate(zip(units, errors, made)):
            with self.subTest(unit.name):
                own = pixels + [worst[k]], sources[:len(pixels)] + [sources[len(pixels) + k]]
                self.check(error, *self.errors(unit(path), *own, 0.99))
                self.assertGreaterEqual(told["mesh"]["max_px"], error["max_px"])
                tenth = [some[::-9] for some in own]
                with self.assertRaises(AssertionError):
                    self.check(error, *self.errors(unit(path, moved=0.5), *tenth, 0.99))

    def test_what_moves_pixels_along_rows_alone(self):
        """LDCH makes a picture of another width; of the lens's distortion it leaves the rows."""
        camera = self.path("flat.yaml")
        self.succeed("export", self.camera, "--rectified", "--focal", 150, "--to", "opencv",
                     "-o", camera)
        height_deg = 2 * math.degrees(math.atan(SIZE[1] / 2 / 150))
        self.check_units([Ldch], "--hfov", 75, "--vfov", height_deg, camera=camera)
        told, path = self.export(Ldch, *WITHOUT_BORDER, "--max-fit-error-px", 100)
        self.assertGreater(told["mesh"]["max_px"], 2)
        pixels = [(x, y) for y in range(0, 240, 11) for x in range(0, 320, 11)]
        unit = Ldch(path)
        off = [abs(unit.place(*pixel)[0] - source[0]) for pixel, source in
               zip(pixels, self.sources(told["view"], pixels)) if source]
        self.assertLess(max(off), 0.2)

    def test_an_identity_is_the_pixels_themselves(self):
        """Of a pinhole: 0, 16, 32 and so on, and the last one behind the view."""
        camera = self.path("plain.yaml")
        self.succeed("export", self.camera, "--rectified", "--focal", 150, "--to", "opencv",
                     "-o", camera)
        told, path = self.export(Dw100, "--focal", 150, camera=camera, out=self.path("i.bin"),
                                 size=SIZE)
        words = struct.unpack("<336I", read(path))
        self.assertEqual(words, tuple(y * 16 << 16 | x * 16 for y in range(0, 241, 16)
                                      for x in range(0, 321, 16)))
        self.assertLess(told["mesh"]["max_px"], 1e-6)
        _, path = self.export(TiLdc, "--focal", 150, camera=camera, out=self.path("i.bin"), size=SIZE)
        self.assertEqual(set(read(path)), {0})

    def test_views_with_a_border(self):
        """The error is that of pixels with a source; a unit without negative numbers says so."""
        grid = self.simulated_camera("wide", f"{SIZE[0]}x{SIZE[1]}")
        for unit, camera, moves in ((Dw100, self.camera, True), (Hailo, grid, False)):
            told, path = self.export(unit, *WITH_BORDER, camera=camera)
            mesh = told["mesh"]
            self.assertEqual(mesh["num_clamped_vertices"] > 0, moves)
            width, height = unit.size
            pixels = [(x, y) for y in range(0, height, 3) for x in range(0, width, 5)]
            pixels.append(tuple(mesh["max_error_position_px"]))
            sources = self.sources(told["view"], pixels, camera)
            self.assertAlmostEqual(sum(source is not None for source in sources) / len(pixels),
                                   mesh["pixels"] / (width * height), 2)
            own = unit(path)
            largest, rms = self.errors(own, pixels, sources, 0.5)
            self.assertLess(abs(mesh["max_px"] - largest), 0.05 * largest)
            self.assertLess(abs(mesh["rms_px"] - rms), 0.1 * rms)
            inside = 0
            for pixel, source in zip(pixels, sources):
                x, y = own.place(*pixel) if source is None else (-1, -1)
                inside += 0 <= x <= SIZE[0] - 1 and 0 <= y <= SIZE[1] - 1
            self.assertLess(abs(mesh["num_filled_pixels"] / (width * height) - inside / len(pixels)),
                            0.01)

    def test_same_bytes_with_any_number_of_threads(self):
        files = [self.export(TiLdc, "--threads", threads, out=self.path(f"t{threads}.bin"))[1]
                 for threads in (1, 2)]
        self.assertTrue(read(files[0]) == read(files[1]))

    def test_what_a_unit_cannot_do(self):
        for name, code, more, words in (
                ("dw100", 1, ("--size", "644x480"), ("multiples of 8", "width of 644")),
                ("dw100", 1, ("--stride", "8"), ("--stride", "not supported by")),
                ("dw100", 6, (*WITHOUT_BORDER, "--max-fit-error-px", "0.01"), ("0.01 px", "max", "RMS")),
                ("ti-ldc", 1, ("--stride", "12"), ("--stride 12", "power of 2")),
                ("rockchip-ldch", 6, WITHOUT_BORDER, ("rows only", "rockchip-fec", "--max-fit-error-px")),
                ("rockchip-ldch", 1, ("--size", "160x120"), ("320 x 240", "--size")),
                ("hailo", 1, ("--size", "4096x480"), ("64 to 4095",)),
                ("depthai-mesh", 1, ("--stride", "7"), ("--stride 7", "divide")),
                ("vpi", 1, ("--size", "32x16"), ("64 to",)),
                ("vpi", 1, ("--stride", "12"), ("--stride 12", "power of 2")),
                ("opencv", 1, ("--stride", "7"), ("--stride", "opencv"))):
            with self.subTest((name, more)):
                ending = ".npz" if name == "vpi" else ".bin"
                self.assert_refused(run("export", self.camera, "--to", name, *more, "-o",
                                        self.path("never/m" + ending)), code, *words)
        self.assert_refused(run("export", self.camera, "--to", "dw100", "-o",
                                self.path("never/m.txt")), 1, ".bin")
        self.assert_nothing_in(self.path("never"))

    def test_offsets_that_are_too_large(self):
        self.assert_refused(run("export", self.camera, "--to", "ti-ldc", "--size", "8192x16",
                                "--hfov", 120, "-o", self.path("never/m.bin")), 6, "4095 px")


if __name__ == "__main__":
    main(__name__)
