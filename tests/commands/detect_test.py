#!/usr/bin/env python3
"""Detection on folders as people have them: with other files among the photographs, twice in a row."""
import json
import os
import shutil

from command_test import CommandTest, main, read, run, write


def png_size(contents):
    return tuple(int.from_bytes(contents[at:at + 4], "big") for at in (16, 20))


def blank(width=300, height=200):
    return b"P5\n%d %d\n255\n" % (width, height) + bytes([200]) * (width * height)


class Detect(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        board = cls.path("board")
        cls.succeed("pattern", "chessboard", "--columns", 9, "--rows", 6, "--square-mm", 20,
                    "--dpi", 72, "-o", board)
        cls.pattern = os.path.join(board, "pattern.yaml")
        cls.sheet = read(os.path.join(board, "pattern.png"))
        for name in ("a.png", "b.png"):
            write(cls.path("photos/" + name), cls.sheet)

    def detect(self, images, *options):
        self.out = self.path(f"{self.id()}.csv")
        return run("detect", images, "--pattern", self.pattern, "-o", self.out, *options)

    def folder_with(self, **files):
        """The photographs and more files, as name_extension=contents."""
        folder = self.path("folder-" + self.id())
        shutil.copytree(self.path("photos"), folder)
        for name, contents in files.items():
            write(os.path.join(folder, name.replace("_", ".")), contents)
        return folder

    def test_every_corner_is_found(self):
        result = self.detect(self.path("photos"), "--no-cache", "--json")
        self.assert_done(result)
        found = json.loads(result.stdout)
        self.assertEqual((found["images"], found["images_with_features"], found["features"]), (2, 2, 108))
        self.assertEqual((found["rejected_features"], found["skipped_images"]), (0, []))
        self.assertGreaterEqual(found["elapsed_s"], 0)
        self.assertEqual(len(read(self.out).splitlines()), 109)

    def test_another_board_is_named(self):
        for spec in ("chessboard:10x7:20mm", "chessboard:8x6:20mm"):
            for command in ("detect", "calibrate"):
                out = self.path("another-board")
                self.assert_refused(
                    run(command, self.path("photos"), "--pattern", spec, "-o", out), 3,
                    "the images show 9 x 6 inner corners", "correct columns and rows in " + spec)
                self.assert_nothing_in(out)

    def test_a_board_in_a_word_is_found_like_that_of_a_file(self):
        self.assert_done(self.detect(self.path("photos"), "--no-cache"))
        features = read(self.out)
        self.pattern = "chessboard:9x6:20mm"
        self.assert_done(self.detect(self.path("photos"), "--no-cache"))
        self.assertEqual(read(self.out), features)

    def test_damaged_image_among_others_is_named_and_skipped(self):
        result = self.detect(self.folder_with(aa_png=self.sheet[:len(self.sheet) // 2]),
                             "--no-cache", "--json")
        self.assert_done(result)
        self.assertIn("aa.png", result.stderr)
        found = json.loads(result.stdout)
        self.assertEqual(found["images"], 3)
        self.assertEqual([skipped["image"] for skipped in found["skipped_images"]], ["aa.png"])
        self.assertIn("corrupt", found["skipped_images"][0]["reason"])
        self.assertNotIn(b"aa.png", read(self.out))

    def test_image_of_another_size_is_named_and_skipped(self):
        result = self.detect(self.folder_with(c_pgm=blank()), "--no-cache")
        self.assert_done(result)
        self.assertIn("c.pgm", result.stderr)
        self.assertIn("300 x 200", result.stderr)

    def test_no_image_that_can_be_read(self):
        write(self.path("text/a.png"), "no image")
        self.assert_refused(self.detect(self.path("text"), "--no-cache"), 2, "a.png", "not an image")

    def test_no_board_in_any_image(self):
        write(self.path("blank/a.pgm"), blank())
        self.assert_refused(self.detect(self.path("blank"), "--no-cache"), 3, "no target")
        self.assertFalse(os.path.exists(self.out))

    def test_images_without_a_board_are_named_with_what_they_show(self):
        folder = self.path("stars")
        for tag in (0, 5):
            board = self.path(f"star{tag}")
            self.succeed("pattern", "star", "--columns", 10, "--rows", 8, "--square-mm", 12,
                         "--dpi", 110, "--tag-id", tag, "-o", board)
            write(os.path.join(folder, f"tag{tag}.png"), read(os.path.join(board, "pattern.png")))
        self.pattern = self.path("star0/pattern.yaml")
        result = self.detect(folder, "--no-cache", "--json")
        self.assert_done(result)
        found = json.loads(result.stdout)
        self.assertEqual((found["images"], found["images_with_features"]), (2, 1))
        (without,) = found["images_without_features"]
        self.assertEqual(without["image"], "tag5.png")
        self.assertIn("tag 5 is not in the pattern", without["reasons"])
        self.assertIn("tag 5 is not in the pattern (tag5.png)", result.stderr)
        self.assertEqual(self.detect(folder, "--no-cache", "--quiet").stderr, "")

    def test_images_without_a_board_are_named_in_the_text_as_well(self):
        size = png_size(self.sheet)
        folder = self.folder_with(blank_pgm=blank(*size), empty_pgm=blank(*size))
        result = self.detect(folder, "--no-cache")
        self.assert_done(result)
        self.assertIn("no target found in blank.pgm, empty.pgm\n", result.stderr)
        self.assertEqual(self.detect(folder, "--no-cache", "--quiet").stderr, "")

    def test_overlays_show_every_image_and_the_coverage(self):
        seen = self.path("seen")
        folder = self.folder_with(blank_pgm=blank(*png_size(self.sheet)))
        self.assert_done(self.detect(folder, "--no-cache", "--overlay", seen))
        self.assertEqual(sorted(os.listdir(seen)),
                         ["a.png", "b.png", "blank.pgm.png", "coverage.png"])
        for name in os.listdir(seen):
            self.assertGreater(png_size(read(os.path.join(seen, name)))[0], 100)

    def test_cache_changes_nothing_but_the_time(self):
        cache = self.path("cache")
        self.assert_done(self.detect(self.path("photos"), "--no-cache"))
        without = read(self.out)
        for _ in range(2):
            self.assert_done(self.detect(self.path("photos"), "--cache", cache))
            self.assertEqual(read(self.out), without)
        self.assertEqual(len(os.listdir(cache)), 1)  # the two images are the same

    def test_damaged_cache_is_rewritten(self):
        cache = self.path("old-cache")
        self.assert_done(self.detect(self.path("photos"), "--cache", cache))
        good, features = {}, read(self.out)
        for name in os.listdir(cache):
            good[name] = read(os.path.join(cache, name))
            write(os.path.join(cache, name), good[name][:-20] + b"0" * 20)
        self.assert_done(self.detect(self.path("photos"), "--cache", cache))
        self.assertEqual(read(self.out), features)
        for name, contents in good.items():
            self.assertEqual(read(os.path.join(cache, name)), contents)

    def test_cache_that_cannot_be_written_is_done_without(self):
        file = write(self.path("file"), "in the way")
        self.assert_done(self.detect(self.path("photos"), "--cache", os.path.join(file, "cache")))

    def test_number_of_threads_changes_nothing(self):
        outputs = set()
        for threads in (1, 2, 3):
            self.assert_done(self.detect(self.path("photos"), "--no-cache", "--threads", threads))
            outputs.add(read(self.out))
        self.assertEqual(len(outputs), 1)

    def test_every_refinement_finds_the_board(self):
        for name in ("intensities", "gradients-xy", "gradient-magnitude", "corner-subpix", "none"):
            with self.subTest(name):
                result = self.detect(self.path("photos"), "--no-cache", "--refinement", name,
                                     "--json")
                self.assert_done(result)
                self.assertEqual(json.loads(result.stdout)["images_with_features"], 2)

    def test_wrong_options(self):
        for options in (("--window", 20), ("--window", 3), ("--window", 103), ("--window", "x"),
                        ("--refinement", "magic")):
            with self.subTest(options):
                self.assert_refused(self.detect(self.path("photos"), *options), 1, options[0])


if __name__ == "__main__":
    main(__name__)
