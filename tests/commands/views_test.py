#!/usr/bin/env python3
"""Views of undistorted images: what is asked for, and the camera file that tells K."""
import json
import math
import os

from command_test import CommandTest, main, read, run, write
from images_test import png, read_png


class Views(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.camera = cls.simulated_camera("wide")
        cls.image = write(cls.path("in/white.png"), png([255] * (160 * 120), size=(160, 120)))

    def pack(self, *remaps, output="c.raygrid"):
        remaps = [word for remap in remaps for word in ("--remap", remap)]
        return run("pack", self.camera, *remaps, "--json", "--max-error-px", 0.25,
                   "-o", self.path(output))

    def projected(self, camera, points):
        text = write(self.path("points.csv"), "x,y,z\n" + points)
        result = self.succeed("project", camera, "--points", text, "--json")
        return json.loads(result.stdout)

    def test_pack_tells_the_view_and_writes_it_as_a_camera(self):
        result = self.pack("200x100,hfov=80,vfov=50,center=90,55")
        self.assert_done(result)
        told = json.loads(result.stdout)["remaps"][0]
        self.assertEqual((told["size"], told["projection"]), ([200, 100], "pinhole"))
        self.assertAlmostEqual(told["hfov_deg"], 80, 6)
        self.assertAlmostEqual(told["vfov_deg"], 50, 6)
        (fx, _, cx), (_, fy, cy), _ = told["K"]
        self.assertEqual((cx, cy), (90, 55))
        seen = self.projected(self.path("c.camera.yaml"), "0.1,-0.2,2\n")[0]
        self.assertAlmostEqual(seen["u"], 90 + fx * 0.05, 6)
        self.assertAlmostEqual(seen["v"], 55 - fy * 0.1, 6)
        # The blob tells the same, as far as it holds it.
        inspected = json.loads(run("inspect", self.path("c.raygrid"), "--json").stdout)
        self.assertAlmostEqual(inspected["remap_tables"][0]["K"][1][1], fy, 4)

    def test_each_of_several_tables_has_a_file(self):
        self.assert_done(self.pack("100x80,alpha=0", "100x80,alpha=0.2", output="two/c.raygrid"))
        self.assertEqual(sorted(os.listdir(self.path("two"))),
                         ["c.0.camera.yaml", "c.1.camera.yaml", "c.raygrid"])
        self.assertNotEqual(read(self.path("two/c.0.camera.yaml")),
                            read(self.path("two/c.1.camera.yaml")))

    def test_a_view_like_another_is_that_view(self):
        self.assert_done(self.pack("100x80,alpha=0.3", output="like/a.raygrid"))
        self.assert_done(self.pack(f"view={self.path('like/a.camera.yaml')}",
                                   output="like/b.raygrid"))
        self.assertEqual(read(self.path("like/a.raygrid")), read(self.path("like/b.raygrid")))

    def test_a_view_of_another_projection_that_is_turned(self):
        result = self.pack("200x100,projection=cylindrical,hfov=120,rotate=30,-10,5",
                           output="round/c.raygrid")
        self.assert_done(result)
        told = json.loads(result.stdout)["remaps"][0]
        self.assertEqual(told["projection"], "cylindrical")
        self.assertAlmostEqual(told["hfov_deg"], 120, 6)
        self.assertAlmostEqual(told["K"][0][0], 200 / math.radians(120), 6)
        # The view looks 30 degrees right and 10 down.
        forward = [row[2] for row in told["camera_from_view"]]
        self.assertAlmostEqual(math.degrees(math.atan2(forward[0], forward[2])), 30, 6)
        self.assertAlmostEqual(math.degrees(math.asin(forward[1])), 10, 6)
        # The camera of a view has axes of its own; in them a cylinder's height grows with y.
        camera = self.path("round/c.camera.yaml")
        for a, b in ((0.3, 0.1), (-0.9, -0.4)):
            seen = self.projected(camera, f"{math.sin(a)},{b},{math.cos(a)}\n")[0]
            self.assertAlmostEqual(seen["u"], 99.5 + told["K"][0][0] * a, 6)
            self.assertAlmostEqual(seen["v"], 49.5 + told["K"][1][1] * b, 6)
        self.assertIn(b"camera_from_view", read(camera))
        self.assertEqual(json.loads(run("inspect", camera, "--json").stdout)["view_rotation_deg"],
                         {"right": 30, "up": -10, "clockwise": 5})
        self.assert_done(self.pack(f"view={camera}", output="round/d.raygrid"))
        self.assertEqual(read(self.path("round/c.raygrid")), read(self.path("round/d.raygrid")))
        inspected = json.loads(run("inspect", self.path("round/c.raygrid"), "--json").stdout)
        self.assertEqual((inspected["format_version"], inspected["remap_tables"][0]["projection"]),
                         ("1.5", "cylindrical"))
        result = self.succeed("undistort", self.path("round/c.raygrid"), self.image, "-o",
                              self.path("round/flat"))
        for words in ("cylindrical", "30 degrees right", "-10 up", "5 clockwise"):
            self.assertIn(words, result.stdout)

    def test_undistort_takes_the_same_words_and_tells_the_view(self):
        result = self.succeed("undistort", self.camera, self.image, "--alpha", 0, "--json",
                              "--max-error-px", 0.25, "-o",
                              self.path("flat"))
        told = json.loads(result.stdout)
        self.assertEqual(told["view"]["size"], [160, 120])
        self.assertEqual(sorted(os.listdir(self.path("flat"))), ["view.camera.yaml", "white.png"])
        self.assertEqual(told["view_file"], self.path("flat/view.camera.yaml"))
        # A blob's own table is told as it was when it was packed.
        self.assert_done(self.pack("100x80,focal=70"))
        result = self.succeed("undistort", self.path("c.raygrid"), self.image, "--json", "-o",
                              self.path("of_blob"))
        self.assertEqual(json.loads(result.stdout)["view"]["K"][0], [70, 0, 49.5])

    def test_nothing_is_shown_beyond_a_fisheyes_image_circle(self):
        folder = self.path("fisheye")
        self.succeed("simulate", "--render", "--lens", "fisheye", "--size", "320x240",
                     "--images", 9, "--image-circle", 130, "--samples-per-pixel", 3,
                     "--pattern", "chessboard:5x4:25mm", "--max-square-px", 16,
                     "-o", folder)

        def calibrate(output, *words):
            return run("calibrate", *words, "--pattern", folder + "/pattern.yaml", "--model",
                       "thin-prism-fisheye", "--skip-comparison", "--json", "-o",
                       self.path(output))

        def circle_of(result):
            self.assertIn(result.returncode, (0, 6), result.stderr)
            return json.loads(result.stdout).get("image_circle")

        found = circle_of(calibrate("auto", folder, "--no-refine-features"))
        for value, truth in zip(found["center_px"] + [found["radius_px"]], (159.5, 119.5, 130)):
            self.assertAlmostEqual(value, truth, delta=2)
        given = ("--features", folder + "/features.csv", "--image-size", "320x240")
        self.assertIsNone(circle_of(calibrate("none", *given)))
        told = circle_of(calibrate("told", *given, "--image-circle", "150,110.5,90"))
        self.assertEqual(told, {"center_px": [150.0, 110.5], "radius_px": 90.0})
        for word in ("150,110", "1,2,-3", "1,2,nan", "1,2,3,4", "no"):
            refused = calibrate("refused", *given, "--image-circle", word)
            self.assert_refused(refused, 1, "auto, none, or X,Y,RADIUS")

        white = write(self.path("fisheye_white.png"), png([255] * (320 * 240), size=(320, 240)))
        levels = {}
        for name in ("none", "told"):
            self.succeed("undistort", self.path(name + "/camera.yaml"), white, "--size",
                         "320x240", "--projection", "equidistant", "--hfov", 120,
                         "--max-error-px", 0.2, "-o", self.path(name + "_view"))
            levels[name] = read_png(self.path(name + "_view/fisheye_white.png"))[2]
        pixels = write(self.path("pixels.csv"), "x,y\n150,120\n300,120\n")
        rays = {}
        for name in ("none", "told"):
            result = run("unproject", self.path(name + "/camera.yaml"), "--pixels", pixels)
            self.assert_done(result)
            rays[name] = [line.split(",")[2:] for line in result.stdout.splitlines()[1:]]
        self.assertEqual(rays["told"], [rays["none"][0], ["", "", ""]])
        points = write(self.path("seen.csv"),
                       "x,y,z\n" + "".join(",".join(ray) + "\n" for ray in rays["none"]))
        result = run("project", self.path("told/camera.yaml"), "--points", points, "--json")
        self.assertEqual([row["valid"] for row in json.loads(result.stdout)], [True, False])
        compared = {}
        for name in ("none", "told"):
            result = run("compare", self.path(name + "/camera.yaml"),
                         self.path("none/camera.yaml"), "--json")
            self.assert_done(result)
            compared[name] = json.loads(result.stdout)["points"]
        self.assertLess(compared["told"], compared["none"] / 2)
        self.succeed("export", self.path("told/camera.yaml"), "--to", "maps", "--size",
                     "320x240", "--projection", "equidistant", "--hfov", 120, "-o",
                     self.path("told.xml"))
        cells = read(self.path("told.xml")).decode().split("<data>")[1].split("</data>")[0].split()
        self.assertEqual(float(cells[120 * 320 + 300]), -1)
        self.assertGreater(float(cells[120 * 320 + 150]), 100)
        middle, side = 120 * 320 + 150, 120 * 320 + 300
        self.assertEqual([levels[name][middle] for name in levels], [255, 255])
        self.assertEqual([levels[name][side] for name in levels], [255, 0])

    def test_reverse_leads_back_to_the_camera(self):
        wave = [round(128 + 80 * math.sin(x / 6) * math.cos(y / 7))
                for y in range(120) for x in range(160)]
        image = write(self.path("wave/in/wave.png"), png(wave, size=(160, 120)))
        self.assert_done(self.pack("200x150,alpha=1", output="wave/c.raygrid"))
        for camera, words in ((self.path("wave/c.raygrid"), ()),
                              (self.camera, ("--view", self.path("wave/c.camera.yaml"),
                                             "--max-error-px", 0.25))):
            self.succeed("undistort", camera, image, *words, "-o",
                         self.path("wave/flat"))
            result = self.succeed("undistort", camera, self.path("wave/flat/wave.png"), *words, "--inverse",
                                  "--json", "-o", self.path("wave/back"))
            self.assertEqual(json.loads(result.stdout)["view"]["size"], [200, 150])
            _, _, back = read_png(self.path("wave/back/wave.png"))
            self.assertEqual(len(back), len(wave))
            # A tenth of a pixel is 1.4 grey levels of the steepest slope; the rest is what
            # interpolation loses of the waves.
            inside = [abs(back[160 * y + x] - wave[160 * y + x])
                      for y in range(4, 116) for x in range(4, 156)]
            self.assertLess(max(inside), 8)
            self.assertLess(sum(inside) / len(inside), 1.5)

    def test_reverse_refuses_what_has_no_way_back(self):
        out = ["-o", self.path("never")]
        self.assert_refused(run("undistort", self.camera, self.image, "--inverse", "--size",
                                "200x150", *out), 8, "white.png", "160 x 120", "the undistorted view has",
                            "200 x 150")
        self.assert_refused(run("undistort", self.camera, self.image, "--inverse", "--frames",
                                self.path("raw"), *out), 1, "--frames")
        self.succeed("simulate", "--images", 3, "--lens", "glass", "--size", "160x120",
                     "-o", self.path("glass"))
        self.assert_refused(run("undistort", self.path("glass/true_camera.yaml"), self.image,
                                "--inverse", *out), 1, "true_camera.yaml", "raygrid fit")
        self.assert_nothing_in(self.path("never"))

    def test_border_where_nothing_is_trusted(self):
        """Features in the middle of the image alone: the whole view is filled, or its border
        left."""
        simulated = self.path("middle")
        self.succeed("simulate", "--lens", "pinhole", "--size", "160x120", "--images", 40,
                     "--noise-px", 0.01, "-o", simulated, "--quiet")
        lines = read(os.path.join(simulated, "features.csv")).decode().splitlines(True)
        middle = [line for line in lines
                  if line.startswith(("#", "image")) or 40 < float(line.split(",")[4]) < 120]
        features = write(self.path("middle.csv"), "".join(middle))
        self.succeed("calibrate", "--features", features, "--image-size", "160x120",
                     "--pattern", os.path.join(simulated, "pattern.yaml"),
                     "--knot-spacing-px", 40, "--skip-comparison", "--quiet",
                     "--hold-out", "sim0000.png",
                     "-o", self.path("known"))
        camera = self.path("known/camera.yaml")
        shown = {}
        for outside in ("fill", "border"):
            self.succeed("undistort", camera, self.image, "--alpha", 0,
                         "--outside", outside, "-o", self.path(outside))
            shown[outside] = read_png(os.path.join(self.path(outside), "white.png"))[2]
        self.assertEqual(set(shown["fill"]), {255})
        self.assertEqual(shown["border"][60 * 160 + 80], 255)
        for corner in (0, 159, 119 * 160, 119 * 160 + 159):
            self.assertEqual(shown["border"][corner], 0)
        # A blob does the same by what it says of trust.
        self.succeed("pack", camera, "-o", self.path("known.raygrid"), "--remap",
                     "160x120", "--quiet")
        self.succeed("undistort", self.path("known.raygrid"), self.image, "--outside",
                     "border", "-o", self.path("by_blob"))
        self.assertEqual(read_png(os.path.join(self.path("by_blob"), "white.png"))[2][0], 0)
        result = run("undistort", self.camera, self.image, "--outside", "border",
                     "-o", self.path("unknown"))
        self.assert_refused(result, 1, "has no valid region")

    def test_reverse_leaves_border_where_pixels_are_not_trusted(self):
        """A camera that trusts some cells of 16 pixels, and a crop of its images."""
        cells = ["".join(".#"[2 < i < 8 and i + j > 5] for i in range(10)) for j in range(8)]
        known = write(self.path("cells/known.yaml"), read(self.camera).decode()
                      + "uncertainty: {columns: 2, rows: 2, deviation_px: [[1, 1], [1, 1]]}\n"
                      + f"trusted: {{max_deviation_px: 1, cell_px: 16, cells: {cells}}}\n")
        view = "160x120,hfov=80,center=79.5,59.5"
        blob = self.path("cells/c.raygrid")
        self.succeed("pack", known, "--remap", view, "--remap", view + ",direction=distort",
                     "--mode", "part:crop=40,30,80,60", "--max-error-px", 2, "--quiet",
                     "-o", blob)
        part = ("--mode", "part:crop=40,30,80,60", "--size", "160x120", "--focal", 80)
        for camera, words, corner, width in (
                (known, ("--hfov", 80), (0, 0), 160), (known, part, (40, 30), 80),
                (blob, ("--remap-index", 1), (40, 30), 80),
                (blob, ("--remap-index", 2), (0, 0), 160),
                (blob, ("--remap-index", 3), (40, 30), 80)):
            with self.subTest((camera, words)):
                shown = {}
                for outside in ("fill", "border"):
                    self.succeed("undistort", camera, self.image, "--inverse", *words,
                                 "--outside", outside, "-o", self.path(outside))
                    shown[outside] = read_png(self.path(f"{outside}/white.png"))[2]
                self.assertEqual(len(shown["fill"]), width * width * 3 // 4)
                for k, level in enumerate(shown["fill"]):
                    cell = cells[(corner[1] + k // width) // 16][(corner[0] + k % width) // 16]
                    self.assertEqual(shown["border"][k], level if cell == "#" else 0, k)
                self.assertGreater(sum(level == 255 for level in shown["border"]), 1000)
        # The other direction takes frames of the table's mode, too.
        small = write(self.path("cells/in/small.png"), png([255] * (80 * 60), size=(80, 60)))
        self.succeed("undistort", blob, small, "--remap-index", 1, "--outside", "border",
                     "--max-error-px", 2, "-o", self.path("cells/out"))
        dark = write(self.path("cells/dark.yaml"), read(known).decode().replace("#", "."))
        self.assert_refused(run("undistort", dark, self.image, "--inverse", "--outside", "border",
                                "-o", self.path("never")), 1, "dark.yaml", "valid region is empty")

    def test_impossible_views_are_refused_in_a_line(self):
        for view, words in (("hfov=180", ("hfov", "170")), ("alpha=1.5", ("alpha", "0 (largest view")),
                            ("alpha=0,hfov=90", ("mutually exclusive",)), ("hfov=90,hfov=80", ("twice",)),
                            ("center=3", ("two numbers",)), ("center=3,nan", ("two numbers",)),
                            ("focal=", ("a number",)), ("focal=-1", ("focal length",)),
                            ("zoom=2", ("zoom=2", "hfov=DEG")),
                            ("hfov=90,640x480", ("640x480",)),
                            ("projection=mercator", ("mercator", "equirectangular")),
                            ("rotate=3,4", ("three numbers",)),
                            ("hfov=361,projection=cylindrical", ("361", "360")),
                            ("rotate=180,0,0,alpha=0", ("centre", "rotate")),
                            (f"view={self.camera}", ("not a view",)),
                            ("hfov=60,center=1e6,0", ("center",))):
            with self.subTest(view):
                self.assert_refused(self.pack(view, output="never/c.raygrid"), 1, *words)
        self.assert_nothing_in(self.path("never"))
        self.assert_refused(run("undistort", self.camera, self.image, "--alpha", "x", "-o",
                                self.path("never")), 1, "--alpha", "a number")

    def test_the_files_of_views_replace_no_input(self):
        camera = write(self.path("own/c.camera.yaml"), read(self.camera))
        result = run("pack", camera, "--remap", "80x60", "-o", self.path("own/c.raygrid"))
        self.assert_refused(result, 7, "overwrite the input")
        self.assertEqual(read(camera), read(self.camera))


if __name__ == "__main__":
    main(__name__)
