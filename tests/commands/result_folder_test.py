#!/usr/bin/env python3
"""The files that calibrate writes are one unit: nothing of an earlier result is left in its folder."""
import os
import re

from command_test import CommandTest, SIMULATED_PATTERN, main, read, run, write

FILES = {"camera.raygrid", "camera.yaml", "features.csv", "pattern.yaml", "poses.csv",
         "report.html", "residuals.csv", "result.json", "uncertainty.png",
         "view.camera.yaml"}


class ResultFolder(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        board = write(cls.path("board.yaml"), SIMULATED_PATTERN)
        cls.succeed("simulate", "--images", 6, "--features-per-image", 40, "--lens", "wide",
                    "--size", "320x240", "--pattern", board, "-o", cls.path("sim"))

    def calibrate(self, output, features="sim/features.csv", size="320x240"):
        """Which files are written is the question: the cheapest camera will do."""
        return run("calibrate", "--features", self.path(features), "--image-size", size,
                   "--pattern", self.path("sim/pattern.yaml"), "--model", "opencv",
                   "--skip-comparison", "--fix-target-geometry", "--hold-out", "sim0001.png", "--allow-huge-images", "-o",
                   self.path(output))

    def test_files_of_an_earlier_result_go_and_those_of_others_stay(self):
        output = self.path("stale")
        for name in ("example_before.png", "example_after.png", "thumbnails.json", "resume.json",
                     "left/camera.yaml", "left/camera.raygrid", "left/report.html",
                     "right/camera.yaml"):
            write(os.path.join(output, name), "of an earlier result")
        identity = ("camera_from_rig: {rotation: {w: 1, x: 0, y: 0, z: 0}, "
                    "translation: {x: 0, y: 0, z: 0}}")
        write(os.path.join(output, "rig.yaml"), "raygrid_rig: 1\ncameras:\n" + "".join(
            f"  {name}: {{file: {name}/camera.yaml, {identity}}}\n" for name in ("left", "right")))
        write(os.path.join(output, "notes.txt"), "mine")
        write(os.path.join(output, "right/notes.txt"), "mine")
        self.assert_done(self.calibrate("stale"))
        self.assertEqual(set(os.listdir(output)), FILES | {"notes.txt", "right"})
        self.assertEqual(os.listdir(os.path.join(output, "right")), ["notes.txt"])
        self.assertEqual(read(os.path.join(output, "notes.txt")), b"mine")
        self.succeed("report", output)

    def test_no_blob_of_another_camera_stays_where_there_is_none_of_this_one(self):
        self.assert_done(self.calibrate("unpacked"))
        # The first camera with pixels so small that no blob can say how many there are.
        large = re.sub(r"([\d.]+),([\d.]+)$",
                       lambda match: "%.4f,%.4f" % tuple(80 * float(x) for x in match.groups()),
                       read(self.path("sim/features.csv")).decode(), flags=re.MULTILINE)
        write(self.path("large.csv"), large)
        result = self.calibrate("unpacked", "large.csv", "25600x19200")
        left = set(os.listdir(self.path("unpacked")))
        if b"25600" not in read(self.path("unpacked/camera.yaml")):
            self.fail("not calibrated: " + result.stderr)
        self.assertEqual(left, FILES - {"camera.raygrid", "view.camera.yaml"})

    def test_no_link_is_followed(self):
        output = self.path("links")
        os.makedirs(output)
        for name in FILES:
            write(self.path("mine/" + name), "mine")
            os.symlink("../mine/" + name, os.path.join(output, name))
        self.assert_done(self.calibrate("links"))
        for name in FILES:
            self.assertEqual(read(self.path("mine/" + name)), b"mine")
            self.assertFalse(os.path.islink(os.path.join(output, name)))

    def test_a_link_to_the_folder_stays(self):
        os.makedirs(self.path("real"))
        os.symlink("real", self.path("link"))
        self.assert_done(self.calibrate("link"))
        self.assertTrue(os.path.islink(self.path("link")))
        self.assertEqual(set(os.listdir(self.path("real"))), FILES)


if __name__ == "__main__":
    main(__name__)
