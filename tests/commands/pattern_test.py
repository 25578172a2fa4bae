#!/usr/bin/env python3
"""Targets to print and to show: the pattern command."""
import json
import os
import struct

from command_test import CommandTest, main, read, run


class PatternCommand(CommandTest):
    def pattern(self, kind, *arguments):
        """A target with a small PNG, in a folder of its own."""
        folder = self.path(self.id() + "-" + kind)
        result = run("pattern", kind, *arguments, "-o", folder)
        self.assert_done(result)
        self.assertEqual(result.stderr, "")
        return folder

    def yaml(self, folder):
        return read(os.path.join(folder, "pattern.yaml")).decode()

    def refused(self, kind, *arguments, words):
        folder = self.path(self.id() + "-refused")
        result = run("pattern", kind, *arguments, "-o", folder)
        self.assert_refused(result, 1, *words)
        self.assert_nothing_in(folder)

    def test_star_board(self):
        folder = self.pattern("star", "--columns", 16, "--rows", 23, "--square-mm", 11.4, "--dpi",
                              50)
        self.assertEqual(set(os.listdir(folder)), {"pattern.yaml", "pattern.pdf", "pattern.svg",
                                                   "pattern.png"})
        self.assertIn("{id: 0, kind: star, columns: 16, rows: 23, square_m: 0.0114, segments: 16, "
                      "tags: [{family: tag36h11, id: 0, column: 5, row: 9, squares: 4}]}",
                      self.yaml(folder))

    def test_several_boards_have_a_page_and_tags_each(self):
        folder = self.pattern("star", "--columns", 12, "--rows", 9, "--square-mm", 15, "--boards",
                              3, "--tags", 2, "--tag-id", 10, "--dpi", 50)
        self.assertEqual(set(os.listdir(folder)),
                         {"pattern.yaml", "pattern.pdf"} |
                         {f"pattern_{k}.{end}" for k in range(3) for end in ("svg", "png")})
        yaml = self.yaml(folder)
        for tag_id in range(10, 16):
            self.assertEqual(yaml.count(f"id: {tag_id},"), 1)
        pdf = read(os.path.join(folder, "pattern.pdf"))
        self.assertIn(b"/Count 3", pdf)

    def test_several_boards_have_markers_of_their_own(self):
        folder = self.pattern("charuco", "--columns", 6, "--rows", 4, "--square-mm", 25,
                              "--marker-mm", 18, "--boards", 2, "--dpi", 50)
        yaml = self.yaml(folder)  # 7 x 5 squares: 17 markers
        self.assertEqual(yaml.count("kind: charuco"), 2)
        self.assertIn("id: 1, kind: charuco, columns: 6, rows: 4, square_m: 0.025, marker_m: "
                      "0.018, dictionary: DICT_4X4_50, first_marker: 17}", yaml)
        self.assertIn("pattern_1.svg", os.listdir(folder))
        folder = self.pattern("aprilgrid", "--tag-columns", 4, "--tag-rows", 3, "--tag-mm", 30,
                              "--first-marker", 5, "--boards", 3, "--dpi", 50)
        for first in (5, 17, 29):
            self.assertIn(f"first_marker: {first}}}", self.yaml(folder))
        self.assertIn(b"/Count 3", read(os.path.join(folder, "pattern.pdf")))

    def test_boards_of_other_makers(self):
        folder = self.pattern("charuco", "--columns", 8, "--rows", 5, "--square-mm", 28,
                              "--marker-mm", 21, "--legacy", "--dpi", 50)
        self.assertIn("kind: charuco, columns: 8, rows: 5, square_m: 0.028, marker_m: 0.021, "
                      "dictionary: DICT_4X4_50, legacy: true}", self.yaml(folder))
        folder = self.pattern("aprilgrid", "--tag-columns", 6, "--tag-rows", 5, "--tag-mm", 24,
                              "--dpi", 50)
        self.assertIn("kind: aprilgrid, columns: 12, rows: 10, square_m: 0.024, "
                      "tag_family: tag36h11, spacing_ratio: 0.3}", self.yaml(folder))

    def test_measured_print(self):
        size = ("chessboard", "--columns", 9, "--rows", 6, "--square-mm", 25, "--dpi", 50)
        nominal = self.pattern(*size)
        pdf = read(os.path.join(nominal, "pattern.pdf"))
        measured = self.pattern(*size, "--measured-x-mm", 148.5, "--measured-y-mm", 148.5)
        self.assertIn("square_m: 0.02475}", self.yaml(measured))
        self.assertEqual(read(os.path.join(measured, "pattern.pdf")), pdf)
        measured = self.pattern(*size, "--measured-x-mm", 148.5, "--measured-y-mm", 150)
        yaml = self.yaml(measured)
        self.assertIn("square_m: 0.024875", yaml)
        self.assertIn("[0.198000000, 0.125000000, 0.000000000]", yaml)

    def test_monitor(self):
        folder = self.pattern("star", "--columns", 16, "--rows", 9, "--square-mm", 20, "--screen",
                              "800x600", "--dpi", 101.6)
        self.assertEqual(set(os.listdir(folder)), {"pattern.yaml", "pattern.png"})
        png = read(os.path.join(folder, "pattern.png"))
        self.assertEqual(struct.unpack(">II", png[16:24]), (800, 600))
        self.assertIn("square_m: 0.011,", self.yaml(folder))  # 44 pixels of 0.25 mm

    def test_json_says_what_was_made(self):
        size = ("--columns", 9, "--rows", 6, "--square-mm", 25, "--dpi", 50, "--json", "-o")
        result = run("pattern", "chessboard", *size, self.path("json"))
        self.assert_done(result)
        self.assertEqual(json.loads(result.stdout), {"ruler_mm": 150, "boards": [
            {"id": 0, "kind": "chessboard", "columns": 9, "rows": 6, "square_m": 0.025}]})
        result = run("pattern", "chessboard", "--screen", "800x600", *size, self.path("json"))
        self.assert_done(result)
        self.assertEqual(json.loads(result.stdout)["square_px"], 72)

    def test_wrong_usage(self):
        size = ("--columns", 16, "--rows", 23, "--square-mm")
        self.refused("star", *size, 12, words=["does not fit", "--square-mm 11.4"])
        self.refused("star", *size, 11, "--segments", 7, words=["--segments"])
        self.refused("star", *size, 11, "--tags", 50, words=["--tags"])
        self.refused("star", *size, 11, "--tag-id", 580, "--boards", 9, words=["586"])
        self.refused("star", *size, 11, "--screen", "800", words=["--screen"])
        self.refused("star", *size, 11, "--measured-x-mm", 99, words=["--measured-y-mm"])
        self.refused("star", *size, 11, "--measured-x-mm", 9.9, "--measured-y-mm", 9.9,
                     words=["200 mm"])
        self.refused("charuco", *size, 8, "--marker-mm", 9, words=["marker_m"])
        self.refused("charuco", *size, 8, "--marker-mm", 6, "--dictionary", "X", words=["'X'"])
        self.refused("charuco", *size, 8, "--marker-mm", 6, "--dictionary", "DICT_4X4_250",
                     "--boards", 2, words=["204 markers each", "DICT_4X4_250", "--boards"])
        self.refused("aprilgrid", "--tag-columns", 20, "--tag-rows", 20, "--tag-mm", 5,
                     "--boards", 2, words=["586", "--boards"])
        self.refused("aprilgrid", "--tag-columns", 2, "--tag-rows", 2, "--tag-mm", 5,
                     "--boards", 0, words=["--boards"])
        self.refused("aprilgrid", "--tag-columns", 0, "--tag-rows", 5, "--tag-mm", 24,
                     words=["--tag-columns"])

    def test_every_kind_has_help_with_an_example(self):
        for kind in ("star", "chessboard", "charuco", "aprilgrid"):
            result = run("pattern", kind, "--help")
            self.assert_done(result)
            for words in ("raygrid pattern " + kind, "--measured-x-mm", "--screen"):
                self.assertIn(words, result.stdout)


if __name__ == "__main__":
    main(__name__)
