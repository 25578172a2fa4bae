#!/usr/bin/env python3
"""Rectified pairs: rows that agree with the truth, matrices as OpenCV has them, and what is refused."""
import json
import math
import os
import random
import re

from command_test import CommandTest, SIMULATED_PATTERN, main, read, run, write
from images_test import png

FILES = ["cam0.camera.yaml", "cam0.raygrid", "cam1.camera.yaml", "cam1.raygrid", "rectified.yaml"]
SIDES = ("left", "right")


def times(matrix, vector):
    return [sum(a * b for a, b in zip(row, vector)) for row in matrix]


def matrix_of(text, name):
    """A matrix of rectified.yaml."""
    rows = re.search(rf"^{name}:\n((?:  - \[.*\]\n)+)", text, re.MULTILINE).group(1)
    return [[float(word) for word in row.split(",")] for row in re.findall(r"\[(.*)\]", rows)]


class Rectify(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        board = write(cls.path("board.yaml"), SIMULATED_PATTERN)
        cls.succeed("simulate", "--cameras", 3, "--baseline-m", 0.1, "--lens", "wide", "--size",
                    "160x120", "--images", 4, "--pattern", board, "-o", cls.path("sim"))
        cls.rig = cls.path("sim/true_rig.yaml")
        cls.camera = re.search(r'file: "(.*)"', read(cls.rig).decode()).group(1)

    def rectify(self, *arguments, rig=None, left="cam0", right="cam1", out="out"):
        return run("rectify", rig or self.rig, "--left", left, "--right", right, "--max-error-px",
                   0.25, *arguments, "-o", self.path(out))

    def pose_of(self, number, rotation, translation):
        """The rig with one camera elsewhere."""
        text = read(self.rig).decode()
        entries = re.split(r'(?=^  "cam)', text, flags=re.MULTILINE)
        entry = re.sub(r"rotation: .*", "rotation: {w: %g, x: %g, y: %g, z: %g}" % rotation,
                       entries[1 + number])
        entries[1 + number] = re.sub(
            r"translation: .*", "translation: {x: %g, y: %g, z: %g}" % translation, entry)
        return write(self.path("sim/moved.yaml"), "".join(entries))

    def seen_by(self, number, points):
        """The pixels of the camera's image; those that it does not see are (0, 0)."""
        rows = ["%.9f,%.9f,%.9f\n" % (x - 0.1 * number, y, z) for x, y, z in points]
        text = write(self.path("xyz.csv"), "x,y,z\n" + "".join(rows))
        told = json.loads(run("project", self.path("sim/" + self.camera), "--points", text,
                              "--json").stdout)
        return [(seen["u"], seen["v"]) if seen["valid"] else (0, 0) for seen in told]

    def shown(self, camera, pixels):
        """Where the view shows pixels: by the blob's rays, R and P."""
        text = write(self.path("px.csv"), "x,y\n" + "".join("%.9f,%.9f\n" % at for at in pixels))
        for ray in json.loads(run("unproject", camera["blob"], "--pixels", text, "--json").stdout):
            x, y, z = times(camera["P"],
                            times(camera["R"], [ray["dx"], ray["dy"], ray["dz"]]) + [0])
            yield x / z, y / z

    def check_rows(self, told):
        """Points of the rig's space, seen by its cameras, keep their row in the two views."""
        draw = random.Random(1).uniform
        points = [(draw(-0.2, 0.4), draw(-0.3, 0.3), draw(0.6, 3)) for _ in range(40)]
        pixels = [self.seen_by(number, points) for number in (0, 1)]
        shown = [self.shown(told[side], seen) for side, seen in zip(SIDES, pixels)]
        rows = [row for row in zip(points, *pixels, *shown) if (0, 0) not in row]
        self.assertGreater(len(rows), 20)
        for point, _, _, left, right in rows:
            self.assertAlmostEqual(left[1], right[1], delta=0.01)
            x, y, z, w = times(told["Q"], [*left, left[0] - right[0], 1])
            for a, b in zip((x / w, y / w, z / w), times(told["left"]["R"], point)):
                self.assertAlmostEqual(a, b, delta=2e-3)

    def test_points_keep_their_row(self):
        result = self.rectify("--json")
        self.assert_done(result)
        told = json.loads(result.stdout)
        self.assertEqual(sorted(os.listdir(self.path("out"))), FILES)
        self.assertEqual((told["orientation"], told["left"]["size"]), ("horizontal", [160, 120]))
        self.assertAlmostEqual(told["baseline_m"], 0.1, 9)
        self.assertEqual(told["left"]["K"], told["right"]["K"])
        self.check_rows(told)

    def test_the_file_has_the_matrices(self):
        result = self.rectify("--json", "--size", "100x90", out="file")
        self.assert_done(result)
        told = json.loads(result.stdout)
        text = read(self.path("file/rectified.yaml")).decode()
        for name, value in (("R1", told["left"]["R"]), ("R2", told["right"]["R"]),
                            ("P1", told["left"]["P"]), ("P2", told["right"]["P"]),
                            ("Q", told["Q"])):
            self.assertEqual(matrix_of(text, name), value)
        focal = told["left"]["K"][0][0]
        self.assertAlmostEqual(matrix_of(text, "P2")[0][3], -focal * 0.1, 9)
        self.assertAlmostEqual(matrix_of(text, "Q")[3][2], 10, 9)
        self.assertIn("baseline: 0.1", text)
        self.assertIn("image_size: [100, 90]", text)

    def test_the_blobs_undistort_and_the_views_are_cameras(self):
        self.assert_done(self.rectify(out="use"))
        image = write(self.path("white.png"), png([255] * (160 * 120), size=(160, 120)))
        for name in ("cam0", "cam1"):
            self.succeed("inspect", self.path(f"use/{name}.camera.yaml"))
            self.succeed("undistort", self.path(f"use/{name}.raygrid"), image, "-o",
                         self.path(f"use/{name}"))

    def test_says_what_it_made(self):
        result = self.rectify("--alpha", 1, out="words")
        self.assert_done(result)
        for word in ("baseline 0.1 m", "row", "cam0.raygrid", "fx", "overlaps with cam1"):
            self.assertIn(word, result.stdout)
        result = self.rectify("--hfov", 70, out="words")
        self.assert_done(result)
        self.assertIn("field of view 70.0 x", result.stdout)

    def test_same_bytes_with_any_number_of_threads(self):
        for threads in (1, 2):
            self.assert_done(self.rectify("--threads", threads, out=f"threads{threads}"))
        for name in FILES:
            self.assertEqual(read(self.path("threads1/" + name)),
                             read(self.path("threads2/" + name)))

    def test_pairs_that_cannot_be(self):
        back = (math.cos(1.4), 0, math.sin(1.4), 0)
        for rig, arguments, words in (
                (None, dict(left="cam9"), ("--left cam9", "cam0, cam1, cam2")),
                (None, dict(right="cam0"), ("both cam0",)),
                (None, dict(left="cam1", right="cam0"),
                 ("cam1 is to the right of cam0", "--left cam0 --right cam1")),
                ((1, back, (-0.1, 0, 0)), {}, ("do not overlap", "cam0 and cam1")),
                ((1, (1, 0, 0, 0), (0, 0, 0)), {}, ("no baseline",)),
                ((1, (1, 0, 0, 0), (0, 0, -0.3)), {}, ("epipoles",)),
                ((1, (1, 0, 0, 0), (0, 0.1, 0)), {}, ("below", "--left cam1 --right cam0"))):
            with self.subTest(words[0]):
                moved = self.pose_of(*rig) if rig else None
                self.assert_refused(self.rectify(rig=moved, out="never", **arguments), 1, *words)
                self.assert_nothing_in(self.path("never"))

    def test_options_that_cannot_be(self):
        for arguments, words in (
                (("--alpha", "1.5"), ("alpha 1.5",)), (("--alpha", "x"), ("--alpha",)),
                (("--alpha", 0, "--hfov", 60), ("mutually exclusive",)), (("--hfov", 180), ("170",)),
                (("--size", "0x10"), ("--size",)), (("--size", "10"), ("640x480",)),
                (("--size", "9000x9000"), ("8192",)), (("--distance", "2"), ("--distance",)),
                (("--distance", "-2"), ("--distance",))):
            with self.subTest(arguments):
                self.assert_refused(self.rectify(*arguments, out="never"), 1, *words)
                self.assert_nothing_in(self.path("never"))
        self.assert_refused(run("rectify", self.rig, "--left", "cam0", "--right", "cam1", "--max-error-px", 1e-9, "-o", self.path("never")), 6, "--max-error-px")
        self.assert_nothing_in(self.path("never"))
        self.assert_refused(self.rectify(rig=self.path("sim/" + self.camera)), 2, "raygrid_rig")

    def test_outputs_replace_no_input(self):
        rig = read(self.rig).replace(self.camera.encode(), b"cam0.camera.yaml")
        write(self.path("own/rig.yaml"), rig)
        camera = read(self.path("sim/" + self.camera))
        write(self.path("own/cam0.camera.yaml"), camera)
        self.assert_refused(self.rectify(rig=self.path("own/rig.yaml"), out="own"), 7,
                            "overwrite the input")
        self.assertEqual(read(self.path("own/cam0.camera.yaml")), camera)
        self.assertEqual(sorted(os.listdir(self.path("own"))), ["cam0.camera.yaml", "rig.yaml"])

    def test_upper_and_lower_cameras_keep_columns(self):
        moved = self.pose_of(1, (1, 0, 0, 0), (0, -0.1, 0))
        result = self.rectify("--json", rig=moved, out="vertical")
        self.assert_done(result)
        told = json.loads(result.stdout)
        self.assertEqual(told["orientation"], "vertical")
        focal = told["left"]["K"][1][1]
        self.assertAlmostEqual(told["right"]["P"][1][3], -0.1 * focal, 9)
        self.assertEqual(told["right"]["P"][0][3], 0)
        self.assertIn("column", read(self.path("vertical/rectified.yaml")).decode())


class RectifyLines(CommandTest):
    def test_cameras_of_lines_want_a_distance(self):
        board = write(self.path("board.yaml"), SIMULATED_PATTERN)
        self.succeed("simulate", "--lens", "glass", "--cameras", 2, "--baseline-m", 0.1,
                     "--size", "160x120", "--images", 12, "--pattern", board, "-o",
                     self.path("sim"))
        self.succeed("calibrate", "--features", self.path("sim/features.csv"),
                     "--image-size", "160x120", "--pattern", board, "--model",
                     "noncentral-generic", "--knot-spacing-px", 60, "--skip-comparison",
                     "--hold-out", "sim0000.png", "-o", self.path("rig"))
        rectify = ("rectify", self.path("rig/rig.yaml"), "--left", "cam0", "--right", "cam1", "-o",
                   self.path("out"))
        self.assert_refused(run(*rectify), 1, "--distance METRES", "camera.yaml")
        self.assert_nothing_in(self.path("out"))
        for distance in (0, -1, "inf", "nan", "1e999", "far"):
            self.assert_refused(run(*rectify, "--distance", distance), 1, f"--distance: {distance} is not a")
        self.succeed(*rectify, "--distance", 0.6)
        self.assertIn("distance: 0.6", read(self.path("out/rectified.yaml")).decode())


if __name__ == "__main__":
    main(__name__)
