#!/usr/bin/env python3
"""The host's Python package against the commands, which are tested on their own."""
import csv
import io
import json
import os
import signal
import sys
import threading
import time
import unittest
import warnings

import blob_reference
import numpy as np
import raygrid
from command_test import SIMULATED_PATTERN, CommandTest, main, programs, read, run, write

GRID = np.stack(np.meshgrid(np.linspace(3, 156, 12), np.linspace(3, 116, 9)), -1).reshape(-1, 2)
STEP = 1e-5
SIZE = (640, 480)
SQUARE_M = 0.03
LINES = "noncentral"


def table(rows, names):
    return "".join(",".join(row) + "\n" for row in
                   [names, *([repr(float(v)) for v in row] for row in rows)])


class PackageTest(CommandTest):
    @classmethod
    def simulated_camera(cls, lens, size="160x120"):
        known = cls.path(f"sim_{lens}/true_camera.yaml")
        return known if os.path.exists(known) else super().simulated_camera(lens, size)

    def answers(self, command, camera, rows, names, columns, *options):
        """Columns of what a command answers; NaN where it leaves them empty."""
        option = {"project": "--points", "unproject": "--pixels"}[command]
        given = write(self.path("given.csv"), table(rows, names))
        result = run(command, camera, option, given, *options)
        self.assert_done(result)
        return np.array([[float(row[name] or "nan") for name in columns]
                         for row in csv.DictReader(io.StringIO(result.stdout))])

    def assert_refuses(self, kind, words, call, *arguments, **named):
        with self.assertRaises(kind) as context:
            call(*arguments, **named)
        text = str(context.exception)
        self.assertIn(words, text)
        self.assertEqual(len(text.splitlines()), 1, text)


class Rays(PackageTest):
    """Cameras of simulated lenses."""

    def check_against_commands(self, lens):
        path = self.simulated_camera(lens)
        camera = raygrid.Camera.load(path)
        beyond = np.vstack([GRID, [[-5, 3], [1e6, 1e6]]])
        expected = self.answers("unproject", path, beyond, "xy", ["dx", "dy", "dz"])
        np.testing.assert_allclose(camera.unproject(beyond), expected, rtol=0, atol=6e-13)
        origins, directions = camera.rays(GRID)
        np.testing.assert_allclose(directions, expected[:len(GRID)], rtol=0, atol=6e-13)
        points = np.vstack([origins + 0.7 * directions, [[0, 0, -1], [1e-200, 0, 1e-199]]])
        if not camera.is_central:
            points = points[:-1]
        seen = self.answers("project", path, points, "xyz", "uv")
        np.testing.assert_allclose(camera.project(points), seen, rtol=0, atol=6e-9)
        np.testing.assert_allclose(seen[:len(GRID)], GRID, atol=1e-4)
        return camera

    def test_a_pinhole_s_figures_are_the_commands(self):
        self.check_against_commands("pinhole")

    def test_a_fisheye_s_figures_are_the_commands(self):
        self.check_against_commands("fisheye")

    def test_lines_figures_are_the_commands(self):
        camera = self.check_against_commands(LINES)
        self.assertFalse(camera.is_central)
        self.assertGreater(np.abs(camera.rays(GRID)[0]).max(), 1e-4)

    def test_jacobians_are_those_of_differences(self):
        for lens in ("pinhole", "fisheye", LINES):
            camera = raygrid.Camera.load(self.simulated_camera(lens))
            origins, directions = camera.rays(GRID)
            points = origins + 0.7 * directions
            pixels, by_point = camera.project(points, jacobians=True)
            np.testing.assert_allclose(pixels, camera.project(points), atol=1e-7)
            self.check_differences(by_point, points, camera.project, 1e-3)
            found, by_pixel = camera.unproject(GRID, jacobians=True)
            np.testing.assert_allclose(found, directions, atol=1e-15)
            self.check_differences(by_pixel, GRID, camera.unproject, 1e-6)

    def check_differences(self, jacobians, places, call, tolerance):
        for axis in range(places.shape[1]):
            move = STEP * np.eye(places.shape[1])[axis]
            numeric = (call(places + move) - call(places - move)) / (2 * STEP)
            np.testing.assert_allclose(jacobians[..., axis], numeric, rtol=1e-4, atol=tolerance)

    def test_any_array_of_numbers_will_do(self):
        camera = raygrid.Camera.load(self.simulated_camera("fisheye"))
        expected = camera.unproject(GRID)
        backwards = np.asfortranarray(GRID[::-1])
        np.testing.assert_array_equal(camera.unproject(backwards)[::-1], expected)
        np.testing.assert_array_equal(camera.unproject(GRID.reshape(3, -1, 2)).reshape(-1, 3),
                                      expected)
        np.testing.assert_array_equal(camera.unproject(GRID.tolist()), expected)
        np.testing.assert_array_equal(camera.unproject(GRID.astype(np.float32)),
                                      camera.unproject(GRID.astype(np.float32).astype(float)))
        np.testing.assert_array_equal(camera.unproject([80, 60]), camera.unproject([[80, 60]])[0])
        np.testing.assert_array_equal(camera.unproject(np.tile(GRID, (99, 1)), threads=1),
                                      camera.unproject(np.tile(GRID, (99, 1)), threads=3))
        self.assertEqual(camera.project(np.empty((0, 3))).shape, (0, 2))

    def test_what_is_wrong_is_said_in_a_line(self):
        camera = raygrid.Camera.load(self.simulated_camera("pinhole"))
        self.assert_refuses(ValueError, "points: expected an array of the shape (N, 3)",
                            camera.project, GRID)
        self.assert_refuses(ValueError, "pixels: entry 1 is nan", camera.unproject,
                            [[1, 2], [3, float("nan")]])
        self.assert_refuses(TypeError, "not of dtype complex", camera.unproject, GRID * 1j)
        self.assert_refuses(TypeError, "pixels: expected an array", camera.unproject, [["a", "b"]])
        self.assert_refuses(raygrid.Error, "has no uncertainty", camera.uncertainty, GRID)
        self.assert_refuses(raygrid.Error, "cannot be read", raygrid.Camera.load, "none.yaml")
        self.assert_refuses(ValueError, "projection: expected pinhole", camera.view,
                            projection="flat")
        self.assert_refuses(raygrid.Error, "hfov", camera.view, hfov=200)
        broken = write(self.path("broken.yaml"), "raygrid_camera: 1\n")
        self.assert_refuses(raygrid.Error, "broken.yaml", raygrid.Camera.load, broken)
        with self.assertRaises(raygrid.Error) as context:
            raygrid.Camera.load(broken)
        self.assertEqual(context.exception.code, run("inspect", broken).returncode)
        self.assertEqual("raygrid: " + str(context.exception), run("inspect", broken).stderr.strip())

    def test_a_camera_with_a_range_is_taken_at_a_value(self):
        text = read(self.simulated_camera("wide")).decode()
        num_points = len(raygrid.Camera.load(self.simulated_camera("wide")).parameters) // 2
        change = ", ".join(["1e-3, -2e-3"] * num_points)
        path = write(self.path("range.yaml"), text + "stack:\n  condition: lens_position\n"
                     "  range: [2, 10]\n  changes:\n    - [%s]\n  deviations: []\n" % change)
        camera = raygrid.Camera.load(path)
        self.assertEqual(camera.range, ("lens_position", 2, 10))
        near = camera.at(9)
        self.assertIsNone(near.range)
        expected = self.answers("unproject", path, GRID, "xy", ["dx", "dy", "dz"], "--at", 9)
        np.testing.assert_allclose(near.unproject(GRID), expected, rtol=0, atol=6e-13)
        self.assertGreater(np.abs(camera.unproject(GRID) - expected).max(), 1e-3)
        self.assert_refuses(ValueError, "11 is outside the calibrated range, 2 to 10 dioptres", camera.at, 11)
        self.assert_refuses(ValueError, "not calibrated over a range", near.at, 5)
        self.assert_refuses(ValueError, "does not vary with temperature", camera.at, temperature=5)
        np.testing.assert_array_equal(camera.at(lens_position=9).unproject(GRID),
                                      near.unproject(GRID))

    def test_a_camera_with_two_ranges_takes_values_by_their_names(self):
        text = read(self.simulated_camera("wide")).decode()
        num_points = len(raygrid.Camera.load(self.simulated_camera("wide")).parameters) // 2
        conditions = "".join(
            "    - condition: %s\n      range: %s\n      changes:\n        - [%s]\n" %
            (name, values, ", ".join([change] * num_points))
            for name, values, change in (("lens_position", [2, 10], "1e-3, -2e-3"),
                                         ("temperature", [20, 60], "-3e-4, 1e-4")))
        path = write(self.path("ranges.yaml"),
                     text + "stack:\n  conditions:\n" + conditions + "  deviations: []\n")
        camera = raygrid.Camera.load(path)
        self.assertIsNone(camera.range)
        self.assertEqual(camera.ranges, [("lens_position", 2, 10), ("temperature", 20, 60)])
        at = camera.at(lens_position=9, temperature=25)
        self.assertEqual(at.ranges, [])
        expected = self.answers("unproject", path, GRID, "xy", ["dx", "dy", "dz"], "--at",
                                "lens_position=9,temperature=25")
        np.testing.assert_allclose(at.unproject(GRID), expected, rtol=0, atol=6e-13)
        near = camera.at(lens_position=9)
        self.assertEqual(near.range, ("temperature", 20, 60))
        np.testing.assert_allclose(near.at(25).unproject(GRID), expected, rtol=0, atol=6e-13)
        self.assert_refuses(ValueError, "varies with two quantities", camera.at, 9)
        self.assert_refuses(ValueError, "61 is outside the calibrated range, 20 to 60", camera.at,
                            temperature=61)

    def test_what_it_tells_of_itself_stays(self):
        camera = raygrid.Camera.load(self.simulated_camera("pinhole"))
        with self.assertRaises(ValueError):
            camera.parameters[0] = 1
        with self.assertRaises(AttributeError):
            camera.name = "other"
        with self.assertRaises(ValueError):
            camera.view().K[0, 0] = 1
        self.assertEqual((camera.size, camera.area), ((160, 120), (0, 0, 159, 119)))

    def test_maps_are_those_that_export_writes(self):
        path = self.simulated_camera("fisheye")
        camera = raygrid.Camera.load(path)
        for options, view, reverse in (
                ([], None, False),
                (["--size", "90x70", "--hfov", "80", "--rotate", "10,5,0"],
                 camera.view(size=(90, 70), hfov=80, rotate=(10, 5, 0)), False),
                (["--hfov", "70", "--inverse"], camera.view(hfov=70), True)):
            archive = self.path("maps.npz")
            self.assert_done(run("export", path, "--to", "maps", *options, "-o", archive))
            expected = np.load(archive)
            map1, map2 = camera.maps(view, reverse=reverse)
            np.testing.assert_array_equal(map1, expected["map1"])
            np.testing.assert_array_equal(map2, expected["map2"])
            if view:
                np.testing.assert_array_equal(view.K, expected["K"])

    def test_a_blob_is_what_the_runtime_makes_of_it(self):
        camera = raygrid.Camera.load(self.simulated_camera("pinhole"))
        data = camera.pack([camera.view(size=(128, 96), focal=60)], max_error_px=0.5)
        path = write(self.path("camera.raygrid"), data)
        blob = raygrid.Blob(path)
        directions = blob.unproject(GRID)
        np.testing.assert_allclose(
            directions, self.answers("unproject", path, GRID, "xy", ["dx", "dy", "dz"]), atol=1e-9)
        np.testing.assert_allclose(directions, camera.unproject(GRID), atol=1e-3)
        np.testing.assert_allclose(blob.project(directions),
                                   self.answers("project", path, directions, "xyz", "uv"),
                                   atol=2e-5)
        frame = np.random.default_rng(1).integers(0, 256, (120, 160), dtype=np.uint8)
        raw = write(self.path("frame.raw"), frame.tobytes())
        self.assert_done(run(path, raw, self.path("flat.pgm"), program=programs.undistort))
        flat = blob.undistort(frame)
        self.assertEqual(flat.tobytes(), read(self.path("flat.pgm"))[-flat.size:])
        self.assertEqual(flat.shape, (96, 128))
        np.testing.assert_array_equal(
            blob.undistort(np.dstack([frame] * 3))[..., 1], flat)
        out = np.zeros_like(flat)
        self.assertIs(blob.undistort(frame, out=out), out)
        np.testing.assert_array_equal(out, flat)
        for wrong in (out[1:], out.astype(np.uint16), bytearray(out)):
            with self.assertRaisesRegex(ValueError, "out: expected an array of uint8"):
                blob.undistort(frame, out=wrong)
        self.assertTrue(np.isnan(blob.unproject([[-9, 0]])).all())
        self.assert_refuses(ValueError, "expected an array of the shape (N, 2)", blob.unproject,
                            [1, 2, 3])
        self.assert_refuses(raygrid.BlobError, "", raygrid.Blob, b"no blob")
        self.assert_refuses(raygrid.Error, "use raygrid.Blob", raygrid.Camera.load, path)
        self.assertTrue(blob_reference.parse(data))

    def test_lenses_go_out_and_come_in_exactly(self):
        source = raygrid.Camera.load(self.simulated_camera("pinhole"))
        path = self.path("camera.xml")
        left = raygrid.importers.save(source, path, "opencv", max_fit_error=1)
        camera = raygrid.importers.load(path)
        self.assertLess(left[0].get("rms_px", 0), 0.1)
        self.assertIn("fx", camera.named_parameters)
        again = self.path("again.yaml")
        self.assertTrue(raygrid.importers.save(camera, again, "ros")[0]["exact"])
        np.testing.assert_array_equal(raygrid.importers.load(again).project([[0.1, 0.2, 1]]),
                                      camera.project([[0.1, 0.2, 1]]))
        own = self.path("own.yaml")
        camera.save(own)
        np.testing.assert_array_equal(raygrid.Camera.load(own).parameters, camera.parameters)
        names = [each.name for each in raygrid.importers.formats()]
        self.assertIn("kalibr", names)
        listed = json.loads(run("export", "--list", "--json").stdout)
        self.assertEqual(names, [each["name"] for each in listed if each["source"] == "a lens"])
        self.assert_refuses(raygrid.Error, "unknown format", raygrid.importers.save, camera, own, "none")

    def test_rigs_go_out_and_come_in(self):
        camera = raygrid.importers.load(self.exported_lens())
        pose = np.eye(4)
        pose[:3, 3] = [-0.1, 0.02, 0.003]
        pairs = {("left", "right"): np.diag([1e-8, 2e-8, 3e-8, 1e-10, 2e-10, 3e-10])}
        rig = raygrid.Rig({"left": camera, "right": camera}, {"left": np.eye(4), "right": pose}, pairs)
        points = np.array([[0.1, 0.2, 1.5], [0, 0, 2]])
        expected = rig.project(points)
        np.testing.assert_array_equal(expected["right"], camera.project(points + pose[:3, 3]))
        rig.save(self.path("rig/rig.yaml"))
        raygrid.importers.save(rig, self.path("camchain.yaml"), "kalibr")
        for other in (raygrid.Rig.load(self.path("rig/rig.yaml")),
                      raygrid.importers.load(self.path("camchain.yaml"))):
            for pixels, wanted in zip(other.project(points).values(), expected.values()):
                np.testing.assert_allclose(pixels, wanted, atol=1e-9)
        self.assert_done(run("inspect", self.path("rig/rig.yaml")))
        loaded = raygrid.Rig.load(self.path("rig/rig.yaml")).covariances
        self.assertEqual(list(loaded), [("left", "right")])
        np.testing.assert_allclose(loaded["left", "right"], pairs["left", "right"])
        rig.covariances = {("left", "top"): np.eye(6)}
        self.assert_refuses(raygrid.Error, "no camera 'top'", rig.save, self.path("no.yaml"))
        self.assert_refuses(ValueError, "a rotation", raygrid.Rig({"a": camera},
                            {"a": np.diag([1, 1, 2, 1])}).save, self.path("no.yaml"))

    def exported_lens(self):
        path = self.path("lens.yaml")
        source = self.simulated_camera("pinhole")
        self.assert_done(run("export", source, "--to", "opencv", "-o", path))
        return path

    def test_what_is_not_taken_is_warned_of(self):
        path = write(self.path("roi.yaml"), ROS_WITH_REGION)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            raygrid.Camera.load(path)
        said = run("unproject", path, "--pixels", write(self.path("given.csv"), "x,y\n")).stderr
        self.assertEqual([f"raygrid: {each.message}" for each in caught], said.splitlines())
        self.assertEqual(len(caught), 1)


ROS_WITH_REGION = """image_width: 640
image_height: 480
camera_name: front
camera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0.1, 0, 0, 0, 0]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]}
roi: {x_offset: 10, y_offset: 0, height: 0, width: 0, do_rectify: false}
"""


class Calibrations(PackageTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        result = run("simulate", "--images", 9, "--features-per-image", 60, "--pattern", write(cls.path("board.yaml"), SIMULATED_PATTERN), "-o",
                     cls.path("sim"))
        assert result.returncode == 0, result.stderr
        cls.pattern = cls.path("sim/pattern.yaml")
        cls.features = raygrid.load_features(cls.path("sim/features.csv"), SIZE)
        cls.told = []
        cls.counted = [0]
        ended = threading.Event()

        def count():
            while not ended.wait(0.001):
                cls.counted[0] += 1
        counter = threading.Thread(target=count)
        counter.start()
        began = time.monotonic()
        cls.calibration = raygrid.calibrate(
            cls.features, cls.pattern, name="front", serial="7", model="opencv",
            hold_out=[cls.features[3].name], progress=lambda *news: cls.told.append(news))
        cls.seconds = time.monotonic() - began
        ended.set()
        counter.join()

    def test_other_threads_go_on(self):
        self.assertGreater(self.counted[0], 100 * self.seconds)

    def test_progress_is_told(self):
        done = [each[1] for each in self.told]
        self.assertEqual(done, sorted(done))
        self.assertEqual((self.told[-1][0], done[-1]), ("done", 1))
        self.assertGreater(len(self.told), 1)
        self.assertGreater(max(left or 0 for _, _, left in self.told), 0)

    def test_result_is_the_commands(self):
        self.assert_done(run("calibrate", "--features", self.path("sim/features.csv"),
                             "--image-size", "640x480", "--pattern", self.pattern, "--name",
                             "front", "--serial", "7", "--skip-comparison", "--model", "opencv",
                             "--hold-out", self.features[3].name, "-o",
                             self.path("theirs")))
        self.calibration.save(self.path("ours"))
        for name in ("camera.yaml", "camera.raygrid", "view.camera.yaml", "pattern.yaml",
                     "features.csv", "poses.csv", "residuals.csv"):
            self.assertEqual(read(self.path("ours/" + name)), read(self.path("theirs/" + name)),
                             name)
        ours, theirs = (json.loads(read(self.path(f"{folder}/result.json")))
                        for folder in ("ours", "theirs"))
        for result in (ours, theirs):
            del result["stage_seconds"], result["peak_memory_bytes"]
        self.assertEqual(ours, theirs)
        self.check_camera(self.path("theirs/camera.yaml"))

    def check_camera(self, path):
        camera = raygrid.Camera.load(path)
        facts = json.loads(run("inspect", path, "--json").stdout)["uncertainty"]
        figures = camera.uncertainty_figures
        self.assertEqual(figures["median_px"], facts["median_px"])
        x0, y0, x1, y1 = camera.area
        lattice = np.stack(np.meshgrid(np.linspace(x0, x1, 33), np.linspace(y0, y1, 25)), -1)
        known = camera.uncertainty(lattice)
        self.assertAlmostEqual(np.nanmedian(known) / figures["median_px"], 1, delta=0.15)
        pixels = np.stack(np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1])), -1)
        self.assertAlmostEqual(camera.is_valid(pixels).mean(), figures["valid_fraction"],
                               places=3)
        # A lens that the model cannot follow may be valid nowhere.
        self.assertLessEqual(np.nanmax(known[camera.is_valid(lattice)], initial=0),
                             1.3 * figures["valid_limit_px"])
        self.assertTrue(np.isnan(camera.uncertainty([[-50, 0]])).all())

    def test_what_was_found_is_told(self):
        found = self.calibration
        self.assertEqual((found.camera.name, found.camera.serial), ("front", "7"))
        result = json.loads(found.result_json)
        self.assertEqual(found.verdict, result["verdict"])
        _, errors = found.held_out()
        self.assertAlmostEqual(np.median(np.hypot(*errors.T)),
                               result["held_out"]["median_px"], places=6)
        image, board, pose = found.poses()[0]
        used = {each.name: each for each in found.features()}[image]
        pixels, _ = found.training()
        self.assertEqual(len(pixels), sum(map(len, found.features())))
        points = SQUARE_M * np.stack([used.columns, used.rows, 0 * used.rows], -1)
        seen = found.camera.project(points @ pose[:3, :3].T + pose[:3, 3])
        self.assertEqual(board, 0)
        self.assertLess(np.abs(seen - used.pixels).max(), 1)
        self.assertFalse(used.pixels.flags.writeable)

    def test_interruption_ends_it_soon(self):
        before = set(os.listdir(self.folder))
        # Alone, it takes 3 s or more.
        timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
        began = time.process_time()
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            raygrid.calibrate(self.features, self.pattern, threads=1)
        self.assertLess(time.process_time() - began, 1.5)
        self.assertEqual(set(os.listdir(self.folder)), before)

    def test_exceptions_of_progress_end_it(self):
        def fail(stage, done, left):
            raise LookupError(stage)
        with self.assertRaises(LookupError):
            raygrid.calibrate(self.features, self.pattern, progress=fail)

    def test_images_of_the_same_view_count_once(self):
        with self.assertRaises(ValueError):
            raygrid.calibrate(self.features, self.pattern, duplicate_px=-1)
        with self.assertRaises(TypeError):
            raygrid.calibrate(self.features, self.pattern, duplicates_px=1)
        first = self.features[0]
        copy = raygrid.Detection("copy.png", first.size, first.pixels + 0.01, first.columns,
                                 first.rows)
        for option, groups in (({}, [{"image": first.name, "duplicates": ["copy.png"]}]),
                               ({"duplicate_px": 0}, None), ({"same_view_px": 0}, None)):
            result = json.loads(raygrid.calibrate([*self.features, copy], self.pattern,
                                                  model="opencv", **option).result_json)
            self.assertEqual(result["images"].get("near_duplicates"), groups)

    def test_features_come_back_from_their_file(self):
        raygrid.save_features(self.path("again.csv"), self.features)
        self.assertEqual(read(self.path("again.csv")), read(self.path("sim/features.csv")))
        first = self.features[0]
        copy = raygrid.Detection(first.name, first.size, first.pixels, first.columns, first.rows)
        np.testing.assert_array_equal(copy.pixels, first.pixels)
        self.assert_refuses(ValueError, "rows: expected an array of 2 integers", raygrid.Detection,
                            "a", SIZE, [[1, 2], [3, 4]], [0, 1], [0])

    def test_what_is_wrong_is_said_in_a_line(self):
        refuse = self.assert_refuses
        refuse(ValueError, "images: empty", raygrid.calibrate, [], self.pattern)
        refuse(TypeError, "images: expected paths", raygrid.calibrate, [1], self.pattern)
        refuse(raygrid.Error, "model", raygrid.calibrate, self.features, self.pattern, model="none")
        refuse(raygrid.Error, "duplicate image name", raygrid.calibrate,
               self.features[:1] * 2, self.pattern)
        refuse(raygrid.Error, "cannot be read", raygrid.calibrate, self.features, "none.yaml")
        refuse(raygrid.Error, "", raygrid.calibrate, self.features[:1], self.pattern)


class Detections(PackageTest):
    BOARD = "chessboard:7x5:30mm"

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        board = cls.path("board")
        for command in (["pattern", "chessboard", "--columns", 7, "--rows", 5, "--square-mm", 30,
                         "-o", board],
                        ["simulate", "--render", "--images", 1, "--pattern",
                         board + "/pattern.yaml", "-o", cls.path("seen")]):
            result = run(*command)
            assert result.returncode == 0, result.stderr
        cls.photograph = next(os.path.join(folder, name)
                              for folder, _, names in os.walk(cls.path("seen"))
                              for name in sorted(names) if name.endswith(".png"))

    def test_features_are_the_commands(self):
        import cv2
        self.assert_done(run("detect", self.photograph, "--pattern", self.BOARD, "-o",
                             self.path("features.csv"), "--no-cache"))
        found = raygrid.detect(self.photograph, self.BOARD)
        self.assertGreater(len(found), 12)
        raygrid.save_features(self.path("ours.csv"), [found])
        self.assertEqual(read(self.path("ours.csv")), read(self.path("features.csv")))
        image = cv2.imread(self.photograph, cv2.IMREAD_GRAYSCALE)
        for array in (image, np.dstack([image] * 3), image.astype(np.uint16) * 256,
                      np.asfortranarray(image), image.astype(">u2") * 256):
            other = raygrid.detect(array, self.BOARD, name="x")
            self.assertEqual((other.name, other.size), ("x", SIZE))
            np.testing.assert_allclose(other.pixels, found.pixels, atol=0.02)
        np.testing.assert_array_equal(raygrid.detect(image, self.BOARD).pixels, found.pixels)

    def test_colours_weigh_as_opencv_has_them(self):
        import cv2
        image = cv2.imread(self.photograph, cv2.IMREAD_GRAYSCALE)
        blue, red = image, np.roll(image, 1, axis=1)  # a pixel apart
        coloured = np.dstack([blue, np.zeros_like(image), red])
        grey = np.rint(0.114 * blue + 0.299 * red).astype(np.uint8)
        np.testing.assert_allclose(raygrid.detect(coloured, self.BOARD).pixels,
                                   raygrid.detect(grey, self.BOARD).pixels, atol=0.1)

    def test_what_is_wrong_is_said_in_a_line(self):
        refuse = self.assert_refuses
        refuse(TypeError, "not float64", raygrid.detect, np.zeros((9, 9)), self.BOARD)
        refuse(ValueError, "(height, width, 3)", raygrid.detect, np.zeros((9, 9, 4), np.uint8),
               self.BOARD)
        refuse(ValueError, "refinement: expected", raygrid.detect, np.zeros((99, 99), np.uint8),
               self.BOARD, refinement="best")
        refuse(raygrid.Error, "chess", raygrid.detect, np.zeros((99, 99), np.uint8), "chess:1")
        self.assertEqual(len(raygrid.detect(np.zeros((99, 99), np.uint8), self.BOARD)), 0)


if __name__ == "__main__":
    sys.exit(main(__name__))
