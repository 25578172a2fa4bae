#!/usr/bin/env python3
"""Images of sizes that cameras do not have: named in one line, and the others are gone on with."""
import struct
import zlib

from command_test import CommandTest, SIMULATED_PATTERN, main, run, specifications, write
from images_test import chunk, png


def black_png(width, height):
    """Few bytes, many pixels."""
    deflate = zlib.compressobj(9)
    rows = b"".join(deflate.compress(bytes(1 + width)) for _ in range(height)) + deflate.flush()
    return (b"\x89PNG\r\n\x1a\n" +
            chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", rows) + chunk(b"IEND", b""))


class ImageSize(CommandTest):
    def detect(self, *images, pattern):
        return run("detect", *images, "--pattern", pattern, "-o", self.path("f.csv"),
                   "--no-cache", "--threads", 1)

    def test_too_small_for_a_board(self):
        for width, height in ((1, 1), (2, 2), (1, 40), (40, 1), (2, 16384)):
            path = write(self.path(f"{width}x{height}.png"),
                         png([128] * (width * height), size=(width, height)))
            for board in specifications():
                with self.subTest(board=board, size=(width, height)):
                    self.assert_refused(self.detect(path, pattern=board), 2,
                                        f"{width} x {height} pixels", "too small to show a board")

    def test_as_long_as_images_may_be(self):
        for width, height in ((16384, 40), (40, 16384), (16383, 40)):
            path = write(self.path(f"{width}x{height}.png"),
                         png([128] * (width * height), size=(width, height)))
            for board in specifications():
                with self.subTest(board=board, size=(width, height)):
                    self.assert_refused(self.detect(path, pattern=board), 3, "no target found")

    def test_longer_than_libraries_count(self):
        path = write(self.path("long.png"), png([128] * 65535 * 33, size=(65535, 33)))
        for board in specifications():
            with self.subTest(board=board):
                result = run("detect", path, "--pattern", board, "-o", self.path("f.csv"),
                             "--no-cache", "--threads", 1, "--allow-huge-images")
                self.assert_refused(result, 3, "no target found")

    def test_the_others_are_gone_on_with(self):
        pattern = write(self.path("board.yaml"), SIMULATED_PATTERN)
        self.succeed("simulate", "--render", "--images", 3, "--lens", "wide", "--size",
                     "320x240", "--samples-per-pixel", 1, "--pattern", pattern, "-o",
                     self.path("sim"))
        write(self.path("sim/tiny.png"), png([0], size=(1, 1)))
        result = self.detect(self.path("sim"), pattern=pattern)
        self.assert_done(result)
        self.assertIn("tiny.png: skipped: 1 x 1 pixels, too small to show a board", result.stderr)

    def test_many_pixels_of_few_bytes(self):
        for width, height in ((16000, 16000), (8000, 8000)):
            path = write(self.path("black.png"), black_png(width, height))
            for board in specifications():
                self.assert_refused(self.detect(path, pattern=board), 2,
                                    f"{width} x {height} pixels", "bytes", "--allow-huge-images")


if __name__ == "__main__":
    main(__name__)
