#!/usr/bin/env python3
"""Exit codes, which the help lists, and that nothing ends without one; what help looks like."""
import json
import os
import re
import resource
import subprocess

from command_test import (HANG_S, CommandTest, SIMULATED_PATTERN, commands, long_test, main, programs, read, run, specifications, write)

PAGE = os.path.join(os.path.dirname(__file__), "../../tools/README.md")


class Help(CommandTest):
    def help_of(self, command):
        result = self.succeed(*command, "--help")
        return result.stdout

    def test_exit_codes_are_in_the_main_help_alone(self):
        codes = re.findall(r"^  (\d)  ", self.help_of([]).split("Exit codes:")[1], re.MULTILINE)
        self.assertEqual(codes, list("012345678"))
        for name in commands():
            self.assertNotIn("Exit codes", self.help_of([name]), name)

    def test_commands_of_the_help_are_those_of_the_page(self):
        page = read(PAGE).decode().split("## Commands")[1].split("\n## ")[0]
        listed = re.findall(r"^- `([a-z-]+)`: ", page, re.MULTILINE)
        self.assertEqual(sorted({*commands(), "capture"}), sorted(listed))  # not all builds have capture

    def test_kinds_of_targets_are_on_the_page(self):
        self.assertEqual([word.split(":")[0] for word in specifications()], commands("pattern"))
        for word in specifications():
            self.assertIn(f"| `{word}` |", read(PAGE).decode())

    def test_help_is_short(self):
        """Lines of 80 characters, options of three lines, one example."""
        for command in [[]] + [[name] for name in commands()] + [["pattern", kind] for kind in commands("pattern")]:
            text = self.help_of(command)
            self.assertLessEqual(max(map(len, text.splitlines())), 80, command)
            options = text.split("\nExample:")[0]
            for entry in re.findall(r"^  -.*\n(?:   .*\n)*", options, re.MULTILINE):
                self.assertLessEqual(entry.count("\n"), 3, (command, entry))
            if command:
                self.assertEqual(text.count("\n  raygrid " + command[0]), 1, command)


class FormerNames(CommandTest):
    def test_renamed_options_keep_their_former_names(self):
        words = ["calibrate", "--features", "none.csv", "--image-size", "640x480", "--pattern",
                 "chessboard:9x6:25mm", "-o", self.path("never")]
        for old, new in (("--flat-board", "--fix-target-geometry"), ("--like=none.yaml", "--prior=none.yaml"),
                         ("--same-view-px=x", "--duplicate-px=x"), ("--huge", "--allow-huge-images")):
            results = [run(*words, option) for option in (old, new)]
            self.assertEqual(results[0].returncode, results[1].returncode)
            self.assertEqual(results[0].stderr, results[1].stderr)
            self.assertNotIn("not expected", results[0].stderr)
            self.assertNotIn(old.split("=")[0] + " ", run("calibrate", "--help").stdout)
        self.assert_refused(run(*words, "--flat-boards"), 1, "--flat-boards")


class MisspeltCommands(CommandTest):
    def test_the_nearest_command_is_named(self):
        for word, meant in (("localise", "localize"), ("calibrat", "calibrate"), ("undistrot", "undistort"),
                            ("inspec", "inspect"), ("udpate", "update")):
            self.assert_refused(run(word), 1, f"did you mean {meant}?")

    def test_words_like_no_command_get_the_help(self):
        for word in ("xyz", "camera.yaml", "v", ""):
            self.assert_refused(run(word, "--help"), 1, "raygrid --help")


class Verdicts(CommandTest):
    """Held flat, a curved board explains nothing."""
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.board = write(cls.path("board.yaml"), SIMULATED_PATTERN)

    def calibrate(self, *simulation):
        folder = self.path(self.id())
        self.succeed("simulate", "--images", 8, "--features-per-image", 60, "--pattern",
                     self.board, *simulation, "-o", folder)
        self.out = folder + "-out"
        return run("calibrate", "--features", folder + "/features.csv", "--image-size", "640x480",
                   "--pattern", folder + "/pattern.yaml", "--knot-spacing-px", 160, "--skip-comparison",
                   "--fix-target-geometry", "--quiet", "-o", self.out)

    def result(self):
        return json.loads(read(self.out + "/result.json"))

    def test_a_camera_that_fails_is_written_and_ends_in_6(self):
        result = self.calibrate("--target-deformation-mm", 40)
        self.assert_refused(result, 6, "verdict: fail")
        self.assertEqual(self.result()["verdict"], "fail")
        self.assertTrue(any(reason in result.stderr for reason in self.result()["reasons"]))
        self.assertLessEqual({"camera.yaml", "report.html", "pattern.yaml"},
                             set(os.listdir(self.out)))
        # Who goes on with it is told.
        result = run("pack", self.out + "/camera.yaml", "-o", self.path("failed.raygrid"))
        self.assertIn("camera.yaml: its calibration has verdict fail", result.stderr)
        image = write(self.path("i/x.pgm"), b"P5 640 480 255\n" + bytes(640 * 480))
        result = run("undistort", self.out + "/camera.yaml", image, "-o", self.path("o"))
        self.assertIn("camera.yaml: its calibration has verdict fail", result.stderr)

    def test_a_rig_that_fails_is_written_and_ends_in_6(self):
        result = self.calibrate("--target-deformation-mm", 60, "--cameras", 2)
        self.assert_refused(result, 6, "verdict: fail")
        self.assertEqual(self.result()["verdict"], "fail")
        self.assertTrue(any(reason in result.stderr for reason in self.result()["reasons"]))
        self.assertLessEqual({"rig.yaml", "report.html", "cam0", "cam1"},
                             set(os.listdir(self.out)))

    def test_a_verdict_of_warn_ends_in_0(self):
        self.assert_done(self.calibrate())
        self.assertEqual(self.result()["verdict"], "warn")


class CamerasThatNoBlobHolds(CommandTest):
    """They are cameras all the same."""
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.board = write(cls.path("board.yaml"), SIMULATED_PATTERN)

    def calibrate(self, features, size, *more):
        self.out = self.path(self.id())
        write(self.out + "/camera.raygrid", b"of an earlier calibration")
        hold_out = () if "--hold-out" in more else ("--hold-out", "sim0007.png")
        return run("calibrate", "--features", features, "--image-size", size, "--pattern",
                   self.board, "--skip-comparison", "--fix-target-geometry", *hold_out, "-o", self.out,
                   *more)

    def simulate(self, *arguments):
        folder = self.path(self.id() + "-seen")
        images = () if "--images" in arguments else ("--images", 8)
        self.succeed("simulate", *images, "--features-per-image", 60, "--pattern",
                     self.board, *arguments, "-o", folder)
        return folder + "/features.csv"

    def check_files(self, *words):
        """A camera and a report; what the blob lacks stands in both files."""
        self.succeed("inspect", self.out + "/camera.yaml")
        remark = json.loads(read(self.out + "/result.json"))["packing"]["warnings"][-1]
        report = read(self.out + "/report.html").decode()
        for word in words:
            self.assertIn(word, remark)
            self.assertIn(word, report)

    def test_image_larger_than_a_blob_can_say(self):
        result = self.calibrate(self.simulate("--size", "20000x15000", "--lens", "pinhole", "--allow-huge-images"),
                                "20000x15000", "--model", "opencv", "--allow-huge-images")
        self.assertEqual(result.returncode, 6, result.stderr)
        for words in ("camera.raygrid is omitted", "16384", "other files were written"):
            self.assertIn(words, result.stderr)
        self.check_files("is omitted", "16384")
        self.assertNotIn("camera.raygrid", os.listdir(self.out))

    @long_test
    def test_image_as_large_as_images_may_be(self):
        size = "16384x16384"
        features = self.simulate("--size", size, "--lens", "pinhole")
        result = self.calibrate(features, size, "--model", "opencv")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("no undistortion table", result.stderr)
        self.check_files("no undistortion table", "8192")
        self.succeed("inspect", self.out + "/camera.raygrid")

    def test_camera_that_looks_back(self):
        """240 degrees from the left edge to the right one, 300 from corner to corner."""
        lens = write(self.path("240.yaml"), """raygrid_camera: 1
model: thin-prism-fisheye
image_size: [640, 480]
area: [-0.5, -0.5, 639.5, 479.5]
parameters: {fx: 152.8, fy: 152.8, cx: 319.5, cy: 239.5, k1: 0, k2: 0, k3: 0, k4: 0, p1: 0, p2: 0,
  sx1: 0, sy1: 0}
""")
        features = self.simulate("--camera", lens, "--images", 40)
        result = self.calibrate(features, "640x480", "--model", "thin-prism-fisheye")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.succeed("inspect", self.out + "/camera.raygrid")
        result = self.calibrate(features, "640x480", "--knot-spacing-px", 160)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.succeed("inspect", self.out + "/camera.raygrid")
        for camera in (lens, self.out + "/camera.yaml"):
            result = self.succeed("pack", camera, "-o", self.path("240.raygrid"), "--json")
            self.assertLess(json.loads(result.stdout)["uncovered_fraction"], 0.3)

    def test_one_view_many_times(self):
        lines = read(self.simulate()).decode().splitlines()
        first = [line.split(",") for line in lines[1:] if line.startswith("sim0000")]
        features = write(self.path("alike.csv"), "\n".join(lines[:1] + [
            ",".join([f"view{k}.png", *line[1:4], str(float(line[4]) + 0.01 * k), line[5]])
            for k in range(6) for line in first]) + "\n")
        result = self.calibrate(features, "640x480", "--knot-spacing-px", 160, "--quiet", "--hold-out",
                                "view5.png")
        self.assert_refused(result, 6, "verdict: fail")
        self.succeed("inspect", self.out + "/camera.yaml")
        self.assertTrue(os.path.exists(self.out + "/report.html"))

    def test_name_longer_than_a_blob_can_hold_is_refused_before_work(self):
        result = run("calibrate", "--features", self.simulate(), "--image-size", "640x480",
                     "--pattern", self.board, "--name", "x" * 32, "-o", self.path("unnamed"))
        self.assert_refused(result, 1, "--name", "31 bytes")
        self.assertFalse(os.path.exists(self.path("unnamed")))


class Ends(CommandTest):
    """Without threads, without standard output: no abort."""
    def test_threads_that_cannot_be_made(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_STACK, (1 << 30, 1 << 30))
            resource.setrlimit(resource.RLIMIT_AS, (3 << 29, 3 << 29))

        self.succeed("simulate", "--images", 4, "--features-per-image", 60, "-o",
                     self.path("sim"))
        blob = self.path("front.raygrid")
        with subprocess.Popen([programs.raygrid, "pack", self.path("sim/true_camera.yaml"), "-o",
                               blob, "--threads", "8"], stderr=subprocess.PIPE,
                              stdout=subprocess.PIPE, preexec_fn=limit) as process:
            error = process.communicate(timeout=HANG_S)[1]
        self.assertEqual(process.returncode, 0, error)
        self.succeed("inspect", blob)

    def test_nothing_to_print_on(self):
        for arguments, codes in ((["inspect", self.path("missing.yaml")], {2}),
                                 (["pattern", "chessboard", "--columns", "9", "--rows", "6",
                                   "--square-mm", "20", "-o", self.path("board")], {0, 7})):
            with subprocess.Popen([programs.raygrid, *arguments], stdin=subprocess.DEVNULL,
                                  preexec_fn=lambda: (os.close(1), os.close(2))) as process:
                self.assertIn(process.wait(timeout=HANG_S), codes, arguments)
        self.succeed("inspect", self.path("board/pattern.yaml"))

    def test_points_of_any_length_are_projected(self):
        self.succeed("simulate", "--images", 4, "--features-per-image", 60, "-o",
                     self.path("seen"))
        camera, blob = self.path("seen/true_camera.yaml"), self.path("seen.raygrid")
        self.succeed("pack", camera, "-o", blob)
        scales = ("", "e154", "e300", "e-160", "e-300")
        points = write(self.path("xyz.csv"), "x,y,z\n" + "".join(
            f"1{e},-2{e},9{e}\n" for e in scales) + "-1e300,2e300,-9e300\n")
        for name in (camera, blob):
            rows = json.loads(run("project", name, "--points", points, "--json").stdout)
            for row in rows[:-1]:
                self.assertIs(row["valid"], True)
                self.assertAlmostEqual(row["u"], rows[0]["u"], places=6)
                self.assertAlmostEqual(row["v"], rows[0]["v"], places=6)
            self.assertIs(rows[-1]["valid"], False)


if __name__ == "__main__":
    main(__name__)
