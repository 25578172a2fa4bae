#!/usr/bin/env python3
"""calibrate over lens positions and temperatures at once, and --at, pack and the report of such a camera."""
import json
import random
import re

from command_test import CommandTest, long_test, main, read, run, write

BOARD = "chessboard:13x9:30mm"
POSITIONS = (0, 2.5, 5, 7.5, 10)
EACH = 8
BOTH = ("--vary-with", "lens_position", "--vary-with", "temperature")


class BothConditions(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        temperatures = random.Random(4)
        features, values = [], ["image,lens_position,temperature"]
        for index in range(len(POSITIONS) * EACH):
            position = POSITIONS[index // EACH]
            temperature = (20, 70)[index % EACH] if index % EACH < 2 else round(temperatures.uniform(20, 70), 1)
            lines = read(cls.simulate(position, temperature, index) +
                         "/features.csv").decode().splitlines()
            features = features or lines[:1]
            features += ["%02d_%s" % (index, line) for line in lines[1:]]
            values.append("%02d_sim0000.png,%g,%g" % (index, position, temperature))
        cls.features = write(cls.path("features.csv"), "\n".join(features) + "\n")
        cls.values = write(cls.path("values.csv"), "\n".join(values) + "\n")
        result = cls.calibrate(*BOTH, "--operating-points", cls.values, out="out")
        assert result.returncode == 0, result.stderr
        cls.said, cls.remarks = result.stdout, result.stderr
        cls.camera = cls.path("out/camera.yaml")

    @classmethod
    def simulate(cls, position, temperature, seed):
        folder = cls.path("at%g_%g_%d" % (position, temperature, seed))
        cls.succeed("simulate", "--lens", "focusing-warming", "--at",
                    "lens_position=%g,temperature=%g" % (position, temperature), "--pattern", BOARD,
                    "--seed", seed + 1, "--images", 1, "--noise-px", 0.03, "-o", folder)
        return folder

    @classmethod
    def calibrate(cls, *options, features=None, out="refused"):
        return run("calibrate", "--features", features or cls.features, "--image-size", "640x480",
                   "--pattern", BOARD, "--knot-spacing-px", 160, "--skip-comparison", "--fix-target-geometry",
                   "--hold-out", "00_sim0000.png", *options, "-o", cls.path(out))

    def error_px(self, position, temperature, camera, *options):
        truth = self.simulate(position, temperature, 100)
        result = self.succeed("compare", truth + "/true_camera.yaml", camera, *options, "--json")
        return json.loads(result.stdout)["median_px"], result.stderr

    def test_the_camera_is_told_at_pairs_that_no_image_has(self):
        for position, temperature in ((3, 62), (8.3, 28)):
            at = "lens_position=%g,temperature=%g" % (position, temperature)
            error_px, said = self.error_px(position, temperature, self.camera, "--at", at)
            self.assertLess(error_px, 0.05)
            self.assertEqual(said, "")
        # In the middle of the other condition, which is said.
        error_px, said = self.error_px(3, 45, self.camera, "--at", "lens_position=3")
        self.assertLess(error_px, 0.05)
        self.assertIn("calibrated over 20 to 70 °C; using the centre of the range", said)
        # The other one matters.
        self.assertGreater(self.error_px(3, 62, self.camera, "--at", "lens_position=3")[0], 0.1)
        _, said = self.error_px(3, 45, self.camera)
        self.assertIn("calibrated over 0 to 10 dioptres and 20 to 70 °C; using the centre of the "
                      "range", said)

    def test_output_and_report_tell_both_changes(self):
        self.assertRegex(self.said, r"0 to 10 dioptres: image scale changes by [34]\.\d+ %")
        self.assertRegex(self.said, r"20 to 70 °C: image scale changes by -0\.[12]\d? ?%")
        report = read(self.path("out/report.html")).decode()
        for heading in ("<h3>Over the lens position, at 45 °C</h3>",
                        "<h3>Over the temperature, at 5 dioptres</h3>",
                        "Distortion at 70 °C against 45<"):
            self.assertIn(heading, report)
        ranges = json.loads(read(self.path("out/result.json")))["operating_ranges"]
        self.assertEqual([told["quantity"] for told in ranges], ["lens_position", "temperature"])
        self.assertEqual([change["value"] for change in ranges[1]["samples"]], [20, 45, 70])
        growth = ranges[1]["samples"][2]["scale_change"] - ranges[1]["samples"][0]["scale_change"]
        self.assertLess(abs(growth + 0.002), 0.0005)

    def test_values_say_whose_they_are(self):
        for at, told in (
                (3, "varies with two quantities; specify both, such as --at "
                    "lens_position=5,temperature=45"),
                ("lens_position=11", "outside the calibrated range, 0 to 10 dioptres"),
                ("lens_position=3,temperature=71", "outside the calibrated range, 20 to 70 °C"),
                ("pressure=3", "unknown quantity 'pressure'"),
                ("lens_position=3,lens_position=4", "lens_position is specified twice"),
                ("lens_position=", "expected a number"), ("near", "expected a number")):
            result = run("project", self.camera, "--at", at, "--points", "none.csv")
            self.assert_refused(result, 1, told)
        result = run("simulate", "--lens", "focusing", "--at", "temperature=30", "-o", self.path("no"))
        self.assert_refused(result, 1, "varies with lens_position only")

    @long_test
    def test_a_blob_goes_over_the_condition_that_is_not_given(self):
        def pack(*options):
            blob = self.path("packed.raygrid")
            result = run("pack", self.camera, *options, "-o", blob)
            self.assert_done(result)
            return blob, result.stderr, json.loads(run("inspect", blob, "--json").stdout)

        blob, said, told = pack("--at", "temperature=60")
        self.assertEqual(said, "")
        self.assertEqual(told["operating_points"]["quantity"], "lens_position_dpt")
        self.assertEqual((told["operating_points"]["samples"][0], told["operating_points"]["samples"][-1]), (0, 10))
        for at in (8.3, "lens_position=8.3"):
            self.assertLess(self.error_px(8.3, 60, blob, "--at", at)[0], 0.05)
        result = run("project", blob, "--at", "temperature=60", "--points", "none.csv")
        self.assert_refused(result, 1, "varies with lens_position only")
        # A value that one camera does not change with is the other's.
        at = "lens_position=8.3,temperature=60"
        result = run("compare", self.camera, blob, "--at", at, "--json")
        self.assert_done(result)
        self.assertIn("varies with lens_position only; the other value applies to the other camera",
                      result.stderr)
        self.assertLess(json.loads(result.stdout)["median_px"], 0.01)
        result = run("compare", blob, blob, "--at", at)
        self.assert_refused(result, 1, "both cameras were calibrated over lens_position only")

        _, said, told = pack("--at", "lens_position=8.3")
        self.assertEqual(said, "")
        self.assertEqual(told["operating_points"]["quantity"], "sensor_temperature_c")
        blob, said, told = pack("--at", "lens_position=8.3,temperature=60")
        self.assertEqual(said, "")
        self.assertNotIn("stack", told)
        self.assertLess(self.error_px(8.3, 60, blob)[0], 0.05)
        # Boards follow the lens, if nothing is said.
        _, said, told = pack()
        self.assertEqual(told["operating_points"]["quantity"], "lens_position_dpt")
        for remarks in (said, self.remarks):
            self.assertIn("varies with lens_position, at temperature 45 (centre", remarks)

    def test_values_that_do_not_tell_both(self):
        both = ("--vary-with", "lens_position,temperature")
        self.assert_refused(self.calibrate(*both), 1, "have no operating point",
                            "the columns image,lens_position,temperature")
        self.assert_refused(self.calibrate(*both, "--images-at", "3=folder"), 1)
        one = write(self.path("one.csv"), "image,value\n00_sim0000.png,0\n")
        self.assert_refused(self.calibrate(*both, "--operating-points", one), 2, "lens_position")
        together = write(self.path("together.csv"), "".join(
            "%s,%s,%s\n" % (line.split(",")[0], line.split(",")[1],
                            40 + 2 * float(line.split(",")[1]) if k else "temperature")
            for k, line in enumerate(read(self.values).decode().splitlines())))
        self.assert_refused(self.calibrate(*both, "--operating-points", together), 1,
                            "lens_position and temperature of the images are correlated")
        same = write(self.path("same.csv"), "".join(
            line.rsplit(",", 1)[0] + (",30\n" if k else ",temperature\n")
            for k, line in enumerate(read(self.values).decode().splitlines())))
        self.assert_refused(self.calibrate(*both, "--operating-points", same), 1,
                            "all images have the same temperature", "calibrate without temperature")
        self.assert_nothing_in(self.path("refused"))

    def test_one_column_of_two_is_enough_for_one(self):
        # Only that it is accepted: four images at both ends.
        few = re.compile("image,|(0[0-3]|3[2-5])_")
        features = write(self.path("few.csv"), "".join(
            line for line in read(self.features).decode().splitlines(keepends=True) if few.match(line)))
        result = self.calibrate("--vary-with", "lens_position", "--operating-points", self.values, features=features,
                                out="one")
        self.assert_done(result)
        self.assertIn(b"\n  condition: lens_position\n", read(self.path("one/camera.yaml")))


if __name__ == "__main__":
    main(__name__)
