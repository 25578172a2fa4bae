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
        for name in ("pattern-segments", "feature-refinement"):
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
