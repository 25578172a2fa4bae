#!/usr/bin/env python3
"""tools/measure_readme --images: the table of held-out errors for a folder of images."""
import csv
import os
import shutil
import subprocess
import unittest

from command_test import CommandTest, main, programs, run

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
PYTHON = "/usr/bin/python3"  # which the tool calls, too
HAS_PEERS = subprocess.run([PYTHON, "-c", "import cv2, mrcal"], capture_output=True, check=False).returncode == 0
PATTERN = "chessboard:6x5:30mm"
# With some of the detectors and models, which saves time.
SCRIPT = """import sys
sys.path.insert(0, sys.argv.pop(1))
import images, main, raygrid_peer
raygrid_peer.FEW_MODELS = ("central-generic", "opencv")
images.DETECTORS["chessboard"] = {k: images.DETECTORS["chessboard"][k] for k in ("sub-pix-5", "raygrid")}
main.main()
"""


@unittest.skipUnless(HAS_PEERS, "no python3-opencv or python3-mrcal; 'tools/install_packages peers' installs them")
class Images(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.images = cls.path("photos")
        cls.succeed("simulate", "--images", 16, "--render", "--lens", "pinhole", "--pattern", PATTERN,
                    "--samples-per-pixel", 2, "--min-square-px", 14, "--max-square-px", 18, "--max-tilt-deg", 30,
                    "-o", cls.path("sim"))
        os.makedirs(cls.images)
        for folder, _, names in os.walk(cls.path("sim")):
            for name in names:
                if name.endswith(".png"):
                    shutil.copy(os.path.join(folder, name), cls.images)

    def measure(self, images, pattern):
        arguments = ["--remap-bench", "", "--photographs", "", "--data", "", "--output", "", "--few"]
        return run("-B", "-c", SCRIPT, os.path.join(ROOT, "tools", "measure"), "--raygrid", programs.raygrid, "--work",
                   self.path("work"), *arguments, "--images", images, "--pattern", pattern, program=PYTHON)

    def test_table_has_all_programs_with_all_corners(self):
        result = self.measure(self.images, PATTERN)
        self.assert_done(result)
        lines = [line.split("  ") for line in result.stdout.splitlines()]
        labels = {line[0] for line in lines}
        self.assertIn("cornerSubPix, 11 px", result.stdout)
        self.assertIn("raygrid central-generic, noncentral-generic", labels, result.stdout)
        with open(self.path("work/images/accuracy.csv"), encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        for name in ("sub-pix-5", "raygrid"):
            found = [row for row in rows if row["set"] == name]
            self.assertEqual({row["program"] for row in found}, {"raygrid", "OpenCV", "mrcal"})
            medians = [float(row["median_px"]) for row in found if row["median_px"]]
            self.assertGreater(len(medians), 7, found)
            self.assertLess(min(medians), 0.1)
        corners = {row["corners"] for row in rows if row["program"] == "OpenCV" and row["corners"]}
        self.assertEqual(len(corners), 1, "all detectors have the same held-out corners")

    def test_errors_take_one_line(self):
        few = self.path("few")
        os.makedirs(few)
        for name in sorted(os.listdir(self.images))[:3]:
            shutil.copy(os.path.join(self.images, name), few)
        self.assert_refused(self.measure(few, PATTERN), 1, "images show the pattern", "at least 10")
        self.assert_refused(self.measure(few, "chessboard:7"), 1, "chessboard:7")
        self.assert_refused(self.measure(few, "aprilgrid:6x6:24mm"), 1, "aprilgrid", "ChArUco")

    def test_script_checks_its_arguments(self):
        script = os.path.join(ROOT, "tools", "measure_readme")
        for arguments, word in ((("--images", self.images), "--pattern"),
                                (("--images", self.path("nowhere"), "--pattern", PATTERN), "no such folder"),
                                (("--images",), "missing value")):
            self.assert_refused(run(*arguments, program=script), 1, word)
        self.assertIn("--images DIR", run("--help", program=script).stdout)


if __name__ == "__main__":
    main(__name__)
