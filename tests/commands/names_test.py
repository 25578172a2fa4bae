#!/usr/bin/env python3
"""Names are data, and results that cannot be printed are not lost without a word."""
import json
import os
import subprocess
import unittest

from command_test import CommandTest, SIMULATED_PATTERN, call, commands, main, programs, read, run, write

NAMES = ["#1.png", "a,b.png", "a\nb.png", 'say "a".png', " a.png ", "caf\u00e9.png",
         "\x1b[31mred.png", "<img src=x onerror=alert(1)>.png", "</script>.png", "'.png", "a#.png",
         "9.png", "10.png", "11.png"]


def quoted(name):
    return '"' + name.replace('"', '""') + '"'


class Names(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        board = write(cls.path("board.yaml"), SIMULATED_PATTERN)
        cls.succeed("simulate", "--images", len(NAMES), "--features-per-image", 40, "--lens",
                    "wide", "--size", "160x120", "--pattern", board, "-o", cls.path("sim"))
        cls.plain = read(cls.path("sim/features.csv")).decode()
        cls.camera = cls.path("sim/true_camera.yaml")

    def features(self, names, quote=quoted):
        """The simulated features, of images with these names."""
        header, *lines = self.plain.splitlines()
        images = sorted({line.split(",")[0] for line in lines})
        new = {image: quote(name) for image, name in zip(images, names)}
        lines = [new[line.split(",")[0]] + "," + line.split(",", 1)[1] for line in lines]
        return write(self.path("features.csv"),
                     "\n".join([header] + lines).encode("utf-8", "surrogateescape") + b"\n")

    def calibrate(self, features, *more, output="out"):
        return run("calibrate", "--features", features, "--image-size", "160x120", "--pattern",
                   self.path("sim/pattern.yaml"), "--model", "opencv", "--skip-comparison",
                   "--fix-target-geometry", "-o", self.path(output), *more)

    def test_names_come_through_a_calibration_as_they_are(self):
        self.assert_done(self.calibrate(self.features(NAMES)))
        facts = json.loads(run("inspect", self.path("out/features.csv"), "--json").stdout)
        self.assertEqual(facts["cameras"][0]["images"], len(NAMES))
        html = read(self.path("out/report.html")).decode()
        for name in ("<img src=x", "</script>."):
            self.assertNotIn(name, html)
        self.assertIn("&lt;img src=x", html)
        self.succeed("report", self.path("out"))
        self.assertEqual(read(self.path("out/report.html")).decode(), html)
        evaluated = self.succeed("evaluate", self.path("out/camera.yaml"), "--features",
                                 self.path("out/features.csv"), "--pattern", self.path("out/pattern.yaml"))
        self.assertNotIn("\x1b", evaluated.stdout)

    def test_images_of_any_name_are_held_out(self):
        features = self.features(NAMES)
        for held_out in (["#1.png"], ['"a,b.png",9.png'], ['"a,b.png"', '"say ""a"".png"'],
                         ['"a\nb.png"'], ["9.png,10.png", "11.png"]):
            with self.subTest(held_out):
                options = [word for text in held_out for word in ("--hold-out", text)]
                self.assert_done(self.calibrate(features, *options, output="held"))
                result = json.loads(read(self.path("held/result.json")))
                count = sum(text.count(".png") for text in held_out)
                self.assertEqual(result["images"]["used"], len(NAMES) - count)
        self.assert_refused(self.calibrate(features, "--hold-out", '"a.png'), 1, "--hold-out")

    def test_names_without_quotes_are_refused_where_they_need_some(self):
        plain = self.features(["a,b.png"] + NAMES[11:] + NAMES[:10], quote=lambda name: name)
        self.assert_refused(self.calibrate(plain), 2, "features.csv, line", "quote names")

    def test_names_that_are_not_utf8_are_refused_before_the_work(self):
        latin = self.features(["caf\udce9.png"] + NAMES[1:])
        self.assert_refused(self.calibrate(latin, output="latin"), 2, "features.csv, line 2",
                            "UTF-8")
        os.makedirs(self.path("photos"))
        try:
            write(os.fsencode(self.path("photos/")) + b"caf\xe9.pgm", b"P5\n1 1\n255\n0")
        except OSError:
            self.skipTest("this file system refuses names that are not UTF-8; set TMPDIR to a folder of another one")
        for command in (["detect", self.path("photos"), "-o", self.path("latin.csv")],
                        ["calibrate", self.path("photos"), "-o", self.path("latin")]):
            result = run(*command, "--pattern", self.path("sim/pattern.yaml"))
            self.assert_refused(result, 2, "caf\\xe9.pgm", "rename")
        self.assert_nothing_in(self.path("latin"))

    def test_camera_names_that_no_blob_holds_are_refused_before_the_work(self):
        for option in ("--name", "--serial"):
            for name in (b"caf\xe9", b"x" * 32):
                for command in (["pack", self.camera, "-o", self.path("never.raygrid")],
                                ["calibrate", "--features", self.path("nowhere.csv"),
                                 "--image-size", "640x480", "--pattern",
                                 self.path("nowhere.yaml"), "-o", self.path("never")]):
                    if command[0] == "calibrate":
                        command[2] = self.features(NAMES)
                    result = subprocess.run(
                        [os.fsencode(part) for part in [programs.raygrid, *command, option]]
                        + [name], capture_output=True, text=True, check=False)
                    self.assert_refused(result, 1, option)
        for never in ("never", "never.raygrid"):
            self.assertFalse(os.path.exists(self.path(never)))

    def test_a_camera_file_that_is_not_utf8_is_refused(self):
        text = read(self.camera).replace(b"model:", b"name: caf\xe9\nmodel:")
        result = run("pack", write(self.path("latin.yaml"), text), "-o",
                     self.path("latin.raygrid"))
        self.assert_refused(result, 2, "latin.yaml, line 2", "UTF-8")

    def test_keys_that_stand_twice_are_refused_by_name(self):
        camera = read(self.camera).decode()
        twice = write(self.path("twice.yaml"), camera.replace(
            "image_size:", "image_size: [160, 120]\nimage_size:", 1))
        self.assert_refused(run("inspect", twice), 2, "twice.yaml, line 5", "'image_size'")
        pattern = write(self.path("squares.yaml"), SIMULATED_PATTERN.replace(
            "square_m: 0.03", "square_m: 0.03, square_m: 0.3"))
        self.assert_refused(run("inspect", pattern), 2, "squares.yaml, line 3", "'square_m'")
        # Aliases of aliases, which would be endless if they were followed.
        many = "a0: &a0 [x, x]\n" + "".join(
            f"a{k}: &a{k} [{', '.join(['*a%d' % (k - 1)] * 9)}]\n" for k in range(1, 30))
        write(self.path("aliases.yaml"), "raygrid_pattern: 1\n" + many)
        self.assert_refused(run("inspect", self.path("aliases.yaml")), 2, "boards")

    def test_numbers_that_are_none_are_refused(self):
        output = ["-o", self.path("nan")]
        for arguments in (["simulate", "--noise-px"], ["simulate", "--exposure"],
                          ["simulate", "--baseline-m"], ["pack", self.camera, "--max-error-px"],
                          ["undistort", self.camera, self.camera, "--hfov"],
                          ["undistort", self.camera, self.camera, "--max-error-px"],
                          ["view", self.camera, "--max-error-px"],
                          ["pattern", "chessboard", "--columns", 9, "--rows", 6, "--square-mm"],
                          ["pattern", "chessboard", "--columns", 9, "--rows", 6, "--square-mm",
                           20, "--dpi"],
                          ["compare", self.camera, self.camera, "--distance-m"],
                          ["pack", self.camera, "--remap=160x120,hfov=nan"],
                          ["rectify", "rig.yaml", "--left", "a", "--right", "b", "--alpha"],
                          ["rectify", "rig.yaml", "--left", "a", "--right", "b", "--distance"],
                          ["calibrate", "--features", self.path("sim/features.csv"), "--image-size",
                           "160x120", "--pattern", self.path("sim/pattern.yaml"), "--knot-spacing-px"],
                          ["calibrate", "--features", self.path("sim/features.csv"), "--image-size",
                           "160x120", "--pattern", self.path("sim/pattern.yaml"),
                           "--duplicate-px"]):
            for number in ("nan", "inf", "-nan"):
                last = [] if "=" in str(arguments[-1]) else [number]
                self.assert_refused(run(*arguments, *last, *output), 1)
                self.assert_nothing_in(self.path("nan"))

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full, which fails as a full disk does")
    def test_results_that_cannot_be_printed_are_an_error(self):
        blob = self.path("camera.raygrid")
        self.succeed("pack", self.camera, "-o", blob)
        points = write(self.path("xyz.csv"), "x,y,z\n0,0,1\n")
        pixels = write(self.path("px.csv"), "x,y\n80,60\n")
        image = write(self.path("white/a.pgm"), b"P5\n160 120\n255\n" + b"\xff" * 19200)
        out = ["-o", self.path("printed")]
        values = {"CAMERA": self.camera, "FIRST": self.camera, "SECOND": self.camera, "FILE": blob, "FILES": blob,
                  "IMAGES": image, "--points": points, "--pixels": pixels, "--model": "opencv", "--output": out[1],
                  "--features": self.path("sim/features.csv"), "--pattern": self.path("sim/pattern.yaml")}
        # These print nothing, or need more than their help requires.
        silent = {"calibrate", "capture", "check", "detect", "export", "import"}
        special = [["inspect", self.camera], ["experiment", "--list"], ["view", blob, "-o", self.path("sheet.png")],
                   ["fit", self.camera, "--model", "opencv", "-o", self.path("fit.yaml")],
                   ["localize", self.camera, "--features", values["--features"], "--pattern", values["--pattern"], *out],
                   ["pack", self.camera, "-o", blob], ["simulate", "--images", 2, *out],
                   ["pattern", "chessboard", "--columns", 4, "--rows", 3, "--square-mm", 20, "--dpi", 30, *out]]
        others = set(commands()) - silent - {words[0] for words in special[1:]}
        for command in [*special, *(call(values.get, name) for name in sorted(others))]:
            if command:
                self.assert_cannot_print("> /dev/full", *command)
        for more in ([], ["--json"]):
            self.assert_cannot_print(">&-", "inspect", self.camera, *more)
            self.assert_cannot_print("> /dev/full", "pack", self.camera, "-o", blob, *more)

    def assert_cannot_print(self, how, *command):
        lost = subprocess.run(["sh", "-c", f'"$@" {how}', "sh", programs.raygrid,
                               *map(str, command)], capture_output=True, text=True, check=False)
        self.assert_refused(lost, 7, "standard output")


if __name__ == "__main__":
    main(__name__)
