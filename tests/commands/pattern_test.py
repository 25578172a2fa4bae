#!/usr/bin/env python3
"""Targets to print and to show: the pattern command."""
import json
import os
import struct

from command_test import CommandTest, commands, main, read, run


class PatternCommand(CommandTest):
    def pattern(self, kind, *arguments):
        """A target with a small PNG, in a folder of its own."""
        folder = self.path(self.id() + "-" + kind)
        result = self.succeed("pattern", kind, *arguments, "-o", folder)
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
        folder = self.pattern("aprilgrid", "--tag-columns", 6, "--tag-rows", 5, "--tag-mm", 24,
                              "--no-squares", "--family", "DICT_4X4_50", "--dpi", 50)
        self.assertIn("tag_family: DICT_4X4_50, spacing_ratio: 0.3, corner_squares: false}",
                      self.yaml(folder))

    def test_a_chessboard_that_looks_alike_after_a_turn_is_named(self):
        for columns, rows, words in ((7, 5, "under half a turn"), (6, 6, "under a quarter turn"), (9, 6, "")):
            result = self.succeed("pattern", "chessboard", "--columns", columns, "--rows", rows, "--square-mm", 20,
                                  "--dpi", 50, "-o", self.path(f"turned-{columns}x{rows}"))
            self.assertIn(words, result.stderr)
            self.assertEqual(f"--rows {rows + 1}" in result.stderr, words != "")

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
        star = ("star", "--columns", 16, "--rows", 9, "--screen", "800x600", "--square-mm")
        folder = self.pattern(*star, 8.3, "--dpi", 101.6)
        self.assertEqual(set(os.listdir(folder)), {"pattern.yaml", "pattern.png"})
        png = read(os.path.join(folder, "pattern.png"))
        self.assertEqual(struct.unpack(">II", png[16:24]), (800, 600))
        self.assertIn("square_m: 0.00825,", self.yaml(folder))  # 33 pixels of 0.25 mm
        self.refused(*star, 20, "--dpi", 101.6, words=["80 pixels", "at most 44"])
        self.refused(*star, 20, "--square-px", 45, words=["at most 44"])

    def test_what_to_measure_on_a_monitor_and_to_type_then(self):
        def made(kind, *arguments):
            folder = self.path(self.id())
            result = run("pattern", kind, "--screen", "1920x1080", *arguments, "-o", folder)
            self.assert_done(result)
            return read(os.path.join(folder, "pattern.png")), self.yaml(folder), result.stdout
        star = ("star", "--columns", 16, "--rows", 23)
        picture, yaml, said = made(*star, "--dpi", 92, "--square-mm", 10)
        self.assertIn("square_m: 0.00993913043,", yaml)  # 36 pixels, not as large as fits
        self.assertIn("measure 22 squares on the screen, from the first star's centre of a column "
                      "to the last: 218.66 mm", said)
        self.assertIn("with --square-px 36 --square-mm L/22 and without --dpi", said)
        again, yaml, said = made(*star, "--square-px", 36, "--square-mm", 220 / 22)
        self.assertEqual(picture, again)
        self.assertIn("square_m: 0.01,", yaml)
        self.assertIn("with --square-px 36 --square-mm L/22\n", said)
        _, _, said = made("chessboard", "--columns", 9, "--rows", 6, "--square-mm", 25)
        self.assertIn("measure 8 squares", said)
        self.assertIn("from the first inner corner of a row to the last: 200.00 mm", said)
        self.assertIn("run this command again with --square-mm L/8\n", said)
        _, _, said = made("aprilgrid", "--tag-columns", 6, "--tag-rows", 3, "--tag-mm", 20)
        self.assertIn("again with --tag-mm L/7.5\n", said)

    def test_json_says_what_was_made(self):
        size = ("--columns", 9, "--rows", 6, "--square-mm", 25, "--dpi", 50, "--json", "-o")
        result = self.succeed("pattern", "chessboard", *size, self.path("json"))
        self.assertEqual(json.loads(result.stdout), {"schema_version": 2, "ruler_mm": 150, "boards": [
            {"id": 0, "kind": "chessboard", "columns": 9, "rows": 6, "square_m": 0.025}]})
        result = self.succeed("pattern", "chessboard", "--screen", "800x600", *size, self.path("json"))
        made = json.loads(result.stdout)
        self.assertEqual((made["square_px"], made["squares_to_measure"]), (49, 8))  # at 50 dpi

    def test_lengths_that_look_like_mistakes_are_asked_about(self):
        size = ("--columns", 9, "--rows", 6, "--square-mm")
        for kind, arguments, words in (
                ("chessboard", (*size, 0.025), ["--square-mm 25?", "0.025 mm", "--yes"]),
                ("chessboard", (*size, 25000, "--screen", "800x600"), ["--square-mm 25?", "25 m"]),
                ("chessboard", (*size, 900), ["board of 7.2 m is", "--square-mm 900", "--yes"]),
                ("aprilgrid", ("--tag-columns", 6, "--tag-rows", 5, "--tag-mm", 0.03),
                 ["--tag-mm 30?", "--yes"])):
            self.refused(kind, *arguments, words=words)
        self.pattern("chessboard", *size, 0.5, "--dpi", 30, "--yes")
        for spec, words in (("chessboard:9x6:25m", ["squares of 25 mm?", "25 m", "--yes"]),
                            ("chessboard:9x6:0.025mm", ["squares of 25 mm?", "--yes"]),
                            ("chessboard:9x6:0.9m", ["a board of 7.2 m is", "--yes"])):
            for command in (("detect", self.folder, "-o", self.path("never.csv")),
                            ("calibrate", "--features", self.path("none.csv"), "--image-size",
                             "640x480", "-o", self.path("never"))):
                features = "image,board,column,row,x,y\na.png,0,0,0,1,2\n"
                with open(self.path("none.csv"), "w", encoding="utf8") as file:
                    file.write(features)
                result = run(*command, "--pattern", spec)
                self.assert_refused(result, 1, spec, *words)
                self.assertNotIn("accept with --yes", run(*command, "--pattern", spec,
                                                         "--yes").stderr)

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

    def test_a_board_in_a_word_is_that_of_the_command(self):
        def boards(yaml):
            return [line for line in yaml.splitlines() if line.startswith("  - ")]
        for spec, kind, arguments in (
                ("chessboard:9x6:25mm", "chessboard", "--columns 9 --rows 6 --square-mm 25"),
                ("charuco:6x4:2.5cm:marker=18mm", "charuco",
                 "--columns 6 --rows 4 --square-mm 25 --marker-mm 18"),
                ("charuco:6x5:25mm:legacy:marker=18mm:dictionary=DICT_5X5_100:boards=2:"
                 "first-marker=3", "charuco",
                 "--columns 6 --rows 5 --square-mm 25 --marker-mm 18 --legacy --boards 2 "
                 "--first-marker 3 --dictionary DICT_5X5_100"),
                ("aprilgrid:6x5:0.024m:spacing-ratio=0.25", "aprilgrid",
                 "--tag-columns 6 --tag-rows 5 --tag-mm 24 --spacing-ratio 0.25"),
                ("aprilgrid:6x5:24mm:no-squares:border-cells=2:numbered-from=bottom:family=tag25h9",
                 "aprilgrid", "--tag-columns 6 --tag-rows 5 --tag-mm 24 --no-squares --border-cells 2 "
                 "--numbered-from bottom --family tag25h9"),
                ("star:16x23:11.132mm", "star", "--columns 16 --rows 23 --square-mm 11.132"),
                ("star:12x9:15mm:segments=8:tags=2:tag-id=10:tag-squares=2:boards=2", "star",
                 "--columns 12 --rows 9 --square-mm 15 --segments 8 --tags 2 --tag-id 10 "
                 "--tag-squares 2 --boards 2")):
            folder = self.pattern(kind, *arguments.split(), "--dpi", 30)
            seen = self.path(self.id())
            self.succeed("simulate", "--pattern", spec, "--images", 1, "-o", seen)
            self.assertEqual(boards(self.yaml(seen)), boards(self.yaml(folder)), spec)
        result = run("inspect", "charuco:8x5:28mm:marker=21mm")
        self.assert_done(result)
        self.assertIn("kind 'charuco', features 8 x 5, square 0.028 m", result.stdout)

    def test_a_word_that_is_no_board_is_refused_by_name(self):
        for spec, words in (
                ("chessboard:9x6", "COLUMNSxROWS:LENGTH"),
                ("chessboard:9x6:25", "'25' is not a length"),
                ("chessboard:9x6:-25mm", "not a length"),
                ("chessboard:9x6:25mm:marker=3mm", "not support 'marker'"),
                ("chessboard:9x:25mm", "'9x' is not a size"),
                ("chessboard:9x6a:25mm", "not a size"),
                ("chessboard:1x6:25mm", "2 to 1000"),
                ("chessboard:99999999999x6:25mm", "not a size"),
                ("chesboard:9x6:25mm", "known target kind: 'chesboard'"),
                ("charuco:6x4:25mm", "marker="),
                ("charuco:6x4:25mm:marker=30mm", "marker_m"),
                ("charuco:6x4:25mm:marker=18mm:marker=18mm", "duplicate 'marker'"),
                ("charuco:6x4:25mm:marker=18mm:first-marker=1.5", "first-marker=1.5"),
                ("charuco:6x4:25mm:marker=18mm:dictionary=X", "'X'"),
                ("aprilgrid:501x6:25mm", "500"),
                ("aprilgrid:5x6:25mm:numbered-from=left", "top or bottom"),
                ("aprilgrid:5x6:25mm:family=DICT_4X4_50", "corner_squares: false"),
                ("star:16x23:11mm:tags=", "'tags' requires a value"),
                ("star:16x23:11mm:segments=7", "--segments")):
            self.assert_refused(run("detect", self.folder, "--pattern", spec, "-o",
                                    self.path("never.csv")), 1, spec, words)

    def test_every_kind_has_help_with_an_example(self):
        for kind in commands("pattern"):
            result = self.succeed("pattern", kind, "--help")
            for words in ("raygrid pattern " + kind, "--measured-x-mm", "--screen"):
                self.assertIn(words, result.stdout)


if __name__ == "__main__":
    main(__name__)
