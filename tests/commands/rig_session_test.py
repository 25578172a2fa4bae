#!/usr/bin/env python3
"""raygrid capture of a rig: frames of one instant become a session, and that a rig."""
import glob
import json
import os
import shutil

from command_test import CommandTest, main, read, run, write
from png_files import png, read_png

BOARD = "charuco:8x5:28mm:marker=21mm"
NUM_INSTANTS = 24
WIDTH, HEIGHT, SHARED = 480, 240, 240
OWN = (WIDTH + SHARED) // 2


class RigSession(CommandTest):
    """Two cameras that see one lens's left and right part: they stand at one place."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.succeed("simulate", "--render", "--images", NUM_INSTANTS, "--lens", "wide", "--size",
                    f"{WIDTH}x{HEIGHT}", "--min-square-px", 13, "--max-square-px", 22, "--pattern", BOARD,
                    "-o", cls.path("simulated"))
        cls.videos = {}
        for name, first in (("left", 0), ("right", WIDTH - OWN)):
            os.makedirs(cls.path(name))
            frames = b""
            for path in sorted(glob.glob(cls.path("simulated/*.png"))):
                pixels = bytes(read_png(path)[2])
                rows = b"".join(pixels[y * WIDTH + first:y * WIDTH + first + OWN] for y in range(HEIGHT))
                write(os.path.join(cls.path(name), os.path.basename(path)), png(rows, (OWN, HEIGHT)))
                frames += (b"FRAME\n" + rows) * 3
            header = f"YUV4MPEG2 W{OWN} H{HEIGHT} F30:1 Ip A1:1 Cmono\n".encode()
            cls.videos[name] = write(cls.path(f"{name}.y4m"), header + frames)

    def setUp(self):
        self.session = self.path("session-" + self.id().rsplit(".", 1)[1])

    def capture(self, *options, sources=None):
        if sources is None:
            sources = [f"left={self.path('left')}", f"right={self.path('right')}"]
        given = [word for source in sources for word in ("--source", source)]
        return run("capture", *given, "--pattern", BOARD, "-o", self.session, *options)

    def cameras(self):
        told = json.loads(read(os.path.join(self.session, "session.json")))["cameras"]
        return {camera["name"]: [frame["image"] for frame in camera["frames"]] for camera in told}

    def test_two_folders_become_a_rig(self):
        result = self.capture()
        self.assertIn(result.returncode, (0, 6), result.stderr)
        cameras = self.cameras()
        self.assertEqual(list(cameras), ["left", "right"])
        for name, images in cameras.items():
            self.assertGreaterEqual(len(images), 4)
            self.assertEqual(sorted(images), sorted(os.listdir(os.path.join(self.session, "frames", name))))
            for image in images:
                self.assertEqual(read(os.path.join(self.session, "frames", name, image)),
                                 read(os.path.join(self.path(name), image)))
        # Instants of both are there, and of either.
        self.assertGreaterEqual(len(set(cameras["left"]) & set(cameras["right"])), 3)
        rig = json.loads(read(os.path.join(self.session, "calibration/result.json")))
        self.assertEqual([camera["name"] for camera in rig["cameras"]], ["left", "right"])
        poses = json.loads(run("inspect", os.path.join(self.session, "calibration/rig.yaml"),
                               "--json").stdout)
        place = poses["cameras"][1]["center_in_rig_m"]
        self.assertLess(max(abs(value) for value in place), 1e-3)

    def test_videos_give_the_same_bytes_again(self):
        sessions = []
        for threads in (1, 2):
            self.assert_done(self.capture(
                "--no-calibrate", "--threads", threads,
                sources=[f"{name}={path}" for name, path in self.videos.items()]))
            sessions.append(read(os.path.join(self.session, "session.json")))
            shutil.rmtree(self.session)
        self.assertEqual(sessions[0], sessions[1])
        self.assertIn(b"frame-0001.png", sessions[0])

    def test_a_session_goes_on_with_the_same_cameras(self):
        self.assert_done(self.capture("--no-calibrate"))
        before = self.cameras()
        self.assert_done(self.capture("--no-calibrate", "--resume"))
        self.assertEqual({name: images[:len(before[name])] for name, images in self.cameras().items()},
                         before)
        self.assert_refused(self.capture("--resume", sources=[self.path("left")]), 1, "left, right")
        self.assert_refused(
            self.capture("--resume", sources=[f"right={self.path('right')}", f"left={self.path('left')}"]),
            1, "in this order")

    def test_names_of_cameras(self):
        left, right = self.path("left"), self.path("right")
        for sources, words in (((left, right), "NAME=SOURCE"),
                               ((f"a={left}", f"a={right}"), "duplicate camera name"),
                               ((f"a/b={left}", f"c={right}"), "letters, digits"),
                               ((f"a={left}", f"b={right}", f"c={right}"), "same source as camera b"),
                               ((f"a={left}", f"b={right}/../left"), "same source as camera a"),
                               (("a=v4l2:/dev/null", "b=v4l2:/dev/../dev/null"), "same source as camera a")):
            self.assert_refused(self.capture(sources=sources), 1, words)
            self.assertFalse(os.path.exists(self.session))

    def test_cameras_that_see_no_board_together_are_named(self):
        os.makedirs(self.path("other"))
        for image in os.listdir(self.path("right")):
            shutil.copy(os.path.join(self.path("right"), image), self.path("other/of-" + image))
        result = self.capture("--no-calibrate", sources=[f"left={self.path('left')}",
                                                         f"right={self.path('other')}"])
        self.assert_done(result)
        self.assertIn("no common view of left and right yet", result.stderr)


if __name__ == "__main__":
    main(__name__)
