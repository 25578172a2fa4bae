#!/usr/bin/env python3
"""The paper's experiments, on very few images."""
import csv
import json
import os

from command_test import CommandTest, main, read, run

ERRORS = ["median_x_px", "median_y_px", "rms_x_px", "rms_y_px"]
COUNTS = ["visible", "found", "compared"]


class Experiment(CommandTest):
    done = {}

    def run_experiment(self, name, threads, *options):
        """The rows of an experiment's CSV, and the contents of all its files."""
        folder = self.path(f"{name}-{threads}")
        result = run("experiment", name, "-o", folder, "--images", 1, "--threads", threads,
                     *options)
        self.assert_done(result)
        self.assertEqual(result.stderr, "")
        for words in ("640 x 480 px", "blur", "noise", "window", "seed"):
            self.assertIn(words, result.stdout)
        files = {end: read(os.path.join(folder, f"{name}.{end}")) for end in ("csv", "json", "svg")}
        self.assertEqual(len(os.listdir(folder)), 3)
        lines = [line for line in files["csv"].decode().splitlines() if line[0] != "#"]
        return list(csv.DictReader(lines)), files

    def experiment(self, name, threads=2, *options):
        """The same, run only once."""
        arguments = (name, threads, *options)
        if arguments not in self.done:
            self.done[arguments] = self.run_experiment(*arguments)
        return self.done[arguments]

    def check(self, name, own_column, rows, files):
        for row in rows:
            self.assertEqual(list(row), ["pattern", own_column, *COUNTS, *ERRORS, "largest_px"])
            visible, found, compared = (int(row[key]) for key in COUNTS)
            self.assertGreaterEqual(visible, 83)
            self.assertLessEqual(found, visible)
            self.assertLessEqual(compared, found)
            self.assertGreater(compared, 40)
        as_json = json.loads(files["json"])
        self.assertEqual(as_json["experiment"], name)
        self.assertEqual(len(as_json["rows"]), len(rows))
        for row, same in zip(rows, as_json["rows"]):
            self.assertEqual(list(row), list(same))
            for key in ERRORS:
                self.assertAlmostEqual(float(row[key]), same[key], delta=1e-6)
        self.assertEqual(files["svg"].count(b"<svg"), 1)
        self.assertIn(b"px</text>", files["svg"])

    def test_pattern_segments(self):
        rows, files = self.experiment("pattern-segments")
        self.check("pattern-segments", "segments", rows, files)
        self.assertEqual([(row["pattern"], int(row["segments"])) for row in rows],
                         [("star", n) for n in (4, 6, 8, 12, 16, 20, 24, 28, 32)] +
                         [("chessboard", 4)])
        rms = {row["segments"]: float(row["rms_x_px"]) for row in rows[:-1]}
        for error in rms.values():
            self.assertGreater(error, 0.001)
            self.assertLess(error, 0.01)
        # First better with more segments, then worse.
        self.assertLess(rms["16"], rms["4"])
        self.assertLess(rms["16"], rms["32"])

    def test_feature_refinement(self):
        rows, files = self.experiment("feature-refinement")
        self.check("feature-refinement", "refinement", rows, files)
        self.assertEqual([row["refinement"] for row in rows], 2 * [
            "intensities", "gradients-xy", "gradient-magnitude", "corner-subpix", "none"])
        for board in (rows[:5], rows[5:]):
            medians = [float(row["median_x_px"]) for row in board]
            self.assertLess(medians[0], 0.01)
            self.assertGreater(medians[4], 3 * medians[0])
            self.assertLess(medians[4], 0.2)

    def small(self, name, *options, images=15):
        """Rows of an experiment on simulated features, its pictures named."""
        folder = self.path(name + "-small")
        self.assert_done(run("experiment", name, "-o", folder, "--images", images, *options))
        text = read(os.path.join(folder, name + ".csv")).decode()
        rows = list(csv.DictReader(line for line in text.splitlines() if line[0] != "#"))
        self.assertIn(b"</svg>", read(os.path.join(folder, name + ".svg")))
        pictures = sorted(file for file in os.listdir(folder) if file.endswith(".png"))
        return rows, pictures

    def test_model_validation(self):
        rows, pictures = self.small("model-validation")
        self.assertEqual(pictures, ["model-validation-directions.png"])
        for key in ("training_median_px", "test_median_px", "ray_error_px"):
            parametric = [float(row[key]) for row in rows if row["cells"] == "0"]
            generic = [float(row[key]) for row in rows if row["cells"] != "0"]
            self.assertEqual((len(parametric), len(generic)), (3, 4))
            self.assertLess(2 * max(generic), min(parametric))

    def test_model_comparison(self):
        rows, pictures = self.small("model-comparison")
        self.assertEqual(pictures, ["model-comparison-direction.png",
                                    "model-comparison-magnitude.png"])
        self.assertEqual(len(rows), 3)
        for row in rows:  # the lens has bumps of up to 1.5 px
            self.assertGreater(float(row["rms_px"]), 0.1)
            self.assertLess(float(row["rms_px"]), 0.7)

    def test_noncentrality(self):
        rows, pictures = self.small("noncentrality")
        self.assertEqual(pictures, ["noncentrality-offsets.png"])
        errors = [float(row["right_far_rms_px"]) for row in rows]
        self.assertEqual(errors, sorted(errors, reverse=True))
        self.assertGreater(errors[0], 0.5)

    def test_localization(self):
        rows, _ = self.small("localization")
        by_name = {row.pop("camera"): [float(value) for value in row.values()] for row in rows}
        # Noise averages out, a wrong camera does not.
        self.assertLess(by_name["truth"][-1], 0.3 * by_name["truth"][0])
        self.assertGreater(by_name["opencv"][-1], 0.8 * by_name["opencv"][0])
        self.assertLess(by_name["central-generic"][-1], 0.5 * by_name["opencv"][-1])

    def test_curvature_bias(self):
        rows, _ = self.small("curvature-bias", images=8)
        error = {(row["mapping"], row["window_px"]): float(row["feature_error_rms_px"])
                 for row in rows}
        self.assertLess(2 * error["curved", "21"], error["homography", "21"])
        self.assertLess(error["homography", "11"], error["homography", "31"])

    def test_stereo_depth(self):
        rows, pictures = self.small("stereo-depth", images=12)
        self.assertEqual(pictures, ["stereo-depth-bias.png"])
        bias = {row["cameras"]: float(row["blocks_rms_mm"]) for row in rows}
        self.assertLess(2 * bias["central-generic"], bias["opencv"])
        self.assertLess(bias["central-generic"], 3 * bias["truth"])

    def test_trajectory_drift(self):
        rows, _ = self.small("trajectory-drift", images=20)
        worst = {}
        for row in rows:
            worst.setdefault(row["camera"], []).append(float(row["end_error_percent"]))
        self.assertLess(2 * max(worst["central-generic"]), min(worst["opencv"]))

    def test_own_features(self):
        self.assert_done(run("simulate", "--images", 10, "-o", self.path("own")))
        data = ("--features", self.path("own/features.csv"), "--pattern",
                self.path("own/pattern.yaml"), "--image-size", "640x480")
        rows, _ = self.small("localization", *data)
        self.assertIn("central-generic (the truth here)", [row["camera"] for row in rows])
        folder = self.path("refused")
        self.assert_refused(run("experiment", "curvature-bias", "-o", folder, *data), 1,
                            "--features")
        self.assert_refused(run("experiment", "localization", "-o", folder, *data[:2]), 1,
                            "--pattern")

    def test_number_of_threads_changes_nothing(self):
        for name in ("pattern-segments", "feature-refinement"):
            with self.subTest(name):
                self.assertEqual(self.experiment(name, 1), self.experiment(name, 2))

    def test_seed_and_noise_change_the_result(self):
        rows, _ = self.experiment("feature-refinement")
        for options in (("--seed", 1), ("--read-noise", 4)):
            others, _ = self.experiment("feature-refinement", 2, *options)
            self.assertNotEqual(rows, others)

    def test_list(self):
        result = run("experiment", "--list")
        self.assert_done(result)
        for name in ("pattern-segments", "feature-refinement", "model-validation",
                     "model-comparison", "curvature-bias", "noncentrality", "localization",
                     "stereo-depth", "trajectory-drift"):
            self.assertIn(name, result.stdout)

    def test_help_has_an_example(self):
        result = run("experiment", "--help")
        self.assert_done(result)
        self.assertIn("raygrid experiment pattern-segments -o", result.stdout)

    def test_wrong_usage(self):
        folder = self.path("refused")
        for arguments, word in ((("magic", "-o", folder), "--list"),
                                (("pattern-segments",), "-o"),
                                (("feature-refinement", "-o", folder, "--size", "300x200"), "--size"),
                                (("feature-refinement", "-o", folder, "--images", 0), "--images")):
            with self.subTest(arguments):
                self.assert_refused(run("experiment", *arguments), 1, word)
        self.assert_nothing_in(folder)


if __name__ == "__main__":
    main(__name__)
