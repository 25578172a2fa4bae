#!/usr/bin/env python3
"""calibrate --vary-with: a camera over a range of lens positions, and --at of the other commands."""
import json
import os
import re
import shutil
import struct
import threading

from command_test import CommandTest, main, read, run, write
from png_files import chunk

BOARD = "chessboard:13x9:30mm"
POSITIONS = (0, 2, 4, 6, 8, 10)


class Condition(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        features, values = [], ["image,value"]
        for position in POSITIONS:
            cls.simulate(position, "--images", 7, "--noise-px", 0.03)
            lines = read(cls.path("at%g/features.csv" % position)).decode().splitlines()
            features = features or lines[:1]
            features += ["%g_%s" % (position, line) for line in lines[1:]]
            values += ["%g_sim%04d.png,%g" % (position, i, position) for i in range(7)]
        cls.features = write(cls.path("features.csv"), "\n".join(features) + "\n")
        cls.values = write(cls.path("values.csv"), "\n".join(values) + "\n")
        # Four images at both ends, for messages that precede the work.
        few = re.compile(r"image,|(0|10)_sim000[0-3]")
        cls.few_features, cls.few_values = (write(cls.path("few_" + name), "".join(
            line + "\n" for line in lines if few.match(line)))
            for name, lines in (("features.csv", features), ("values.csv", values)))
        result = cls.calibrate("--vary-with", "lens_position", "--operating-points", cls.values,
                               out="out")
        assert result.returncode == 0, result.stderr
        cls.said = result.stdout
        cls.camera = cls.path("out/camera.yaml")

    @classmethod
    def simulate(cls, position, *options):
        cls.succeed("simulate", "--lens", "focusing", "--at", position, "--pattern", BOARD,
                    "--seed", int(position) + 1, *options, "-o", cls.path("at%g" % position))

    @classmethod
    def calibrate(cls, *options, features=None, out="refused"):
        return run("calibrate", "--features", features or cls.features, "--image-size", "640x480",
                   "--pattern", BOARD, "--knot-spacing-px", 160, "--skip-comparison", "--fix-target-geometry",
                   "--hold-out", "0_sim0000.png", *options, "-o", cls.path(out))

    def error_px(self, position, *options):
        result = self.succeed("compare", self.path("at%g/true_camera.yaml" % position), self.camera,
                              *options, "--json")
        return json.loads(result.stdout)["median_px"], result.stderr

    def test_the_camera_is_told_where_no_image_was(self):
        for position in (3, 7.5):
            self.simulate(position, "--images", 1)
            error_px, said = self.error_px(position, "--at", position)
            self.assertLess(error_px, 0.03)
            self.assertEqual(said, "")
        error_px, said = self.error_px(0)
        self.assertGreater(error_px, 1)
        self.assertIn("calibrated over 0 to 10 dioptres; using the centre of the range", said)

    def test_other_commands_take_the_camera_at_a_value(self):
        points = write(self.path("points.csv"), "x,y,z\n0.3,0.2,1\n")
        pixels = []
        for at in (0, 10):
            result = self.succeed("project", self.camera, "--at", at, "--points", points)
            pixels.append(float(result.stdout.splitlines()[1].split(",")[3]))
        # 320 px plus 0.3 times the focal length, which grows by 4 %.
        self.assertGreater(pixels[1], pixels[0] + 4)
        self.succeed("pack", self.camera, "--at", 2.5, "-o", self.path("near.raygrid"))

    def test_output_and_report_tell_what_changes(self):
        self.assertRegex(self.said, r"0 to 10 dioptres: image scale changes by [34]\.\d+ %")
        report = read(self.path("out/report.html")).decode()
        self.assertIn("<h2>Operating range</h2>", report)
        for end in (0, 10):
            self.assertIn("Distortion at %d dioptres against 5<" % end, report)
            self.assertIn("Predicted uncertainty at %d dioptres<" % end, report)
        changes = json.loads(read(self.path("out/result.json")))["operating_ranges"][0]["samples"]
        self.assertEqual([change["value"] for change in changes], [0, 2.5, 5, 7.5, 10])
        growth = changes[-1]["focal_px"] / changes[0]["focal_px"]
        self.assertLess(abs(growth - 1.04), 0.002)

    def test_a_blob_has_the_whole_range(self):
        blob = self.path("all.raygrid")
        result = self.succeed("pack", self.camera, "--remap", "640x480", "-o", blob)
        self.assertEqual(result.stderr, "")
        knots = json.loads(run("inspect", blob, "--json").stdout)["operating_points"]["samples"]
        self.assertEqual((knots[0], knots[-1]), (0, 10))
        for position in (3, 7.5):
            self.simulate(position, "--images", 1)
            result = self.succeed("compare", self.path("at%g/true_camera.yaml" % position), blob, "--at",
                                  position, "--json")
            self.assertLess(json.loads(result.stdout)["median_px"], 0.05)
        points = write(self.path("far.csv"), "x,y,z\n0.3,0.2,1\n")
        pixels = []
        for camera in (blob, self.camera):
            result = self.succeed("project", camera, "--at", 7.3, "--points", points)
            pixels.append(float(result.stdout.splitlines()[1].split(",")[3]))
        self.assertLess(abs(pixels[0] - pixels[1]), 0.02)

    def test_values_that_cannot_be(self):
        for at, told in ((10.5, "--at 10.5: outside the calibrated range, 0 to 10 dioptres"),
                         ("nan", "--at: expected a number"),
                         ("temperature=3", "varies with lens_position only")):
            result = run("project", self.camera, "--at", at, "--points", "none.csv")
            self.assert_refused(result, 1, told)
        result = run("project", self.path("at0/true_camera.yaml"), "--at", 3, "--points", "none.csv")
        self.assert_refused(result, 1, "was not calibrated over")

    def test_conditions_that_are_missing(self):
        self.assert_refused(self.calibrate("--vary-with", "temperature"), 1, "have no operating point")
        self.assert_refused(self.calibrate("--operating-points", self.values), 1, "--vary-with lens_position")
        few = write(self.path("few.csv"), "image,value\n0_sim0000.png,0\n")
        self.assert_refused(self.calibrate("--vary-with", "lens_position", "--operating-points", few), 1,
                          "has no lens_position")
        one = write(self.path("one.csv"), "\n".join(
            line.rsplit(",", 1)[0] + (",3" if i else ",value")
            for i, line in enumerate(read(self.values).decode().splitlines())) + "\n")
        self.assert_refused(self.calibrate("--vary-with", "lens_position", "--operating-points", one), 1,
                          "all images have the same lens_position")
        twice = write(self.path("twice.csv"), "image,value\n0_sim0000.png,0\n0_sim0000.png,1\n")
        self.assert_refused(self.calibrate("--vary-with", "lens_position", "--operating-points", twice), 2,
                          "duplicate row for image")
        self.assert_refused(self.calibrate("--vary-with", "lens_position", "--operating-points", self.values,
                                         "--model", "opencv"), 1, "requires model central-generic")
        self.assert_nothing_in(self.path("refused"))

    def test_rows_of_no_image_are_told(self):
        more = write(self.path("more.csv"), read(self.few_values).decode() + "gone1.png,1\ngone0.png,3\n")
        options = ("--vary-with", "lens_position", "--operating-points", more)
        result = self.calibrate(*options, features=self.few_features, out="more")
        self.assert_done(result)
        lines = [line for line in result.stderr.splitlines() if "rows" in line]
        self.assertEqual(lines, [f"raygrid: {more}: 2 of 10 rows match no image of the calibration, such as "
                                 "gone0.png; check the names"])
        self.assertEqual(self.calibrate(*options, "--quiet", features=self.few_features, out="more").stderr, "")

    def test_values_of_another_unit_come_through_a_pipe_and_are_told(self):
        table = "".join(line + ("00\n" if i else "\n")
                        for i, line in enumerate(read(self.few_values).decode().splitlines()))
        pipe = self.path("pipe")
        os.mkfifo(pipe)
        threading.Thread(target=write, args=(pipe, table), daemon=True).start()
        result = self.calibrate("--vary-with", "lens_position", "--operating-points", pipe, features=self.few_features,
                                out="steps")
        self.assert_done(result)
        self.assertIn("lens_position 1000 is not plausible in dioptres", result.stderr)
        self.assertNotIn("rows", result.stderr)

    def test_folders_of_images_at_values(self):
        folders = []
        for position in (0, 10):
            folder = self.path("photographs/%g" % position)
            self.succeed("simulate", "--lens", "focusing", "--at", position, "--render", "--images",
                         4, "--size", "320x240", "--pattern", "chessboard:8x6:40mm", "--seed",
                         position, "-o", folder)
            folders += ["--images-at", "%g=%s" % (position, folder)]
        options = ("--pattern", "chessboard:8x6:40mm", "--knot-spacing-px", 80, "--skip-comparison",
                   "--hold-out", "0/sim0000.png", "-o", self.path("folders"))
        result = run("calibrate", "--vary-with", "lens_position", *folders, *options)
        self.assertIn(result.returncode, (0, 5), result.stderr)
        self.assertIn(b"10/sim0001.png", read(self.path("folders/features.csv")))
        self.assertIn(b"range: [0, 10]", read(self.path("folders/camera.yaml")))
        # The report has an image before and after, at its own lens position.
        for name in ("example_before.png", "example_after.png"):
            self.assertTrue(read(self.path("folders/" + name)).startswith(b"\x89PNG"))
        # The order of values changes nothing.
        turned = (*options[:-1], self.path("turned"))
        self.assertIn(run("calibrate", "--vary-with", "lens_position", *folders[2:], *folders[:2],
                          *turned).returncode, (0, 5))
        for name in ("camera.yaml", "camera.raygrid", "features.csv", "poses.csv"):
            self.assertEqual(read(self.path("turned/" + name)), read(self.path("folders/" + name)), name)
        result = run("calibrate", "--vary-with", "lens_position", *folders, "--images-at", "10.0=x", *options)
        self.assert_refused(result, 1, "duplicate value")
        result = run("calibrate", "--vary-with", "lens_position", *folders, *folders, *options)
        self.assert_refused(result, 1, "duplicate value")
        again = "5=" + os.path.join(self.path("photographs"), "0", "..", "0")
        result = run("calibrate", "--vary-with", "lens_position", *folders, "--images-at", again, *options)
        self.assert_refused(result, 1, "same folder as")
        copy = shutil.copytree(self.path("photographs/0"), self.path("copy"))
        result = run("calibrate", "--vary-with", "lens_position", *folders, "--images-at", f"5={copy}",
                     "--quiet", *options)
        self.assert_refused(result, 2, "0/sim0000.png", "5/sim0000.png", "0 and 5")
        # In one folder, a copy with a value of its own.
        shutil.copy(self.path("copy/sim0001.png"), self.path("copy/copied.png"))
        values = write(self.path("copied.csv"), "image,value\n" + "".join(
            f"{name},{k}\n" for k, name in enumerate(sorted(os.listdir(copy))) if name.endswith("png")))
        result = run("calibrate", copy, "--vary-with", "lens_position", "--operating-points", values, *options[:-4],
                     "-o", self.path("folders"))
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("copied.png and sim0001.png have the same features", result.stderr)
        result = run("calibrate", "--vary-with", "lens_position", "--images-at", "near=x", *options)
        self.assert_refused(result, 1, "expected VALUE=FOLDER")


    def photographs_with_exif(self, folder, tag, type_, values):
        """Rendered photographs at 0 and 10 dioptres; values: two numbers of each."""
        for position, numbers in values.items():
            made = self.path("made%g" % position)
            self.succeed("simulate", "--lens", "focusing", "--at", position, "--render", "--images",
                         4, "--size", "320x240", "--pattern", "chessboard:8x6:40mm", "--seed",
                         position, "-o", made)
            for k in range(4):
                photo = read(os.path.join(made, "sim%04d.png" % k))
                exif = exif_of(tag, type_, *numbers)
                write(os.path.join(folder, "%g_%d.png" % (position, k)),
                      photo[:33] + chunk(b"eXIf", exif) + photo[33:])

    def test_photographs_tell_the_value_by_themselves(self):
        options = ("--pattern", "chessboard:8x6:40mm", "--knot-spacing-px", 80, "--skip-comparison",
                   "--hold-out", "0_0.png")
        for condition, tag, type_, values, told in (
                ("lens_position", 0x9206, 5, {0: (0xffffffff, 1), 10: (1, 10)}, "[0, 10]"),
                ("temperature", 0x9400, 10, {0: (2050, 100), 10: (71, 1)}, "[20.5, 71]")):
            folder, out = self.path(condition), self.path("exif_" + condition)
            self.photographs_with_exif(folder, tag, type_, values)
            result = run("calibrate", folder, "--vary-with", condition, *options, "-o", out)
            self.assertIn(result.returncode, (0, 5), result.stderr)
            self.assertIn("range: " + told, read(os.path.join(out, "camera.yaml")).decode())
        # Of the other condition, the first image tells nothing, and is named.
        result = run("calibrate", self.path("temperature"), "--vary-with", "lens_position",
                     *options, "-o", self.path("untold"))
        self.assert_refused(result, 2, "0_0.png: no lens_position in EXIF "
                                       "(SubjectDistance)")
        self.assert_nothing_in(self.path("untold"))


def exif_of(tag, type_, first, second):
    """EXIF data whose own directory has one tag of two numbers."""
    def directory(*entry):
        return struct.pack("<HHHIII", 1, *entry, 0)
    return (struct.pack("<2sHI", b"II", 42, 8) + directory(0x8769, 4, 1, 26) +
            directory(tag, type_, 1, 44) + struct.pack("<II", first, second))


if __name__ == "__main__":
    main(__name__)
