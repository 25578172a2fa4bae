#!/usr/bin/env python3
"""Exit codes: what README.md says of them, and what a calibration ends with."""
import json
import os
import re

from command_test import CommandTest, SIMULATED_PATTERN, main, read, run, write

README = os.path.join(os.path.dirname(__file__), "../../README.md")
COMMANDS = ("calibrate", "check", "compare", "detect", "evaluate", "experiment", "fit", "inspect",
            "pack", "pattern", "project", "report", "simulate", "undistort", "unproject")
KINDS = ("star", "chessboard", "charuco", "aprilgrid")


class HelpAndReadme(CommandTest):
    def test_every_command_names_the_codes_of_the_readme(self):
        readme = read(README).decode()
        table = dict(re.findall(r"^\| (\d) \| (.*) \|$", readme, re.MULTILINE))
        self.assertEqual(sorted(table), list("012345678"))
        listed = re.findall(r"^\| ([`a-z, ]+) \|", readme.split("## Commands")[1], re.MULTILINE)
        self.assertLessEqual(set(re.findall(r"`(\w+)", " ".join(listed))) - set(KINDS),
                             set(COMMANDS))
        for command in [[]] + [[name] for name in COMMANDS] + [["pattern", kind] for kind in KINDS]:
            result = run(*command, "--help")
            self.assert_done(result)
            words = " ".join(result.stdout.split("Exit codes:")[1].split())
            self.assertEqual(words, " ".join(f"{code} {table[code]}" for code in sorted(table))
                             .replace("`", ""), command)


class Verdicts(CommandTest):
    """Held flat, a curved board explains nothing."""
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.board = write(cls.path("board.yaml"), SIMULATED_PATTERN)

    def calibrate(self, *simulation):
        folder = self.path(self.id())
        self.assert_done(run("simulate", "--images", 8, "--features-per-image", 60, "--pattern",
                             self.board, *simulation, "-o", folder))
        self.out = folder + "-out"
        return run("calibrate", "--features", folder + "/features.csv", "--image-size", "640x480",
                   "--pattern", folder + "/pattern.yaml", "--cell-px", 160, "--skip-comparison",
                   "--flat-board", "--quiet", "-o", self.out)

    def result(self):
        return json.loads(read(self.out + "/result.json"))

    def test_a_camera_that_fails_is_written_and_ends_in_6(self):
        result = self.calibrate("--board-bend-mm", 40)
        self.assert_refused(result, 6, "verdict: fail")
        self.assertEqual(self.result()["verdict"], "fail")
        self.assertTrue(any(reason in result.stderr for reason in self.result()["reasons"]))
        self.assertLessEqual({"camera.yaml", "report.html", "pattern.yaml"},
                             set(os.listdir(self.out)))

    def test_a_rig_that_fails_is_written_and_ends_in_6(self):
        result = self.calibrate("--board-bend-mm", 60, "--cameras", 2)
        self.assert_refused(result, 6, "verdict: fail")
        self.assertEqual(self.result()["verdict"], "fail")
        self.assertTrue(any(reason in result.stderr for reason in self.result()["reasons"]))
        self.assertLessEqual({"rig.yaml", "report.html", "cam0", "cam1"},
                             set(os.listdir(self.out)))

    def test_a_verdict_of_warn_ends_in_0(self):
        self.assert_done(self.calibrate())
        self.assertEqual(self.result()["verdict"], "warn")


if __name__ == "__main__":
    main(__name__)
