#!/usr/bin/env python3
"""The sheet of view: cameras, their views, and what it says of those it cannot show."""
import json
import os
import re
import struct
import subprocess

from command_test import CommandTest, main, programs, read, run, write
from images_test import png, read_png


class Sheets(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.camera = cls.simulated_camera("wide")
        cls.blob = cls.path("front.raygrid")
        cls.succeed("pack", cls.camera, "--remap", "160x120,hfov=60", "--remap",
                    "200x100,projection=cylindrical,hfov=90,rotate=10,0,0", "--max-error-px",
                    0.25, "-o", cls.blob)
        cls.image = write(cls.path("in/white.png"), png([255] * (160 * 120), size=(160, 120)))
        cls.other = write(cls.path("in/other.png"), png([255] * (80 * 60), size=(80, 60)))

    def view(self, *arguments, output="sheet.png"):
        return run("view", *arguments, "-o", self.path(output))

    def size(self, output="sheet.png"):
        return struct.unpack(">II", read(self.path(output))[16:24])

    def told(self, *arguments):
        result = self.view(*arguments, "--json")
        self.assert_done(result)
        self.assertEqual(result.stderr, "")
        told = json.loads(result.stdout)
        self.assertEqual(tuple(told["size"]), self.size())
        self.assertLessEqual(told["size"][0], 2400)
        return told["files"]

    def test_a_row_has_the_camera_and_its_views(self):
        rows = self.told(self.blob, self.camera, self.path("front.1.camera.yaml"))
        self.assertEqual([len(row["views"]) for row in rows], [2, 1, 1])
        self.assertEqual([view["projection"] for view in rows[0]["views"]],
                         ["pinhole", "cylindrical"])
        # A view's file is that view; a camera.yaml has the size of its images.
        for key in ("projection", "size"):
            self.assertEqual(rows[2]["views"][0][key], rows[0]["views"][1][key])
        self.assertEqual(rows[1]["views"][0]["size"], [160, 120])
        higher = self.size()[1]
        self.told(self.blob)
        self.assertLess(self.size()[1], higher)

    def test_views_can_be_asked_for_and_a_blob_need_have_none(self):
        bare = self.path("bare.raygrid")
        self.succeed("pack", self.camera, "-o", bare)
        self.assertEqual(self.told(bare)[0]["views"][0]["size"], [160, 120])
        row, = self.told(self.blob, "--remap", "90x70,hfov=50", "--max-error-px", 0.25)
        self.assertEqual([view["size"] for view in row["views"]], [[90, 70]])

    def test_photographs_are_shown(self):
        row, = self.told(self.blob, "--image", self.image)
        self.assertEqual(row["image"], self.image)
        channels, bits, samples = read_png(self.path("sheet.png"))
        self.assertEqual((channels, bits), (3, 8))
        white = read(self.path("sheet.png"))
        self.told(self.blob)
        self.assertNotEqual(read(self.path("sheet.png")), white)
        self.assertGreater(samples.count(255), len(samples) / 3)
        # A photograph for each file, or one for all.
        self.told(self.blob, self.camera, "--image", self.image, "--image", self.image)
        self.assert_refused(self.view(self.blob, self.blob, self.blob, "--image", self.image,
                                      "--image", self.image), 1, "2 images", "3 files")

    def test_the_same_bytes_come_with_any_number_of_threads(self):
        self.assert_done(self.view(self.camera, "--threads", 1, output="one.png"))
        self.assert_done(self.view(self.camera, "--threads", 3, output="three.png"))
        self.assertEqual(read(self.path("one.png")), read(self.path("three.png")))

    def test_a_camera_that_has_no_view_has_a_tile_that_says_so(self):
        self.succeed("simulate", "--images", 3, "--lens", "fisheye190", "--size",
                     "160x120", "-o", self.path("round"))
        self.succeed("fit", self.path("round/true_camera.yaml"), "--model",
                     "thin-prism-fisheye", "-o", self.path("round.yaml"))
        # Only the rim is calibrated, which no pinhole shows.
        text = read(self.path("round.yaml")).decode()
        rim = write(self.path("rim.yaml"), re.sub("area: .*", "area: [0, 50, 10, 70]", text))
        row, = self.told(rim)
        self.assertEqual(row["views"], [])
        self.assertIn("does not overlap", row["view_error"])

    def test_the_sheet_has_a_name_of_its_own(self):
        os.makedirs(self.path("here"), exist_ok=True)
        result = subprocess.run([os.path.abspath(programs.raygrid), "view", self.blob], cwd=self.path("here"),
                                capture_output=True, text=True, check=False)
        self.assert_done(result)
        self.assertEqual(os.listdir(self.path("here")), ["sheet.png"])

    def test_what_cannot_be_shown_is_refused_in_a_line(self):
        for arguments, code, words in (
                ([self.path("none.raygrid")], 2, ("none.raygrid",)),
                ([self.blob, "--image", self.path("none.png")], 2, ("none.png",)),
                ([self.blob, "--image", self.other], 8, ("other.png", "80 x 60", "160 x 120")),
                ([self.path("front.0.camera.yaml"), "--image", self.other], 8, ("160 x 120",)),
                ([self.path("board.yaml")], 2, ("board.yaml",)),
                ([self.camera, "--remap", "hfov=500"], 1, ("hfov",)),
                ([self.camera, "--remap", "80x60,hfov=40,rotate=180,0,0"], 1, ("does not overlap",)),
                ([], 1, ("files",))):
            with self.subTest(arguments):
                self.assert_refused(self.view(*arguments, output="never.png"), code, *words)
                self.assertFalse(os.path.exists(self.path("never.png")))
        camera = write(self.path("own/camera.yaml"), read(self.camera))
        self.assert_refused(run("view", camera, "-o", camera), 7, "overwrite the input")
        self.assert_refused(run("view", camera, "-o", "/dev/null/sheet.png"), 7)
        self.assertEqual(read(camera), read(self.camera))


if __name__ == "__main__":
    main(__name__)
