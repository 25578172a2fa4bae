#!/usr/bin/env python3
"""The Python module against the reference reader; with numpy where that is there."""
import ctypes
import dataclasses
import os
import subprocess
import unittest
import zlib

import blob_reference as reference
import make_golden
import raygrid

try:
    import numpy
except ImportError:
    numpy = None

LENS, WIDE = make_golden.make_lens(), make_golden.make_wide()
LINES = make_golden.make_lines(make_golden.make_example())
PIXELS = [(20.5, 14.25), (80, 60), (131.125, 99.75)]


def open_blob(blob):
    return raygrid.Camera(reference.serialize(blob))


class LayoutTest(unittest.TestCase):
    """What the module repeats of raygrid.h is as the compiler has it: RAYGRID_LAYOUTS names the
    program that prints that."""

    @classmethod
    def setUpClass(cls):
        # A program with sanitizers has their runtime in itself.
        environment = {key: value for key, value in os.environ.items() if key != "LD_PRELOAD"}
        lines = subprocess.run([os.environ["RAYGRID_LAYOUTS"]], env=environment,
                               capture_output=True, text=True,
                               check=True).stdout.splitlines()
        cls.sizes, cls.fields, cls.constants = {}, {}, {}
        for kind, name, *values in map(str.split, lines):
            if kind == "struct":
                cls.sizes[name] = int(values[0])
            elif kind == "field":
                place = tuple(map(int, values[1:]))
                fields = cls.fields.setdefault(name, {})
                assert fields.setdefault(values[0], place) == place, (name, values)
            else:
                cls.constants[name] = int(values[0])

    def test_structures(self):
        mirrors = [kind for kind in vars(raygrid).values()
                   if isinstance(kind, type) and issubclass(kind, ctypes.Structure)]
        self.assertGreater(len(mirrors), 5)
        for mirror in mirrors:
            name = "rg" + mirror.__name__.lower()
            with self.subTest(name):
                places = {field: getattr(mirror, field) for field, *_ in mirror._fields_}
                self.assertEqual({field: (place.offset, place.size)
                                  for field, place in places.items()}, self.fields[name])
                self.assertEqual(ctypes.sizeof(mirror), self.sizes[name])

    def test_camera_has_room(self):
        self.assertGreaterEqual(ctypes.sizeof(raygrid._Camera), self.sizes["rg_camera"])

    def test_constants(self):
        groups = {"FORMAT": {name: values[0] for name, values in raygrid.FORMATS.items()},
                  "PROJECTION": {name: k for k, name in enumerate(raygrid.PROJECTIONS)},
                  "BORDER": raygrid.BORDERS, "SAMPLING": raygrid.SAMPLINGS}
        for group, values in groups.items():
            prefix = f"RG_{group}_"
            self.assertEqual({prefix + name.upper(): number for name, number in values.items()},
                             {name: number for name, number in self.constants.items()
                              if name.startswith(prefix)})
        self.assertEqual(len(raygrid.FORMATS), self.constants["RG_NUM_FORMATS"])
        for name in ("OK", "EXTRAPOLATED", "NO_PIXEL", "POINT_MAX_BITS", *(
                "ERR_" + name for name in ("OUTSIDE_AREA", "NO_REMAP", "NOT_SEEN", "NONCENTRAL",
                                           "UNKNOWN", "NO_INVERSE"))):
            self.assertEqual(getattr(raygrid, name.removeprefix("ERR_")),
                             self.constants["RG_" + name], name)


class ModuleTest(unittest.TestCase):
    def assert_close(self, values, expected, delta):
        self.assertEqual(len(values), len(expected))
        for value, other in zip(values, expected):
            self.assertAlmostEqual(value, other, delta=delta)

    def test_blob_tells_its_size(self):
        camera = open_blob(LENS)
        self.assertEqual((camera.width, camera.height), (160, 120))
        self.assertEqual(camera.remap_size(), (LENS.remap.width, LENS.remap.height))

    def test_directions_are_the_references(self):
        for direction, pixel in zip(open_blob(LENS).unproject(PIXELS), PIXELS):
            self.assert_close(direction, reference.unproject(LENS, *pixel), 1e-7)

    def test_pixels_outside_have_no_direction(self):
        camera = open_blob(LENS)
        self.assertEqual(camera.unproject([(-1, 0), (1e9, -1e9)]), [None, None])
        self.assertEqual(camera.is_valid([(-1, 0), PIXELS[0]]), [False, True])

    def test_condition_moves_the_camera(self):
        stack = make_golden.make_stack(WIDE)
        camera = open_blob(stack)
        frame = make_golden.make_frame(320, 240)
        for value, is_inside in ((-0.75, False), (1.0, True), (5.5, True), (float("inf"), False)):
            self.assertEqual(camera.set_condition(value), is_inside)
            there = reference.at_condition(stack, round(min(value, 99) * 65536))
            expected = reference.unproject_q16(there, 80 << 16, 60 << 16)
            self.assert_close(camera.unproject([(80, 60)])[0], [v / 2**30 for v in expected], 1e-9)
            self.assertEqual(camera.undistort(frame, border_values=(make_golden.BORDER,) * 4),
                             reference.remap_grey(there, frame, make_golden.BORDER))
        with self.assertRaises(raygrid.Error):
            open_blob(LENS).set_condition(1)

    def test_projection_inverts_at_any_length(self):
        camera = open_blob(WIDE)
        rays = [tuple(1e6 * v for v in ray) for ray in camera.unproject(PIXELS)]
        for found, pixel in zip(camera.project(rays), PIXELS):
            self.assert_close(found, pixel, 0.002)
        self.assertEqual(camera.project([(0, 0, -1), (0, 0, 0)]), [None, None])

    def test_what_is_no_number_lies_outside(self):
        camera = open_blob(WIDE)
        infinite, nan = float("inf"), float("nan")
        odd = [(infinite, 60), (80, -infinite), (nan, 60), (80, nan), (1e308, 60)]
        self.assertEqual(camera.unproject(odd), [None] * len(odd))
        self.assertEqual(camera.undistort_points(odd), [None] * len(odd))
        self.assertEqual(camera.is_valid(odd), [False] * len(odd))
        self.assertEqual(camera.project([(0, 0, infinite), (nan, 0, 1)]), [None, None])

    def test_lines_are_the_references(self):
        camera = open_blob(LINES)
        self.assertEqual([camera.is_central, open_blob(LENS).is_central], [False, True])
        points = [(10, 10), (30.5, 20)]
        for line, pixel in zip(camera.unproject_lines(points), points):
            self.assert_close(line[0], reference.line_point(LINES, *pixel), 5e-8)
            self.assert_close(line[1], reference.unproject(LINES, *pixel), 1e-7)
        with self.assertRaises(raygrid.Error) as context:
            camera.project([(0, 0, 1)])
        self.assertEqual(context.exception.status, raygrid.NO_INVERSE)

    def test_lines_see_the_points_on_them(self):
        camera = open_blob(make_golden.make_seen_lines(make_golden.make_narrow(LENS)))
        for metres in (0.3, 7, 1e5):
            points = [[o + metres * d for o, d in zip(*line)]
                      for line in camera.unproject_lines(PIXELS)]
            for found, pixel in zip(camera.project(points), PIXELS):
                self.assert_close(found, pixel, 0.002)
        nan = float("nan")
        self.assertEqual(camera.project([(0, 0, -1), (0, 0, 0), (nan, 0, 1)]), [None] * 3)

    def test_undistorted_points_are_the_references(self):
        self.check_undistorted_points(LENS, PIXELS)

    def test_undistorted_points_of_lines_are_those_of_far_scenes(self):
        table = make_golden.make_example().remap
        self.check_undistorted_points(dataclasses.replace(LINES, remap=table),
                                      [(10, 10), (30.5, 20)])

    def test_frames_of_modes_are_told_and_taken(self):
        modes = make_golden.make_modes(WIDE)
        camera = open_blob(modes)
        tables = (modes.remap, *modes.more_remaps)
        for index, (table, made) in enumerate(zip(tables, make_golden.MODE_VIEWS)):
            camera.select_remap(index)
            self.assertEqual((camera.width, camera.height), (320, 240))
            self.assertEqual(camera.frame_size(), table.view.source)
            self.assertEqual(camera.view().distorts, made.distorts)
            mode = camera.mode()
            if made.mode:
                stored = modes.modes[made.mode - 1]
                self.assertEqual((mode.width, mode.height), (stored.width, stored.height))
                self.assertEqual(mode.offset, tuple(value / 65536 for value in stored.offset))
                self.assertEqual(mode.scale, tuple(value / 65536 for value in stored.scale))
                self.assertEqual(mode.flips, tuple(map(bool, stored.flips)))
            else:
                self.assertEqual(mode, (320, 240, (0, 0), (1, 1), (False, False)))
            frame = make_golden.make_frame(*table.view.source)
            one = dataclasses.replace(modes, remap=table, more_remaps=())
            self.assertEqual(camera.undistort(frame, border_values=(make_golden.BORDER,) * 4),
                             bytes(reference.remap_grey(one, frame, make_golden.BORDER)))

    def test_views_are_told(self):
        camera = open_blob(LENS)
        remap, view = LENS.remap, camera.view()
        self.assertEqual((view.projection, view.width, view.height), ("pinhole", 120, 90))
        self.assertEqual(view.K, ((remap.fx / 65536, 0, remap.cx / 65536),
                                  (0, remap.fy / 65536, remap.cy / 65536), (0, 0, 1)))
        self.assertEqual(view.rotation, ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
        camera = open_blob(make_golden.make_views(WIDE))
        for index, made in enumerate(make_golden.VIEWS):
            camera.select_remap(index)
            view = camera.view()
            self.assertEqual((view.projection, view.fx), (made.projection, made.focal))
            for told, row in zip(view.rotation, make_golden.rotation_of(*made.angles)):
                self.assert_close(told, row, 1e-9)
        with self.assertRaises(raygrid.Error) as context:
            open_blob(LINES).view()
        self.assertEqual(context.exception.status, raygrid.NO_REMAP)

    def check_undistorted_points(self, blob, pixels):
        for found, pixel in zip(open_blob(blob).undistort_points(pixels), pixels):
            x, y, z = reference.unproject(blob, *pixel)
            remap = blob.remap
            self.assert_close(found, ((remap.fx * x / z + remap.cx) / 65536,
                                      (remap.fy * y / z + remap.cy) / 65536), 0.001)

    def test_frame_is_the_references(self):
        frame = make_golden.make_frame(160, 120)
        output = open_blob(LENS).undistort(frame, border_values=(make_golden.BORDER,))
        self.assertEqual(zlib.crc32(output), make_golden.remap_crc(LENS))

    def test_every_table_can_be_used(self):
        table = LENS.remap
        shifted = dataclasses.replace(table, origin=(table.origin[0] + 8192, table.origin[1]))
        both = dataclasses.replace(LENS, more_remaps=(shifted,))
        alone = dataclasses.replace(LENS, remap=shifted)
        frame, border = make_golden.make_frame(160, 120), (make_golden.BORDER,)
        camera = open_blob(both)
        self.assertEqual(camera.num_remaps, 2)
        for index, blob in ((0, LENS), (1, alone), (0, LENS)):
            camera.select_remap(index)
            self.assertEqual(zlib.crc32(camera.undistort(frame, border_values=border)),
                             make_golden.remap_crc(blob))
        for index in (2, -1, 2**32):
            with self.assertRaises(raygrid.Error) as context:
                camera.select_remap(index)
            self.assertEqual(context.exception.status, raygrid.NO_REMAP)
        none = open_blob(dataclasses.replace(LENS, remap=None))
        self.assertEqual(none.num_remaps, 0)
        with self.assertRaises(raygrid.Error):
            none.remap_size()

    def test_names_that_are_none_are_told(self):
        camera, frame = open_blob(LENS), bytes(160 * 120)
        for names in ({"pixel_format": "GREY9"}, {"border": "none"}, {"sampling": "cubic"}):
            with self.assertRaisesRegex(ValueError, "expected one of"):
                camera.undistort(frame, **names)

    def test_border_values_fit_their_samples(self):
        camera, frame = open_blob(LENS), bytes(160 * 120)
        for values in ((-1,), (256,), (1, 2, 3, 4, 5)):
            with self.assertRaises(ValueError):
                camera.undistort(frame, border_values=values)
        with self.assertRaises(TypeError):
            camera.undistort(frame, border_values=(1.5,))
        camera.undistort(frame * 2, "GREY16", border_values=(65535, 0, 0, 0))

    def test_every_format_has_the_size_the_library_wants(self):
        camera = open_blob(WIDE)
        for name, (_, _, planes) in raygrid.FORMATS.items():
            size = sum(int(WIDE.camera.width * across) * int(WIDE.camera.height * down)
                       for across, down in planes)
            camera.undistort(bytes(size), name, sampling="nearest")
            with self.assertRaises(ValueError):
                camera.undistort(bytes(size - 1), name)

    def test_memory_of_any_kind_is_read_and_filled(self):
        camera, frame = open_blob(LENS), make_golden.make_frame(160, 120)
        expected = camera.undistort(frame)
        wide = memoryview(bytearray(2 * len(frame)))
        wide[::2] = frame
        for kind in (bytes, bytearray, memoryview, list):
            self.assertEqual(camera.undistort(kind(frame)), expected)
        self.assertEqual(camera.undistort(memoryview(bytearray(frame))), expected)
        self.assertEqual(camera.undistort(wide[::2]), expected)
        self.assertEqual(frame, make_golden.make_frame(160, 120))
        out = bytearray(len(expected))
        self.assertIs(camera.undistort(frame, out=out), out)
        self.assertEqual(out, expected)

    def test_memory_that_cannot_be_filled_is_refused(self):
        camera, frame = open_blob(LENS), bytes(160 * 120)
        size = len(camera.undistort(frame))
        for out in (bytes(size), bytearray(size - 1), bytearray(size + 1), bytearray(),
                    memoryview(bytearray(2 * size))[::2]):
            with self.assertRaisesRegex(ValueError, "out must be"):
                camera.undistort(frame, out=out)

    def test_damaged_blob_is_refused(self):
        data = bytearray(reference.serialize(LENS))
        data[-1] ^= 1
        with self.assertRaises(raygrid.Error) as context:
            raygrid.Camera(data)
        self.assertEqual(context.exception.status, -17)

    def test_row_time_is_that_of_the_blob(self):
        seconds, deviation = open_blob(make_golden.make_row_time(make_golden.make_example())).row_time()
        self.assertAlmostEqual(seconds, -20e-6, delta=1e-15)
        self.assertAlmostEqual(deviation, 31e-9, delta=1e-15)
        self.assertIsNone(open_blob(LENS).row_time())

    def test_blob_without_uncertainty_says_nothing(self):
        self.assertEqual(open_blob(LENS).uncertainty(PIXELS), [None] * 3)

    @unittest.skipUnless(numpy, "numpy is optional; tools/install_packages tests installs it")
    def test_arrays_will_do(self):
        camera = open_blob(LENS)
        self.assertEqual(camera.unproject(numpy.array(PIXELS)), camera.unproject(PIXELS))
        rays = numpy.array(camera.unproject(PIXELS), dtype=numpy.float32)
        self.assertLess(abs(numpy.array(camera.project(rays)) - numpy.array(PIXELS)).max(), 0.002)
        frame = make_golden.make_frame(160, 120)
        array = numpy.frombuffer(frame, numpy.uint8).reshape(120, 160)
        self.assertEqual(camera.undistort(array), camera.undistort(frame))


if __name__ == "__main__":
    unittest.main()
