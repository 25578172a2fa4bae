#!/usr/bin/env python3
"""raygrid-camera --check: one frame, one line, and no outputs."""
import argparse
import os
import socket
import subprocess
import sys
import tempfile
import unittest

programs = argparse.Namespace()

SIZE = (128, 96)
FRAME = bytes(range(256)) * (SIZE[0] * SIZE[1] // 256)
INPUT = ("--from", "-", "--format", "R8")


class CameraCheck(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = temporary.name
        for command in (("simulate", "--images", 1, "--lens", "wide", "--size", "128x96", "-o",
                         "scene"),
                        ("pack", "scene/true_camera.yaml", "-o", "good.raygrid", "--remap",
                         "80x60,hfov=80", "--max-error-px", 1),
                        ("pack", "scene/true_camera.yaml", "-o", "rays.raygrid")):
            subprocess.run([programs.raygrid, *map(str, command)], cwd=cls.folder, check=True,
                           stdout=subprocess.DEVNULL)
        with open(os.path.join(cls.folder, "good.raygrid"), "rb") as file:
            blob = bytearray(file.read())
        blob[len(blob) // 2] ^= 1
        cls.write("damaged.raygrid", blob)
        cls.write("frame.grey", FRAME)

    @classmethod
    def write(cls, name, contents):
        with open(os.path.join(cls.folder, name), "wb") as file:
            file.write(contents)

    def check(self, blob, *arguments, **how):
        return subprocess.run([programs.camera, "--check", blob, *arguments], cwd=self.folder,
                              capture_output=True, timeout=30, check=False, text=True, **how)

    def assert_fails(self, code, word, blob, *arguments, **how):
        result = self.check(blob, *arguments, **{"stdin": subprocess.DEVNULL, **how})
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(result.stdout, "")
        self.assertRegex(result.stderr, rf"^raygrid-camera: [^\n]*{word}[^\n]*\n$")

    def test_a_check_takes_one_frame_and_writes_nothing(self):
        before = sorted(os.listdir(self.folder))
        with socket.socket() as taken:  # a server of the options could not start
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            result = self.check("good.raygrid", "--from", "frame.grey", "--format", "R8", "-o",
                                "outputs", "--http", str(taken.getsockname()[1]),
                                stdin=subprocess.DEVNULL)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        self.assertRegex(result.stdout, r"^good\.raygrid: undistorts 128x96 R8 of frame\.grey to "
                         r"80x60 in [0-9.]+ ms\n$")
        self.assertEqual(sorted(os.listdir(self.folder)), before)

    def test_a_check_of_standard_input_waits_for_one_frame_only(self):
        reader, writer = os.pipe()
        try:
            os.write(writer, FRAME)
            result = self.check("good.raygrid", *INPUT, stdin=reader)  # which stays open
        finally:
            os.close(reader)
            os.close(writer)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("128x96 R8 of standard input to 80x60", result.stdout)

    def test_what_a_check_finds_wrong(self):
        recording = ("--from", "frame.grey", "--format", "R8")
        self.assert_fails(8, "damaged.raygrid", "damaged.raygrid", *recording)
        self.assert_fails(8, "--remap", "rays.raygrid", *recording)
        self.assert_fails(2, "missing.raygrid", "missing.raygrid", *recording)
        self.assert_fails(8, "128x96", "good.raygrid", *recording, "--size", "64x48")
        self.assert_fails(2, "missing.grey", "good.raygrid", "--from", "missing.grey", "--format",
                          "R8")
        self.assert_fails(2, "/dev/missing", "good.raygrid", "--source", "v4l2:/dev/missing")
        self.assert_fails(1, "--check", "good.raygrid", *recording, "--benchmark")
        self.assert_fails(1, "--check", "good.raygrid", *recording, "--points", "x")
        self.write("header.y4m", b"YUV4MPEG2 W128 H96\n")  # and no frame
        with open(os.path.join(self.folder, "header.y4m"), "rb") as file:
            self.assert_fails(2, "before a frame came", "good.raygrid", "--from", "-", stdin=file)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    for option in ("raygrid", "camera", "undistort-frames"):
        parser.add_argument("--" + option, required=True)
    _, rest = parser.parse_known_args(namespace=programs)
    unittest.main(argv=[sys.argv[0]] + rest, verbosity=2)
