#!/usr/bin/env python3
"""benchmarks/README.md and README.md state the figures of the CSV files in benchmarks/. Nothing is measured here."""
import csv
import os
import re
import sys
import unittest

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
FOLDER = os.path.join(ROOT, "benchmarks")
sys.path.insert(0, os.path.join(ROOT, "tools", "measure"))
import page  # noqa: E402

FIGURE = re.compile(r"(\d+(?:\.\d+)?)\s(px|kB|×(?!\s*\d)|times)")
NUMBER = re.compile(r"(?<![\w.])\d+(?:,\d{3})*(?:\.\d+)?")
# Parts of the page by the data's sections: headings, and items of a list.
PART = re.compile(r"^(?:### |- \*\*)([^*\n]+)(.*?)(?=^#|^- \*\*|\Z)", re.MULTILINE | re.DOTALL)


def read_page():
    return page.read_text(os.path.join(FOLDER, "README.md"))


def numbers_of(row):
    return {number for key in ("case", "quantity", "value", "command") for number in NUMBER.findall(row[key])}


def decimals(text):
    return {number for number in NUMBER.findall(text) if "." in number}


class Page(unittest.TestCase):
    def test_tables_are_generated(self):
        text = read_page()
        self.assertEqual(text, page.with_tables(text), "run tools/measure/page.py")
        self.assertEqual(set(re.findall(r"<!-- (?!end)(\w+) -->", text)) | {"results"}, set(page.TABLES))

    def test_text_on_accuracy_states_figures_of_the_data(self):
        text = page.TABLE.sub("", read_page()).split("\n## Undistortion")[0].replace("OpenCV 5.0.0", "OpenCV")
        medians = {row["median_px"] for row in page.read_rows(FOLDER, "accuracy")}
        self.assertTrue(decimals(text))
        self.assertEqual(decimals(text) - medians, set())

    def test_best_median_of_calibrate_camera_on_the_fisheye(self):
        rows = [row for row in page.select(page.read_rows(FOLDER, "accuracy"), set="fisheye_190", program="OpenCV")
                if row["model"].startswith("calibrateCamera,")]
        best = page.best_of(rows, "median_px")["median_px"]
        self.assertIn(f"`calibrateCamera` has at least {best} px", read_page())

    def test_text_on_the_calibrator_states_figures_of_the_data(self):
        rows = page.read_rows(FOLDER, "calibrator")
        sections = {row["section"] for row in rows}
        parts = {title.strip(): text for title, text in PART.findall(read_page().split("\n## Calibrator\n")[1])}
        self.assertEqual(set(parts) - {"Others"}, sections)
        for section in sections:
            with self.subTest(section=section):
                measured = set().union(*(numbers_of(row) for row in page.select(rows, section=section)))
                stated = set(NUMBER.findall(re.sub(r"`[^`]*`", "", parts[section])))
                self.assertTrue(stated)
                self.assertEqual(stated - measured, set())


class Readme(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.text = page.read_text(os.path.join(ROOT, "README.md"))

    def test_table_is_generated(self):
        self.assertEqual(self.text, page.with_tables(self.text), "run tools/measure/page.py")
        self.assertIn("<!-- results -->", self.text)

    def test_figures_are_measured(self):
        stated = set(FIGURE.findall(page.TABLE.sub("", self.text)))
        measured = {(row[key], "px") for row in page.read_rows(FOLDER, "accuracy") for key in ("median_px", "rms_px")}
        measured |= {(row["value"], row["unit"]) for row in page.read_rows(FOLDER, "blob")}
        self.assertTrue(stated)
        self.assertEqual(stated - measured, set())


class Data(unittest.TestCase):
    def test_files_have_the_columns_that_are_written(self):
        for name in sorted(os.listdir(FOLDER)):
            if name.endswith(".csv"):
                with self.subTest(file=name), open(os.path.join(FOLDER, name), encoding="utf-8", newline="") as file:
                    lines = list(csv.reader(file))
                    self.assertGreater(len(lines), 1)
                    self.assertEqual({len(line) for line in lines}, {len(lines[0])})
        files = {row["file"] for row in page.read_rows(FOLDER, "runs")}
        self.assertEqual({name[:-4] for name in os.listdir(FOLDER) if name.endswith(".csv")},
                         files | {"calibrator", "runs"})

    def test_sets_are_described(self):
        described = [row["set"] for row in page.read_rows(FOLDER, "sets")]
        self.assertEqual(described, list(dict.fromkeys(row["set"] for row in page.read_rows(FOLDER, "accuracy"))))

    def test_both_evaluations_are_stated_for_all_programs(self):
        """With rigid and with deforming targets, and peers' imports are the same cameras."""
        rows = page.read_rows(FOLDER, "target_deformation")
        self.assertIn("fisheye_190", {row["set"] for row in rows})
        for name in {row["set"] for row in rows}:
            compared = [row for row in page.select(rows, set=name) if not row["failure"]]
            self.assertEqual({row["program"] for row in compared}, set(page.PROGRAMS))
            for row in compared:
                with self.subTest(row=list(row.values())[:5]):
                    rigid, corners = float(row["rigid_median_px"]), int(row["rigid_corners"])
                    own = row["own_code_median_px"]
                    self.assertGreater(corners, 0)
                    if row["deformed_median_px"]:  # the points of one are far off a plane
                        self.assertLess(abs(int(row["deformed_corners"]) - corners / 2), 0.05 * corners)
                    self.assertEqual(own == "", row["program"] == "raygrid")
                    if own:
                        self.assertAlmostEqual(rigid, float(own), delta=0.01 * rigid + 0.001)


if __name__ == "__main__":
    unittest.main()
