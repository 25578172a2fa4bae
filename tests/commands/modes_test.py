#!/usr/bin/env python3
"""Sensor modes: tables for frames of other modes than the calibrated one, in one blob."""
import json
import os

from command_test import CommandTest, main, run, write
from images_test import png, read_png


def grey(width, height):
    """A picture that rises to the right and downwards."""
    return [100 + x * 100 // width + y * 50 // height for y in range(height) for x in range(width)]


class Modes(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.camera = cls.simulated_camera("wide")
        cls.lines = cls.simulated_camera("noncentral", "320x240")
        pixels = grey(160, 120)
        write(cls.path("in/whole.png"), png(pixels, size=(160, 120)))
        crop = [pixels[160 * (30 + y) + 40 + x] for y in range(60) for x in range(80)]
        write(cls.path("in/crop.png"), png(crop, size=(80, 60)))
        write(cls.path("in/turned.png"), png(crop[::-1], size=(80, 60)))

    def pack(self, *options, output="c.raygrid"):
        return run("pack", self.camera, *options, "--json", "--max-error-px", 0.25,
                   "-o", self.path(output))

    def test_pack_adds_tables_of_modes(self):
        result = self.pack("--remap", "100x80", "--mode", "mid:crop=40,30,80,60", "--mode",
                           "half:bin=2,flip=h")
        self.assert_done(result)
        told = json.loads(result.stdout)["remaps"]
        self.assertEqual([table.get("mode") for table in told], [None, "mid", "half"])
        self.assertEqual(len([name for name in os.listdir(self.path("."))
                              if name.startswith("c.") and name.endswith(".camera.yaml")]), 3)
        inspected = json.loads(run("inspect", self.path("c.raygrid"), "--json").stdout)
        self.assertEqual(inspected["format_version"], "1.5")
        self.assertEqual(inspected["modes"], [
            {"name": "mid", "size": [80, 60], "offset_px": [40, 30], "scale": [1, 1],
             "flip_x": False, "flip_y": False},
            {"name": "half", "size": [80, 60], "offset_px": [0, 0], "scale": [2, 2],
             "flip_x": True, "flip_y": False}])
        self.assertEqual([table.get("mode") for table in inspected["remap_tables"]],
                         [None, "mid", "half"])

    def test_frames_of_a_mode_look_as_the_calibrated_ones(self):
        """A crop, upright or turned, becomes the same part of the view as the whole image."""
        self.assert_done(self.pack("--remap", "100x80,focal=60", "--mode", "mid:crop=40,30,80,60",
                                   "--mode", "turned:crop=40,30,80,60,rotate=180",
                                   output="same/c.raygrid"))
        blob = self.path("same/c.raygrid")
        for mode, image in (("mid", "crop"), ("turned", "turned")):
            self.succeed("undistort", blob, self.path(f"in/{image}.png"), "--mode", mode,
                         "--frames", self.path("raw"), "-o", self.path(f"of_{mode}"))
        self.succeed("undistort", blob, self.path("in/whole.png"), "-o",
                     self.path("of_whole"))
        whole, mid, turned = (self.levels(f"of_{name}/{image}.png") for name, image in (
            ("whole", "whole"), ("mid", "crop"), ("turned", "turned")))
        seen = [k for k, level in enumerate(mid) if level]
        self.assertGreater(len(seen), 2000)
        self.assertLess(max(abs(whole[k] - mid[k]) for k in seen), 2)
        self.assertLess(max(abs(turned[k] - mid[k]) for k in seen if turned[k]), 2)
        # The camera itself gives the same.
        self.succeed("undistort", self.camera, self.path("in/crop.png"), "--size",
                     "100x80", "--focal", 60, "--mode", "any:crop=40,30,80,60",
                     "--max-error-px", 0.25, "-o", self.path("of_camera"))
        self.assertEqual(self.levels("of_camera/crop.png"), mid)

    def levels(self, name):
        return read_png(self.path(name))[2]

    def test_a_table_of_the_other_direction_leads_back(self):
        """What one table undistorts, the other makes an image of the camera again."""
        view = "200x150,focal=60"
        self.succeed("pack", self.camera, "--remap", view, "--remap",
                     view + ",direction=distort", "--max-error-px", 1, "-o",
                     self.path("both/c.raygrid"))
        blob = self.path("both/c.raygrid")
        told = json.loads(run("inspect", blob, "--json").stdout)["remap_tables"]
        self.assertEqual([table.get("direction") for table in told], [None, "distort"])
        self.assertEqual([table["size"] for table in told], [[200, 150]] * 2)
        self.succeed("undistort", blob, self.path("in/whole.png"), "-o",
                     self.path("there"))
        back = ("undistort", blob, self.path("there/whole.png"), "-o", self.path("back"))
        self.assert_refused(run(*back, "--remap-index", 1), 1, "inverse remap", "--inverse")
        self.assert_refused(run("undistort", blob, self.path("in/whole.png"), "--remap-index", 1,
                                "--inverse", "-o", self.path("back")), 8, "200 x 150",
                            "undistorted images of this size")
        self.succeed(*back, "--remap-index", 1, "--inverse")
        # The table of the other direction says the view, and each pixel is found exactly.
        self.succeed(*back[:-1], self.path("exact"), "--inverse")
        table, exact = (self.levels(f"{name}/whole.png") for name in ("back", "exact"))
        middle = [k for k in range(160 * 120) if 40 < k % 160 < 120 and 30 < k // 160 < 90]
        self.assertLess(max(abs(table[k] - exact[k]) for k in middle), 3)
        before, after = self.levels("in/whole.png"), self.levels("back/whole.png")
        inside = [k for k in range(160 * 120) if 20 < k % 160 < 140 and 15 < k // 160 < 105]
        self.assertLess(max(abs(before[k] - after[k]) for k in inside), 3)
        result = self.pack("--remap", "100x80,direction=up", output="no/c.raygrid")
        self.assert_refused(result, 1, "undistort or distort", "up")

    def test_tables_of_lines_may_be_for_a_scene(self):
        for scene in ("at=0.4", "plane=0,0,1,0.4"):
            result = self.succeed("pack", self.lines, "--remap", "160x120,hfov=60," + scene, "--json",
                                  "--max-error-px", 0.25, "-o", self.path("scene/c.raygrid"))
            table = json.loads(result.stdout)["remaps"][0]
            self.assertGreater(table["far_error_px"], 0.05)
            self.assertLess(table["error_px"], 0.25)
        for scene, words in (("at=0", ("positive",)), ("at=-1", ("positive",)),
                             ("plane=0,0,0,1", ("non-zero",)), ("plane=0,0,1", ("four numbers",)),
                             ("at=1,plane=0,0,1,1", ("mutually exclusive",))):
            result = run("pack", self.lines, "--remap", "160x120," + scene, "-o",
                         self.path("no/c.raygrid"))
            self.assert_refused(result, 1, *words)
        self.assert_refused(self.pack("--remap", "100x80,at=1", output="no/c.raygrid"), 1,
                            "non-central", "omit them")

    def test_frames_of_another_size_are_refused_with_a_way_out(self):
        self.assert_done(self.pack("--remap", "100x80", output="one/c.raygrid"))
        result = run("undistort", self.path("one/c.raygrid"), self.path("in/crop.png"), "-o",
                     self.path("none"))
        self.assert_refused(result, 8, "80 x 60", "160 x 120", "--mode")
        result = run("undistort", self.path("one/c.raygrid"), self.path("in/crop.png"), "--mode",
                     "mid", "-o", self.path("none"))
        self.assert_refused(result, 8, "mid", "raygrid pack --mode")

    def test_impossible_modes_are_refused_in_a_line(self):
        for mode, words in (("half", ("NAME:",)), (":bin=2", ("NAME:",)),
                            ("a:bin=0", ("bin", "1 to 64")), ("a:bin=1.5", ("integer",)),
                            ("a:bin=2,scale=0.5", ("mutually exclusive",)),
                            ("a:crop=100,0,80,60", ("within", "160 x 120")),
                            ("a:crop=1,2,3", ("four numbers, such as 320,180,640,360",)), ("a:crop=0,0,1,1", ("2 x 2",)),
                            ("a:crop=nan,0,80,60", ("four numbers",)),
                            ("a:scale=0", ("scale",)), ("a:scale=0.01", ("1/64",)),
                            ("a:size=0x60", ("size",)), ("a:flip=x", ("h, v",)),
                            ("a:rotate=90", ("180", "not supported")), ("a:zoom=2", ("zoom=2",)),
                            ("a:bin=2,bin=2", ("twice",)), ("a:2", ("crop=",)),
                            ("a" * 32 + ":bin=2", ("31 bytes",))):
            self.assert_refused(self.pack("--mode", mode, output="no/c.raygrid"), 1, *words)
        self.assert_refused(self.pack("--mode", "a:bin=2", "--mode", "a:bin=4",
                                      output="no/c.raygrid"), 1, "duplicate name")
        many = [word for k in range(11) for word in ("--mode", f"m{k}:bin=2")]
        self.assert_refused(self.pack(*many, output="no/c.raygrid"), 1, "12 remap tables", "11")
        self.assertFalse(os.path.exists(self.path("no")))


if __name__ == "__main__":
    main(__name__)
