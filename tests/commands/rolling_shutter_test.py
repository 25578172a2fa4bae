#!/usr/bin/env python3
"""calibrate --rolling-shutter: the time of a row, from features and their times to the blob."""
import json
import re
from pathlib import Path

from command_test import CommandTest, long_test, main, read, run, write

SIZE = "640x480"


class RollingShutterTest(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.moving = cls.record("moving", "--line-delay-us", "20", "--images", "150")

    @classmethod
    def record(cls, name, *options):
        folder = Path(cls.path(name))
        cls.succeed("simulate", "--moving", "--lens", "pinhole", "--features-per-image", "100",
                    "--noise-px", "0.05", *options, "-o", folder)
        return folder

    def calibrate(self, folder, *options):
        return run("calibrate", "--features", folder / "features.csv", "--image-size", SIZE,
                   "--pattern", folder / "pattern.yaml", "--knot-spacing-px", "120", "--skip-comparison",
                   "--fix-target-geometry", *options)

    def row_time(self, folder, *options):
        """What calibrate says of it, and the result's folder."""
        result = Path(self.path("of_" + folder.name))
        done = self.calibrate(folder, "--rolling-shutter", "--timestamps", folder / "times.csv", "--json",
                              "-o", result, *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)["line_delay"], result

    def test_20_microseconds_are_found_to_three_percent(self):
        found, result = self.row_time(self.moving)
        self.assertLess(abs(found["value_us"] - 20), 0.6)
        self.assertLess(found["sd_us"], 0.3)
        self.assertTrue(found["compensated"])
        for name in ("camera.yaml", "camera.raygrid"):
            facts = json.loads(run("inspect", result / name, "--json").stdout)
            self.assertAlmostEqual(facts["line_delay_us"], found["value_us"], delta=1e-5)
            self.assertAlmostEqual(facts["line_delay_sd_us"], found["sd_us"], delta=1e-5)
            self.assertIn("line delay", run("inspect", result / name).stdout)
        self.assertIn("line delay", read(result / "report.html").decode())
        self.assertEqual(run("report", result).returncode, 0)
        self.assertIn("line delay", read(result / "report.html").decode())
        self.carried(result, found["value_us"])
        self.better(result)

    def carried(self, result, row_time_us):
        """fit of the blob, and pack of that, keep it."""
        fitted, again = self.path("fitted.yaml"), self.path("again.raygrid")
        for command in (("fit", result / "camera.raygrid", "--model", "opencv", "-o", fitted),
                        ("pack", fitted, "-o", again)):
            self.assertEqual(run(*command).returncode, 0)
        facts = json.loads(run("inspect", again, "--json").stdout)
        self.assertAlmostEqual(facts["line_delay_us"], row_time_us, delta=1e-5)

    def better(self, result):
        """The camera errs less than one that is bent by the motion."""
        bent = Path(self.path("bent"))
        self.assertEqual(self.calibrate(self.moving, "-o", bent).returncode, 0)
        self.assertNotIn(b"row_time", read(bent / "camera.yaml"))
        errors = [json.loads(run("compare", folder / "camera.yaml", self.moving / "true_camera.yaml",
                                 "--json").stdout)["median_px"] for folder in (result, bent)]
        self.assertLess(4 * errors[0], errors[1])

    def test_global_shutter_is_zero_within_two_deviations(self):
        found, result = self.row_time(self.record("global", "--images", "150"))
        self.assertLess(abs(found["value_us"]), 3 * found["sd_us"])
        self.assertIn(b"row_time_us", read(result / "camera.yaml"))

    def test_frames_that_are_far_apart_tell_nothing(self):
        found, result = self.row_time(self.record("apart", "--frame-rate", "1", "--images", "40"))
        self.assertIn("only 0 images have two adjacent frames", found["not_observable"])
        self.assertNotIn("value_us", found)
        self.assertNotIn(b"row_time", read(result / "camera.yaml"))
        facts = json.loads(run("inspect", result / "camera.raygrid", "--json").stdout)
        self.assertNotIn("line_delay_us", facts)

    def test_times_that_do_not_fit_the_motion_end_without_a_blob(self):
        """Frames that arrive three at a time, 2 ms apart."""
        rows = read(self.moving / "times.csv").decode().splitlines()
        names, times = zip(*(row.split(",") for row in rows[1:]))
        bursts = [float(times[min(k // 3 * 3 + 2, len(times) - 1)]) + 0.002 * (k % 3) for k in range(len(times))]
        wrong = write(self.path("bursts.csv"), "image,time_s\n" + "".join(
            f"{name},{time}\n" for name, time in zip(names, bursts)))
        result = Path(self.path("bursts"))
        done = self.calibrate(self.moving, "--rolling-shutter", "--timestamps", wrong, "-o", result)
        self.assertEqual(done.returncode, 6, done.stderr)
        self.assertIn("the timestamps are inconsistent with the motion", done.stderr)
        self.assertIn("not observable", done.stdout)
        facts = json.loads(read(result / "result.json"))
        self.assertEqual(facts["verdict"], "fail")
        self.assertFalse(facts["line_delay"]["timestamps_consistent"])
        self.assertNotIn("value_us", facts["line_delay"])
        self.assertFalse((result / "camera.raygrid").exists())
        self.assertNotIn(b"row_time", read(result / "camera.yaml"))
        self.assertEqual(run("report", result).returncode, 0)

    @long_test
    def test_images_of_unknown_motion_are_left_out_and_named(self):
        rows = read(self.moving / "times.csv").decode().splitlines(keepends=True)
        gone = ("sim0060.png", "sim0061.png")
        times = write(self.path("gaps.csv"), "".join(row for row in rows if not row.startswith(gone)))
        result = Path(self.path("gaps"))
        done = self.calibrate(self.moving, "--rolling-shutter", "--timestamps", times, "-o", result)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("except in 2 images of unknown motion", done.stdout)
        facts = json.loads(read(result / "result.json"))
        self.assertEqual(facts["line_delay"]["uncompensated_images"], 2)
        self.assertEqual([image["image"] for image in facts["images"]["rejected"]], list(gone))
        self.assertIn("unknown motion", facts["images"]["rejected"][0]["reason"])
        self.better(result)

    def refusal(self, *options):
        folder = Path(self.path("refused"))
        done = self.calibrate(self.moving, *options, "-o", folder)
        self.assert_nothing_in(folder)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        return done.returncode, done.stderr

    def test_times_that_do_not_fit_are_refused(self):
        def times(text):
            return write(self.path(f"times{len(text)}.csv"), text.encode())
        rows = read(self.moving / "times.csv").decode()
        for options, code, words in (
                (["--rolling-shutter"], 1, "requires timestamps"),
                (["--timestamps", self.moving / "times.csv"], 1, "requires --rolling-shutter"),
                (["--rolling-shutter", "--timestamps", self.moving / "times.csv", "--vary-with",
                  "temperature"], 1, "cannot be combined with --vary-with"),
                (["--rolling-shutter", "--timestamps", self.path("none.csv")], 2, "none.csv"),
                (["--rolling-shutter", "--timestamps", times("image,time\na,1\n")], 2, "time_s"),
                (["--rolling-shutter", "--timestamps", times(rows + "sim0000.png,99\n")], 2, "duplicate image"),
                (["--rolling-shutter", "--timestamps", times(rows + "other.png,0\n")], 2, "have the same timestamp"),
                (["--rolling-shutter", "--timestamps", times("image,time_s\nx.png,1\n")], 2,
                 "lacks timestamps of images")):
            code_of_it, text = self.refusal(*options)
            self.assertEqual(code_of_it, code, text)
            self.assertTrue(re.search(words, text), text)


if __name__ == "__main__":
    main(__name__)
