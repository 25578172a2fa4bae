#!/usr/bin/env python3
"""Bad input gets its exit code and one line, and leaves nothing half-written."""
import os
import random
import subprocess

from command_test import CommandTest, PATTERN, main, programs, read, run, write


def features(num_images, edit=lambda line: line):
    """A features file of a board seen by a pinhole, with some noise."""
    random.seed(1)
    lines = ["image,board,column,row,x,y"]
    for image in range(num_images):
        for row in range(6):
            for column in range(9):
                depth = 1 + 0.05 * image * column / 9 + 0.03 * (image % 3) * row / 6
                x = 100 + 45 * column / depth + 3 * image + random.gauss(0, 0.05)
                y = 80 + 45 * row / depth + 2 * image + random.gauss(0, 0.05)
                lines.append(f"im{image}.png,0,{column},{row},{x:.4f},{y:.4f}")
    return "\n".join(edit(line) for line in lines) + "\n"


def pgm(width, height):
    return b"P5\n%d %d\n255\n" % (width, height) + bytes(
        (x * y) % 251 for y in range(height) for x in range(width))


class BadInput(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.pattern = write(cls.path("pattern.yaml"), PATTERN)
        cls.succeed("simulate", "--images", 12, "--features-per-image", 80, "-o",
                    cls.path("sim"))
        cls.succeed("pack", cls.path("sim/true_camera.yaml"), "-o", cls.path("good.raygrid"),
                    "--remap", "640x480")

    def calibrate(self, *arguments, pattern=None):
        self.out = self.path("out-" + self.id())
        result = run("calibrate", *arguments, "--pattern", pattern or self.pattern, "-o", self.out)
        self.assert_nothing_in(self.out)
        return result

    def calibrate_features(self, text, size="640x480"):
        path = write(self.path(self.id() + ".csv"), text)
        return self.calibrate("--features", path, "--image-size", size)

    def test_image_that_is_text(self):
        write(self.path("text/a.png"), "this is no image\n")
        self.assert_refused(self.calibrate(self.path("text")), 2, "a.png", "not an image")

    def test_features_in_the_place_of_images(self):
        self.assert_refused(self.calibrate(self.path("sim/features.csv")), 1, "not an image",
                            "--features " + self.path("sim/features.csv"))

    def test_truncated_image(self):
        board = self.path("board")
        self.succeed("pattern", "chessboard", "--columns", 9, "--rows", 6, "--square-mm",
                     20, "--dpi", 50, "-o", board)
        png = read(os.path.join(board, "pattern.png"))
        write(self.path("short/a.png"), png[:len(png) // 2])
        self.assert_refused(self.calibrate(self.path("short")), 2, "a.png", "corrupt")

    def test_truncated_photograph(self):
        whole = os.path.join(programs.photographs, "left/left01.jpg")
        if not os.path.exists(whole):
            self.skipTest("no photographs; tools/fetch_photographs fetches them")
        photo = read(whole)
        write(self.path("half/a.jpg"), photo[:len(photo) // 2])
        self.assert_refused(self.calibrate(self.path("half")), 2, "a.jpg", "corrupt")

    def test_empty_folder(self):
        os.makedirs(self.path("empty"), exist_ok=True)
        self.assert_refused(self.calibrate(self.path("empty")), 2, "no images")

    def test_missing_folder(self):
        self.assert_refused(self.calibrate(self.path("nowhere")), 2, "nowhere")

    def test_images_of_two_sizes(self):
        write(self.path("sizes/a.pgm"), pgm(64, 48))
        write(self.path("sizes/b.pgm"), pgm(48, 64))
        self.assert_refused(self.calibrate(self.path("sizes")), 2, "b.pgm", "64 x 48")

    def test_no_board_in_the_images(self):
        write(self.path("blank/a.pgm"), pgm(64, 48))
        self.assert_refused(self.calibrate(self.path("blank")), 3, "inner corners")

    def test_board_size_that_does_not_match(self):
        small = write(self.path("small.yaml"), PATTERN.replace("columns: 9", "columns: 5"))
        path = write(self.path("nine.csv"), features(8))
        result = self.calibrate("--features", path, "--image-size", "640x480", pattern=small)
        self.assert_refused(result, 2, "5 x 6")

    def test_one_image_only(self):
        self.assert_refused(self.calibrate_features(features(1)), 3, "only 1 image with", "3 are required")

    def test_too_few_features(self):
        text = "\n".join(features(8).splitlines()[:6]) + "\n"
        self.assert_refused(self.calibrate_features(text), 3)

    def test_feature_that_is_not_a_number(self):
        for bad in ("nan", "inf", "twelve", ""):
            lines = features(8).splitlines()
            lines[7] = lines[7].rsplit(",", 1)[0] + "," + bad
            self.assert_refused(self.calibrate_features("\n".join(lines) + "\n"), 2, "line 8")

    def test_feature_outside_the_image(self):
        self.assert_refused(self.calibrate_features(features(8), size="300x200"), 2,
                            "300 x 200", "--image-size")

    def test_feature_given_twice(self):
        text = features(8)
        self.assert_refused(self.calibrate_features(text + text.splitlines()[1] + "\n"), 2, "line")

    def test_features_without_a_column(self):
        self.assert_refused(self.calibrate_features("image,board,column,x,y\na,0,0,1,1\n"), 2,
                            "'row'")

    def test_empty_features(self):
        self.assert_refused(self.calibrate_features(""), 2)

    def test_pattern_that_is_no_yaml(self):
        bad = write(self.path("bad.yaml"), "raygrid_pattern: 1\nboards: [\n")
        self.assert_refused(self.calibrate(self.folder, pattern=bad), 2, "bad.yaml", "line")

    def test_output_that_cannot_be_a_folder(self):
        blocker = write(self.path("blocker"), "a file")
        path = write(self.path("fine.csv"), features(8))
        result = run("calibrate", "--features", path, "--image-size", "640x480", "--pattern",
                     self.pattern, "-o", os.path.join(blocker, "out"))
        self.assert_refused(result, 7, "cannot be written")

    def test_full_disk(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("no /dev/full, which fails as a full disk does")
        result = run("unproject", self.path("good.raygrid"), "--pixels",
                     write(self.path("px.csv"), "x,y\n1,1\n"), "-o", "/dev/full/rays.csv")
        self.assert_refused(result, 7)

    def test_unknown_option_and_missing_argument(self):
        self.assert_refused(run("calibrate", "--no-such"), 1)
        self.assert_refused(run("pack"), 1)
        self.assert_refused(run(), 1)

    def test_truncated_blob(self):
        good = read(self.path("good.raygrid"))
        for size in (0, 10, 31, 32, 100, len(good) // 2, len(good) - 1):
            bad = write(self.path("cut.raygrid"), good[:size])
            self.assert_refused(run("inspect", bad), 8, "cut.raygrid")

    def test_flipped_bits_in_a_blob(self):
        good = read(self.path("good.raygrid"))
        random.seed(2)
        for _ in range(40):
            bad = bytearray(good)
            bad[random.randrange(len(bad))] ^= 1 << random.randrange(8)
            path = write(self.path("flipped.raygrid"), bytes(bad))
            self.assert_refused(run("inspect", path), 8, "flipped.raygrid")
            frame = write(self.path("frame.raw"), bytes(640 * 480))
            result = run(path, frame, self.path("never.raw"), program=programs.undistort)
            self.assert_refused(result, 8, "flipped.raygrid")
            self.assertFalse(os.path.exists(self.path("never.raw")))

    def test_frame_of_the_wrong_size(self):
        frame = write(self.path("small.raw"), bytes(640 * 479))
        result = run(self.path("good.raygrid"), frame, self.path("never.raw"),
                     program=programs.undistort)
        self.assert_refused(result, 2, "small.raw")

    def test_file_of_ours_given_for_another(self):
        camera = self.path("sim/true_camera.yaml")
        rig = write(self.path("rig.yaml"), "raygrid_rig: 1\ncameras: {}\n")
        fit = ("--model", "opencv", "-o", self.path("none.yaml"))
        for arguments, words in (
                (("fit", rig, *fit), ("not a camera", "but a rig", "one of its cameras")),
                (("fit", self.pattern, *fit), ("not a camera", "but a pattern"))):
            with self.subTest(arguments):
                self.assert_refused(run(*arguments), 2, *words)
        result = self.calibrate(self.path("sim"), pattern=camera)
        self.assert_refused(result, 2, "true_camera.yaml", "not a pattern", "but a camera")

    def test_image_of_another_mode(self):
        image = write(self.path("mode/a.pgm"), pgm(320, 240))
        result = run("undistort", self.path("good.raygrid"), image, "-o", self.path("mode-out"))
        self.assert_refused(result, 8, "640 x 480")

    def test_damaged_camera_file(self):
        text = read(self.path("sim/true_camera.yaml")).decode()
        for old, new in (("raygrid_camera: 1", "raygrid_camera: 2"), ("columns:", "colums:"),
                         ("model: central-generic", "model: other"), ("area: [", "area: [700, ")):
            bad = write(self.path("bad_camera.yaml"), text.replace(old, new, 1))
            self.assert_refused(run("inspect", bad), 2, "bad_camera.yaml")

    def test_camera_beyond_arithmetic(self):
        lines = read(self.path("sim/true_camera.yaml")).decode().splitlines()
        point = max(i for i, line in enumerate(lines) if line.startswith("  - ["))
        for number in ("1e308", "-1e13", ".nan", ".inf"):
            bad = [*lines[:point], f"  - [{number}, 0.5]", *lines[point + 1:], ""]
            path = write(self.path("far.yaml"), "\n".join(bad))
            pixels = write(self.path("px.csv"), "x,y\n1,2\n")
            self.assert_refused(run("unproject", path, "--pixels", pixels), 2, "far.yaml",
                                "control_points")

    def test_files_that_were_cut(self):
        """Wherever it is: never another camera, or another board."""
        self.succeed("calibrate", "--features", self.path("sim/features.csv"), "--image-size",
                     "640x480", "--pattern", self.path("sim/pattern.yaml"), "--model", "opencv",
                     "--skip-comparison", "--fix-target-geometry", "--hold-out", "sim0001.png", "-o",
                     self.path("whole"))
        for name in ("whole/camera.yaml", "whole/pattern.yaml", "sim/true_camera.yaml"):
            good = read(self.path(name))
            random.seed(3)
            line_ends = [i + 1 for i, byte in enumerate(good) if byte == ord("\n")][:-1]
            cuts = {*random.sample(range(len(good) - 3), 6), *random.sample(line_ends, 3),
                    *line_ends[1:6], *line_ends[-3:]}
            for size in sorted(cuts):
                path = write(self.path("cut.yaml"), good[:size])
                with self.subTest(name, size=size):
                    self.assert_refused(run("inspect", path), 2, "cut.yaml")

    def test_half_of_what_a_camera_is_known_by(self):
        self.assert_refused(run("inspect", write(
            self.path("half.yaml"), read(self.path("sim/true_camera.yaml")) + b"uncertainty:\n")),
            2, "half.yaml", "require each other")

    def test_more_behind_the_end_of_a_file(self):
        for more, words in (("---\nraygrid_pattern: 1\n", "content after the end"),
                            ("'", "within a quoted"), ('"', "within a quoted"), ("'\n", "within a quoted"),
                            ('"\n\n', "within a quoted"), ("]\n", "invalid YAML"), ("'cut", "invalid YAML")):
            with self.subTest(more):
                path = write(self.path("more.yaml"), PATTERN + more)
                self.assert_refused(run("inspect", path), 2, "more.yaml", words)

    def test_a_last_line_that_may_have_been_longer(self):
        block = ("raygrid_pattern: 1\nboards:\n  - id: 0\n    kind: chessboard\n    columns: 9\n"
                 "    rows: 6\n    square_m: 0.025")
        self.assert_refused(run("inspect", write(self.path("last.yaml"), block[:-1])), 2,
                            "last.yaml", "truncated within a line")
        self.succeed("inspect", write(self.path("last.yaml"), block + "\n"))
        self.succeed("inspect", write(self.path("last.yaml"), PATTERN.rstrip("\n")))

    def test_a_line_of_millions_of_fields(self):
        path = write(self.path("commas.csv"), b"," * 20000000 + b"\n")
        code, error, kilobytes = self.run_measured("unproject", self.path("good.raygrid"),
                                                   "--pixels", path)
        self.assertEqual(code, 2, error)
        self.assertIn("commas.csv, line 1", error)
        self.assertLess(kilobytes, 200000)

    def test_a_simulated_image_of_many_pixels(self):
        code, error, kilobytes = self.run_measured(
            "simulate", "--lens", "pinhole", "--size", "16000x400", "--images", "1", "--render",
            "--samples-per-pixel", "1", "--threads", "1", "-o", self.path("large"))
        self.assertEqual(code, 0, error)
        self.assertLess(kilobytes, 250000)

    def run_measured(self, *arguments):
        """Exit code, standard error, and kilobytes of memory."""
        # Freed memory, which sanitizers keep by default, is not the program's.
        options = os.environ.get("ASAN_OPTIONS", "") + ":quarantine_size_mb=1"
        with subprocess.Popen([programs.raygrid, *arguments], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE,
                              env={**os.environ, "ASAN_OPTIONS": options}) as process:
            error = process.stderr.read().decode()
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, error, usage.ru_maxrss

    def test_values_that_are_none(self):
        simulate = ("simulate", "--images", 2)
        for arguments, word in (((*simulate, "--seed", "-1", "-o", self.path("none")), "--seed"),
                                ((*simulate, "-o", ""), "-o"), ((*simulate, "--output="), "-o"),
                                (("inspect", ""), "file")):
            with self.subTest(arguments):
                self.assert_refused(run(*arguments), 1, word)
        self.assertFalse(os.path.exists(self.path("none")))

    def test_pixel_that_is_not_a_number(self):
        path = write(self.path("bad_px.csv"), "x,y\n1,2\nnan,3\n")
        result = run("unproject", self.path("good.raygrid"), "--pixels", path)
        self.assert_refused(result, 2, "line 3")

    def test_field_of_view_that_no_pinhole_has(self):
        for hfov in ("180", "-10", "nan", "0"):
            result = run("pack", self.path("sim/true_camera.yaml"), "-o", self.path("x.raygrid"),
                         "--remap", "640x480,hfov=" + hfov)
            self.assert_refused(result, 1)
            self.assertFalse(os.path.exists(self.path("x.raygrid")))

    def test_field_of_view_so_narrow_that_blobs_do_not_hold_its_focal_length(self):
        result = run("pack", self.path("sim/true_camera.yaml"), "-o", self.path("x.raygrid"),
                     "--remap", "640x480,hfov=0.5")
        self.assert_refused(result, 1, "focal length")
        self.assertFalse(os.path.exists(self.path("x.raygrid")))

    def test_bound_that_cannot_be_kept(self):
        result = run("pack", self.path("sim/true_camera.yaml"), "-o", self.path("x.raygrid"),
                     "--remap", "640x480", "--max-error-px", "0.0001")
        self.assert_refused(result, 6, "--max-error-px")


if __name__ == "__main__":
    main(__name__)
