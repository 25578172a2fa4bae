#!/usr/bin/env python3
"""raygrid-camera with a recording instead of a camera: outputs, ends, and bad input."""
import argparse
import glob
import os
import random
import re
import resource
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.request
import zlib

import machine

programs = argparse.Namespace()

WIDTH, HEIGHT, COUNT = 160, 120, 7
FRAME_SIZE = 2 * WIDTH * HEIGHT
# A camera.yaml that trusts the middle of the image, in cells of 16 pixels.
TRUST = ("uncertainty: {columns: 2, rows: 2, deviation_px: [[0.1, 0.1], [0.1, 0.1]]}\n"
         "trusted: {max_deviation_px: 1, cell_px: 16, cells: ["
         + ", ".join('"' + "".join(".#"[3 < i < 7 and j < 6] for i in range(10)) + '"'
                     for j in range(8)) + "]}\n")
MAX_SECONDS = 300  # a program that takes longer hangs


def free_port():
    """A port that nothing uses. Linux gives ports from 32768 on to others meanwhile."""
    while True:
        port = random.randrange(20000, 32768)
        with socket.socket() as free:
            try:
                free.bind(("127.0.0.1", port))
                return port
            except OSError:
                pass


class CameraProgram(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = temporary.name
        cls.run_raygrid("simulate", "--images", 1, "--lens", "wide", "--size", "160x120", "-o",
                        "scene")
        cls.write("known.yaml", cls.read("scene/true_camera.yaml") + TRUST.encode())
        for command in (
                ("pack", "scene/true_camera.yaml", "-o", "flat.raygrid", "--remap",
                 "160x120,hfov=80"),
                ("pack", "known.yaml", "-o", "modes.raygrid", "--remap",
                 "160x120,hfov=80,center=79.5,59.5", "--mode", "part:crop=20,10,80,60", "--mode",
                 "corner:crop=0,0,40,30"),
                ("pack", "known.yaml", "-o", "trusted.raygrid", "--remap",
                 "160x120,hfov=80,center=79.5,59.5", "--mode", "part:crop=20,10,80,60",
                 "--outside", "border"),
                ("pack", "scene/true_camera.yaml", "-o", "distorting.raygrid", "--remap",
                 "160x120,hfov=80,direction=distort", "--max-error-px", 2),
                ("pack", "scene/true_camera.yaml", "-o", "stood.raygrid", "--remap",
                 "160x120,hfov=80", "--capture-settings", "crop=0,0,320,240,lens=2,orientation=1"),
                ("pack", "scene/true_camera.yaml", "-o", "rays.raygrid")):
            cls.run_raygrid(*command)
        grey = bytes((3 * x + y * y) & 255 for y in range(HEIGHT) for x in range(WIDTH))
        frames = machine.make_frames([grey], WIDTH, HEIGHT, COUNT)
        cls.write("frames.yuyv", b"".join(frames))
        subprocess.run([programs.undistort_frames, "flat.raygrid", "frames.yuyv", "undistorted"],
                       cwd=cls.folder, check=True)
        expected = cls.read("undistorted")
        cls.expected = [expected[i * FRAME_SIZE:(i + 1) * FRAME_SIZE] for i in range(COUNT)]

    @classmethod
    def run_raygrid(cls, *arguments):
        subprocess.run([programs.raygrid, *map(str, arguments)], cwd=cls.folder, check=True,
                       stdout=subprocess.DEVNULL)

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder, name)

    @classmethod
    def write(cls, name, contents):
        with open(cls.path(name), "wb") as file:
            file.write(contents)

    @classmethod
    def read(cls, name):
        with open(cls.path(name), "rb") as file:
            return file.read()

    def start(self, *arguments, **how):
        """The program with the recording, in the folder of the test."""
        # pylint: disable=consider-using-with
        process = subprocess.Popen(
            [programs.camera, "flat.raygrid", "--from", "frames.yuyv", "--format", "YUYV",
             *map(str, arguments)],
            cwd=self.folder, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE,
            **{"stdout": subprocess.PIPE, **how})
        self.addCleanup(process.stderr.close)
        if process.stdout:
            self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def run_program(self, *arguments):
        return subprocess.run([programs.camera, *map(str, arguments)], cwd=self.folder,
                              stdin=subprocess.DEVNULL, capture_output=True, timeout=MAX_SECONDS,
                              check=False)

    def assert_fails(self, code, *arguments, words=()):
        result = self.run_program(*arguments)
        error = result.stderr.decode()
        self.assertEqual(result.returncode, code, error)
        self.assertEqual(error.count("\n"), 1, error)
        self.assertTrue(error.startswith("raygrid-camera: "), error)
        for word in words:
            self.assertIn(word, error)

    def wait_for(self, process, is_so):
        """Until something is so of a program that runs."""
        end = time.monotonic() + MAX_SECONDS
        while not is_so():
            self.assertIsNone(process.poll(), "it ended too early")
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)

    def wait_until_caught(self, process, number):
        """Until the program has a handler of a signal."""
        def is_caught():
            with open(f"/proc/{process.pid}/status", encoding="utf-8") as file:
                caught = re.search(r"^SigCgt:\s*(\w+)", file.read(), re.MULTILINE).group(1)
            return int(caught, 16) >> (number - 1) & 1
        self.wait_for(process, is_caught)

    def assert_ends(self, process, code, number=None):
        """Ends by itself, or after a signal."""
        if number:
            process.send_signal(number)
        process.wait(timeout=MAX_SECONDS)
        error = process.stderr.read().decode()
        self.assertEqual(process.returncode, code, error)
        return error

    # ---- Outputs ----

    def frames_in(self, folder):
        result = []
        for name in sorted(os.listdir(self.path(folder))):
            self.assertRegex(name, r"^frame-[0-9]{6}\.raw$")
            header, _, planes = self.read(os.path.join(folder, name)).partition(b"\n...\n")
            self.assertTrue(header.startswith(b"raygrid_frame: 1\nformat: YUYV\nsize: [160, 120]\n"
                                              b"planes: [38400]\nsequence: "), header)
            result.append(planes)
        return result

    def test_files_are_the_runtimes_frames_in_order(self):
        process = self.start("--frames", 20, "--every-frame", "--fps", 1000, "-o", "raw")
        process.wait(timeout=MAX_SECONDS)
        self.assertEqual(process.returncode, 0)
        self.assertEqual(self.frames_in("raw"), [self.expected[i % COUNT] for i in range(20)])
        self.assertIn(b"20 delivered, 0 dropped", process.stderr.read())

    def undistorted(self, blob, table, frame, size, *arguments):
        """Brightness of a grey YUYV frame that rises to the right and downwards."""
        self.write("rising.yuyv", bytes(value for y, x in frame for value in (40 + x + y // 3, 128)))
        result = self.run_program(blob, "--table", table, "--from", "rising.yuyv", "--format",
                                  "YUYV", "--size", size, "--frames", 1, "--every-frame", "-o",
                                  "-", "--quiet", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(len(result.stdout), FRAME_SIZE)
        return result.stdout[::2]

    def test_a_table_of_a_mode_takes_the_modes_frames(self):
        whole = self.undistorted("modes.raygrid", 0, [(y, x) for y in range(HEIGHT)
                                                      for x in range(WIDTH)], "160x120")
        part = self.undistorted("modes.raygrid", 1, [(y, x) for y in range(10, 70)
                                                     for x in range(20, 100)], "80x60")
        seen = [(a, b) for a, b in zip(whole, part) if b >= 40]  # else border
        self.assertGreater(len(seen), 2000)
        self.assertLess(max(abs(a - b) for a, b in seen), 3)
        for table, blob, words in ((9, "modes.raygrid", "has no remap table 9, only 0 to 2; "),
                                   (0, "rays.raygrid", "has no remap table; ")):
            self.assert_fails(8, blob, "--table", table, "--from", "frames.yuyv", "--format",
                              "YUYV", words=[words])
        self.assert_fails(8, "modes.raygrid", "--table", 1, "--from", "frames.yuyv", "--format",
                          "YUYV", "--size", "160x120", words=["80x60", "pack --mode"])

    @staticmethod
    def border_blocks(pixels):
        """Row and column of the blocks of 8 x 8 pixels that are all border."""
        return ({(y, x) for y in range(HEIGHT // 8) for x in range(WIDTH // 8)}
                - {(k // WIDTH // 8, k % WIDTH // 8) for k, value in enumerate(pixels)
                   if value != 16})

    def test_only_what_is_trusted_is_shown(self):
        for table, size, frame in ((0, "160x120", [(y, x) for y in range(HEIGHT)
                                                   for x in range(WIDTH)]),
                                   (1, "80x60", [(y, x) for y in range(10, 70)
                                                 for x in range(20, 100)])):
            filled = self.undistorted("modes.raygrid", table, frame, size, "--outside", "fill")
            shown = self.undistorted("modes.raygrid", table, frame, size, "--outside", "border")
            packed = self.undistorted("trusted.raygrid", table, frame, size)
            of_program, of_table, of_area = map(self.border_blocks, (shown, packed, filled))
            # The table leaves out blocks of 16 pixels, or of 8.
            self.assertGreater(len(of_table - of_area), 40)
            self.assertEqual(of_table - of_program, set())
            self.assertLess(len(of_program - of_table), 60)
            self.assertGreater(300 - len(of_program), 30)
            for k, value in enumerate(shown):
                is_hidden = (k // WIDTH // 8, k % WIDTH // 8) in of_program
                self.assertEqual(value, 16 if is_hidden else filled[k], k)
        recording = ("--from", "frames.yuyv", "--format", "YUYV", "--outside", "border")
        self.assert_fails(1, "flat.raygrid", *recording, words=["flat.raygrid", "--outside",
                                                                "camera.yaml"])
        self.assert_fails(8, "modes.raygrid", "--table", 2, "--size", "40x30", *recording,
                          words=["no pixel in the valid region", "--outside"])

    def test_a_pipe_holds_the_same_planes(self):
        process = self.start("--frames", 20, "--every-frame", "--fps", 1000, "-o", "-")
        output, error = process.communicate(timeout=MAX_SECONDS)
        self.assertEqual(process.returncode, 0)
        self.assertEqual(output, b"".join(self.expected[i % COUNT] for i in range(20)))
        self.assertIn(b"ffplay -f rawvideo -pixel_format yuyv422 -video_size 160x120", error)
        self.assertIn(b"rawvideoparse format=yuy2 width=160 height=120", error)

    # ---- Standard input ----

    def run_with_input(self, data, *arguments, blob="flat.raygrid"):
        return subprocess.run(
            [programs.camera, blob, "--from", "-", *map(str, arguments)],
            cwd=self.folder, input=data, capture_output=True, timeout=MAX_SECONDS, check=False)

    def test_raw_frames_of_standard_input(self):
        result = self.run_with_input(self.read("frames.yuyv"), "--format", "YUYV", "--every-frame",
                                     "-o", "-")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stdout, b"".join(self.expected))
        self.assertIn(b"7 arrived, 7 undistorted, 7 delivered, 0 dropped", result.stderr)
        # A file waits by itself.
        with open(self.path("frames.yuyv"), "rb") as file:
            result = subprocess.run(
                [programs.camera, "flat.raygrid", "--from", "-", "--format", "YUYV", "-o", "-"],
                cwd=self.folder, stdin=file, capture_output=True, timeout=MAX_SECONDS, check=True)
        self.assertEqual(result.stdout, b"".join(self.expected))
        result = self.run_with_input(self.read("frames.yuyv")[:-1], "--format", "YUYV",
                                     "--every-frame", "-o", "-")
        self.assertEqual(result.returncode, 2)
        self.assertEqual(result.stdout, b"".join(self.expected[:-1]))
        self.assertIn(b"raygrid-camera: standard input: ended within a frame; check --size",
                      result.stderr)

    def test_every_frame_of_a_pipe_or_file_is_written(self):
        frames = self.read("frames.yuyv")
        count = 40 * COUNT
        result = self.run_with_input(40 * frames, "--format", "YUYV", "--png", "-o", "of_pipe")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(sorted(os.listdir(self.path("of_pipe"))),
                         [f"frame-{k:06}.png" for k in range(count)])
        self.assertIn(b"%d delivered, 0 dropped" % count, result.stderr)
        result = self.run_program("flat.raygrid", "--from", "frames.yuyv", "--format", "YUYV",
                                  "--fps", 10000, "--frames", 50, "--png", "-o", "of_file")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(sorted(os.listdir(self.path("of_file"))),
                         [f"frame-{k:06}.png" for k in range(50)])
        # A reader that begins late, when all that can wait does.
        with subprocess.Popen([programs.camera, "flat.raygrid", "--from", "-", "--format", "YUYV",
                               "--quiet", "-o", "-"], cwd=self.folder, stdin=subprocess.PIPE,
                              stdout=subprocess.PIPE) as process:
            writer = threading.Thread(target=lambda: (process.stdin.write(5 * frames),
                                                      process.stdin.close()))
            writer.start()
            time.sleep(0.5)
            self.assertEqual(process.stdout.read(), 5 * b"".join(self.expected))
            writer.join()

    def test_numbers_of_files_show_what_is_missing(self):
        _, port = self.serve()
        good = self.pictures(port, "/before", 1)[0]
        damaged = good[:len(good) // 2] + b"\xff\xd9"
        for k, pictures in enumerate(((good, damaged, good), (good, damaged, damaged, good, good))):
            result = self.run_with_input(b"".join(pictures), "-o", f"gaps{k}")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(sorted(os.listdir(self.path(f"gaps{k}"))),
                             [f"frame-{number:06}.raw" for number, picture in enumerate(pictures)
                              if picture is good])
        # Frames that are given up, wherever that happens.
        result = self.run_with_input(40 * self.read("frames.yuyv"), "--format", "YUYV", "--live",
                                     "-o", "live")
        self.assertEqual(result.returncode, 0, result.stderr)
        counts = re.search(rb"(\d+) arrived.* (\d+) delivered, (\d+) dropped", result.stderr).groups()
        arrived, taken, dropped = map(int, counts)
        self.assertEqual((arrived, taken + dropped), (40 * COUNT, 40 * COUNT))
        names = sorted(os.listdir(self.path("live")))
        self.assertEqual(len(names), taken)
        sequences = [int(re.search(rb"\nsequence: (\d+)\n", self.read(f"live/{name}")).group(1))
                     for name in names]
        self.assertEqual(names, [f"frame-{number - sequences[0]:06}.raw" for number in sequences])

    def test_y4m_of_standard_input(self):
        frame = bytes(k * 7 & 255 for k in range(WIDTH * HEIGHT * 3 // 2))
        self.write("frame.i420", frame)
        raw = self.run_program("flat.raygrid", "--from", "frame.i420", "--format", "YUV420",
                               "--frames", 1, "--every-frame", "-o", "-")
        result = self.run_with_input(b"YUV4MPEG2 W160 H120 F25:1 C420mpeg2\nFRAME\n" + frame, "-o",
                                     "-")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stdout, raw.stdout)
        bright = b"\nFRAME\n" + bytes([200]) * len(frame)
        for header, black in ((b"", 16), (b" XCOLORRANGE=FULL", 0)):
            result = self.run_with_input(b"YUV4MPEG2 W160 H120" + header + bright, "-o", "-",
                                         "--outside", "border", blob="modes.raygrid")
            self.assertEqual(min(result.stdout[:WIDTH * HEIGHT]), black)
        result = self.run_with_input(b"YUV4MPEG2 W80 H60\nFRAME\n", "-o", "-")
        self.assertEqual(result.returncode, 8)
        self.assertIn(b"160x120", result.stderr)

    def test_jpegs_of_standard_input(self):
        _, port = self.serve()
        pictures = self.pictures(port, "/before", 2)
        result = self.run_with_input(b"".join(pictures), "--every-frame", "-o", "-")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(len(result.stdout), 2 * WIDTH * HEIGHT * 3)
        self.assertIn(b"-pixel_format rgb24", result.stderr)

    def test_standard_input_that_cannot_be_used(self):
        for data, code, word, arguments in (
                (b"", 2, b"is empty", ("--format", "YUYV")),
                (b"nonsense", 2, b"--format", ()),
                (b"nonsense", 1, b"NV13", ("--format", "NV13")),
                (b"nonsense", 1, b"GREY is not supported; use R8", ("--format", "GREY")),
                (b"nonsense", 2, b"ended within a frame", ("--format", "YUYV"))):
            result = self.run_with_input(data, *arguments, "--quiet")
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertEqual(result.stderr.count(b"\n"), 1, result.stderr)
            self.assertIn(word, result.stderr)
        process = subprocess.Popen([programs.camera, "flat.raygrid", "--from", "-"],
                                   cwd=self.folder, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(process.stdin.close)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.kill)
        self.wait_until_caught(process, signal.SIGTERM)
        self.assertEqual(self.assert_ends(process, 0, signal.SIGTERM), "")

    def test_png_files(self):
        process = self.start("--frames", 2, "--every-frame", "--png", "-o", "png")
        process.wait(timeout=MAX_SECONDS)
        self.assertEqual(sorted(os.listdir(self.path("png"))),
                         ["frame-000000.png", "frame-000001.png"])
        picture = self.read("png/frame-000000.png")
        self.assertTrue(picture.startswith(b"\x89PNG") and picture.endswith(b"IEND\xaeB`\x82"))

    def test_points(self):
        self.write("points.csv", b"x,y\n79.5,59.5\n-100,5\n")
        process = self.start("--points", "points.csv")
        output, error = process.communicate(timeout=MAX_SECONDS)
        self.assertEqual(process.returncode, 0, error)
        lines = output.decode().splitlines()
        self.assertEqual(lines[0], "x,y,u,v")
        self.assertRegex(lines[1], r"^79\.5,59\.5,7[0-9]\.[0-9]{5},[56][0-9]\.[0-9]{5}$")
        self.assertEqual(lines[2], "-100,5,,")

    def test_benchmark(self):
        process = self.start("--benchmark", "--fps", 100, "--threads", 1, "-o", "timed", "--png")
        output, error = process.communicate(timeout=MAX_SECONDS)
        self.assertEqual(process.returncode, 0, error)
        self.assertIn(b"90 delivered, 0 dropped", error)
        self.assertEqual(len(os.listdir(self.path("timed"))), 90)
        figures = dict(line.split(": ") for line in output.decode().splitlines())
        self.assertEqual(figures.pop("memory"), "this program's")
        self.assertEqual(figures.pop("cached"), "yes")
        self.assertEqual(figures.pop("threads"), "1")
        values = {name: float(value) for name, value in figures.items()}
        self.assertEqual(set(values), {"frames_per_second", "reading_ms", "remap_ms", "output_ms",
                                       "copying_ms", "remap_per_copy"})
        self.assertGreater(values["frames_per_second"], 0)
        self.assertLess(values["frames_per_second"], 105)
        self.assertGreater(values["output_ms"], 0.1)
        self.assertGreater(values["remap_ms"], 0)
        result = self.run_with_input(self.read("frames.yuyv"), "--format", "YUYV", "--benchmark")
        self.assertEqual(result.returncode, 2)
        self.assertEqual(result.stdout, b"")
        self.assertIn(b"only 7 frames received", result.stderr)

    # ---- Ends ----

    def test_signals_end_it_with_all_frames_whole(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(number):
                folder = f"signal{int(number)}"
                process = self.start("-o", folder, "--fps", 200)
                written = self.path(folder + "/*.raw")
                self.wait_for(process, lambda files=written: len(glob.glob(files)) >= 2)
                error = self.assert_ends(process, 0, number)
                frames = self.frames_in(folder)
                self.assertGreater(len(frames), 0)
                self.assertLessEqual(set(frames), set(self.expected))
                self.assertIn(f"{len(frames)} delivered", error)

    def test_a_full_disk_ends_it_and_leaves_no_half_frame(self):
        process = self.start("-o", "full", preexec_fn=lambda: resource.setrlimit(
            resource.RLIMIT_FSIZE, (30_000, 30_000)))
        process.wait(timeout=MAX_SECONDS)
        error = process.stderr.read().decode()
        self.assertEqual(process.returncode, 7, error)
        self.assertIn("free disk space", error)
        self.assertEqual(os.listdir(self.path("full")), [])

    def test_a_reader_that_goes_away_ends_it(self):
        process = self.start("-o", "-", "--fps", 1000)
        process.stdout.read(1000)
        process.stdout.close()
        self.assertIn("Broken pipe", self.assert_ends(process, 7))

    def test_a_reader_that_stands_still_drops_frames_and_does_not_keep_it(self):
        process = self.start("-o", "-", "--fps", 200)
        time.sleep(1)
        error = self.assert_ends(process, 7, signal.SIGTERM)
        self.assertIn("has stalled", error)

    # ---- Bad input ----

    def test_wrong_usage(self):
        for arguments in ((), ("flat.raygrid", "--nonsense"), ("flat.raygrid", "--frames"),
                          ("flat.raygrid", "--frames", "0"), ("flat.raygrid", "--frames", "1.5"),
                          ("flat.raygrid", "--size", "640"), ("flat.raygrid", "--size", "0x5"),
                          ("flat.raygrid", "--http", "70000"), ("flat.raygrid", "--http", ":1"),
                          ("flat.raygrid", "--http-name", "x"),
                          ("flat.raygrid", "--listen", "0.0.0.0"),
                          ("flat.raygrid", "--token-file", "token"),
                          ("flat.raygrid", "--png"), ("flat.raygrid", "other.raygrid"),
                          ("flat.raygrid", "--from", "frames.yuyv"),
                          ("flat.raygrid", "--points", "-", "-o", "x"),
                          ("flat.raygrid", "--points", "-", "--from", "-"),
                          ("flat.raygrid", "--live"),
                          ("flat.raygrid", "--from", "-", "--live", "--every-frame"),
                          ("flat.raygrid", "--benchmark", "--frames", "100"),
                          ("flat.raygrid", "--benchmark", "--points", "-"),
                          ("flat.raygrid", "--points", "-", "--outside", "border"),
                          ("flat.raygrid", "--outside", "trust"),
                          ("flat.raygrid", "--calibrated-crop", "1,2,3"),
                          ("flat.raygrid", "--source", "usb:/dev/video0"),
                          ("flat.raygrid", "--camera", "x", "--source", "v4l2"),
                          ("flat.raygrid", "--from", "frames.yuyv", "--format", "YUYV",
                           "--source=v4l2"),
                          ("flat.raygrid", "--control", "gain"),
                          ("flat.raygrid", "--control", "=1"),
                          ("flat.raygrid", "--control", "gain="),
                          ("flat.raygrid", "--control", "gain=1", "--from", "frames.yuyv",
                           "--format", "YUYV"),
                          ("flat.raygrid", "--from", "frames.yuyv", "--format", "MJPEG"),
                          ("flat.raygrid", "--from", "frames.yuyv", "--format", "YUYV", "--http",
                           "localhost:8080")):
            with self.subTest(arguments):
                self.assert_fails(1, *arguments, words=["--"])

    def test_help(self):
        result = self.run_program("--help")
        self.assertEqual(result.returncode, 0)
        self.assertIn(b"Example:", result.stdout)

    def test_blobs_that_cannot_be_used(self):
        blob = bytearray(self.read("flat.raygrid"))
        recording = ("--from", "frames.yuyv", "--format", "YUYV")
        for place in (0, 5, 40, len(blob) // 2, len(blob) - 1):
            damaged = bytearray(blob)
            damaged[place] ^= 0x10
            self.write("damaged.raygrid", damaged)
            self.assert_fails(8, "damaged.raygrid", *recording, words=["damaged.raygrid"])
        self.write("short.raygrid", blob[:100])
        self.assert_fails(8, "short.raygrid", *recording)
        self.write("empty.raygrid", b"")
        self.assert_fails(8, "empty.raygrid", *recording)
        self.assert_fails(8, "rays.raygrid", *recording, words=["--remap"])
        self.assert_fails(8, "flat.raygrid", "--table", 1, *recording, words=["--remap"])
        self.assert_fails(8, "distorting.raygrid", *recording,
                          words=["table 0 is an inverse remap", "--table"])
        self.assert_fails(2, "missing.raygrid", *recording)
        self.assert_fails(8, "flat.raygrid", *recording, "--size", "80x60",
                          words=["160x120", "80x60", "--list"])

    def test_what_a_recording_does_not_tell_is_said_once(self):
        for arguments in ((), ("--strict",), ("--strict", "--quiet")):
            result = self.run_program("stood.raygrid", "--from", "frames.yuyv", "--format", "YUYV",
                                      "--frames", 30, "--every-frame", "--fps", 1000, *arguments)
            error = result.stderr.decode()
            self.assertEqual(result.returncode, 0, error)
            self.assertEqual(error.count("raygrid-camera: cannot verify the capture settings: "
                                         "frames.yuyv does not report lens position, crop, orientation; "), 1, error)
            self.assertEqual("capture settings differ: 0 frames" in error, "--quiet" not in arguments)
        self.assert_fails(8, "flat.raygrid", "--strict", "--from", "frames.yuyv", "--format",
                          "YUYV", words=["--strict", "--capture-settings"])

    def test_nonsense_of_a_forged_blob_is_refused(self):
        blob = bytearray(self.read("stood.raygrid"))
        count = struct.unpack_from("<H", blob, 16)[0]
        for entry in range(32, 32 + 16 * count, 16):
            kind, _, section, size = struct.unpack_from("<HHII", blob, entry)
            if kind == 11:
                struct.pack_into("<I", blob, section + 16, 0)  # the crop's width
                struct.pack_into("<I", blob, entry + 12, zlib.crc32(blob[section:section + size]))
        crc = zlib.crc32(blob[32:32 + 16 * count], zlib.crc32(blob[:28]))
        struct.pack_into("<I", blob, 28, crc)
        self.write("forged.raygrid", blob)
        self.assert_fails(8, "forged.raygrid", "--from", "frames.yuyv", "--format", "YUYV",
                          "--frames", 1, words=["forged.raygrid: ", "recorded"])

    def test_recordings_that_cannot_be_used(self):
        self.write("half.yuyv", self.read("frames.yuyv")[:FRAME_SIZE + 1])
        self.assert_fails(2, "flat.raygrid", "--from", "half.yuyv", "--format", "YUYV",
                          words=["--size"])
        self.assert_fails(2, "flat.raygrid", "--from", "missing", "--format", "YUYV")

    def test_devices_that_cannot_be_used(self):
        for path, word in (("/dev/null", "not a video device"), ("/dev/missing", "--list"),
                           (self.path("flat.raygrid"), "not a video device"),
                           (self.folder, "Is a directory")):
            self.assert_fails(2, "flat.raygrid", "--source", "v4l2:" + path, words=[path, word])

    def test_outputs_that_cannot_be_written(self):
        self.assert_fails(7, "flat.raygrid", "--from", "frames.yuyv", "--format", "YUYV", "-o",
                          "flat.raygrid", "--quiet")
        self.assert_fails(7, "flat.raygrid", "--from", "frames.yuyv", "--format", "YUYV", "-o",
                          "no/such/folder", "--quiet")

    # ---- HTTP ----

    def serve(self, *arguments):
        port = free_port()
        process = self.start("--http", port, "--fps", 50, *arguments)

        def answers():
            try:
                socket.create_connection(("127.0.0.1", port), timeout=MAX_SECONDS).close()
                return True
            except ConnectionRefusedError:
                return False
        self.wait_for(process, answers)
        return process, port

    @staticmethod
    def ask(port, path="/", data=None):
        with urllib.request.urlopen(f"http://127.0.0.1:{port}{path}", data=data,
                                    timeout=MAX_SECONDS) as answer:
            return answer.read().decode()

    @staticmethod
    def send(port, request):
        """A raw request; returns the connection."""
        connection = socket.create_connection(("127.0.0.1", port), timeout=MAX_SECONDS)
        connection.sendall(request)
        return connection

    @staticmethod
    def request(port, path):
        return f"GET {path} HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n".encode()

    def status(self, port, request):
        """The status of the answer to a raw request; 0: there is none."""
        with self.send(port, request) as connection, connection.makefile("rb") as stream:
            answer = re.match(rb"HTTP/1\.[01] ([0-9]{3}) ", stream.readline())
            return int(answer[1]) if answer else 0

    def pictures(self, port, path, count):
        """So many JPEGs of a stream."""
        with self.send(port, self.request(port, path)) as connection, \
                connection.makefile("rb") as stream:
            self.assertIn(b"200", stream.readline())
            result = []
            while len(result) < count:
                line = stream.readline()
                self.assertTrue(line)
                length = re.match(rb"Content-Length: (\d+)", line)
                if length:
                    stream.readline()
                    result.append(stream.read(int(length[1])))
            return result

    def test_the_page_and_its_moving_pictures(self):
        process, port = self.serve()
        page = self.ask(port)
        self.assertIn('src="/before"', page)
        self.assertIn('src="/after"', page)
        for path in ("/before", "/after"):
            pictures = self.pictures(port, path, 5)
            self.assertGreater(len(set(pictures)), 1)
            for picture in pictures:
                self.assertTrue(picture.startswith(b"\xff\xd8") and picture.endswith(b"\xff\xd9"))
        self.assert_ends(process, 0, signal.SIGTERM)

    def test_only_this_machine_is_served_unless_told_otherwise(self):
        _, port = self.serve()
        with open("/proc/net/tcp", encoding="ascii") as file:
            listening = [line.split()[1] for line in file if line.split()[3] == "0A"]
        self.assertIn(f"0100007F:{port:04X}", listening)
        self.assertNotIn(f"00000000:{port:04X}", listening)

    def test_other_requests_are_refused(self):
        process, port = self.serve()
        for path in ("/etc/passwd", "/../../etc/passwd", "/before/", "//", "/%2e%2e/x"):
            with self.assertRaises(urllib.error.HTTPError) as raised:
                self.ask(port, path)
            self.assertEqual(raised.exception.code, 404)
            raised.exception.close()
        with self.assertRaises(urllib.error.HTTPError) as raised:
            self.ask(port, data=b"x" * 1000)
        self.assertEqual(raised.exception.code, 405)
        raised.exception.close()
        self.assert_ends(process, 0, signal.SIGTERM)

    def token_status(self, port, path="/", *fields):
        lines = [f"GET {path} HTTP/1.1", f"Host: localhost:{port}", "Connection: close", *fields]
        return self.status(port, ("\r\n".join(lines) + "\r\n\r\n").encode("latin-1"))

    def test_who_asks_from_elsewhere_must_know_a_token(self):
        process, port = self.serve("--listen", "0.0.0.0", "--frames", 1000)
        link = process.stderr.readline().decode().strip()
        self.assertRegex(link, rf"^http://[^/]+:{port}/\?token=[0-9a-f]{{32}}$")
        token = link.split("=")[1]
        wrong = token[:-1] + ("1" if token[-1] == "0" else "0")
        cookie = f"raygrid_{port}"
        for path in ("/", "/before", "/after", "/nothing"):
            for fields in ((), (f"Authorization: Bearer {wrong}",), (f"Cookie: {cookie}={wrong}",),
                           (f"Authorization: {token}",), (f"Authorization: Basic {token}",),
                           (f"Cookie: raygrid_1={token}",)):
                self.assertEqual(self.token_status(port, path, *fields), 401, (path, fields))
        for guess in ("", wrong, token[:-1], token + "0", token.upper() + "%00", token + "%00"):
            self.assertEqual(self.token_status(port, f"/?token={guess}"), 401, guess)
        self.assertEqual(self.token_status(port, "/", f"Authorization: Bearer {token}"), 200)
        self.assertEqual(self.token_status(port, "/", f"Cookie: {cookie}={token}"), 200)
        self.assertEqual(self.token_status(port, f"/nothing?token={token}"), 404)
        self.assertTrue(self.pictures(port, f"/after?token={token}", 1)[0].startswith(b"\xff\xd8"))
        # The link leaves the token in the browser alone.
        with self.send(port, self.request(port, f"/?token={token}")) as connection:
            answer = connection.recv(4096).decode()
        self.assertIn(" 303 ", answer.splitlines()[0])
        self.assertIn("\r\nLocation: /\r\n", answer)
        self.assertIn(f"Set-Cookie: {cookie}={token}; Path=/; HttpOnly; SameSite=Strict", answer)
        self.assert_ends(process, 0, signal.SIGTERM)
        other, _ = self.serve("--listen", "0.0.0.0", "--quiet")
        self.assertNotIn(token, other.stderr.readline().decode())

    def test_the_token_of_a_file_is_asked_for_at_loopback_too(self):
        path = os.path.join(self.folder, "token")
        with open(path, "w", encoding="ascii") as file:
            file.write("a-word_of-0123456789\n")
        process, port = self.serve("--token-file", path)
        self.assertEqual(process.stderr.readline().decode().strip(), f"http://127.0.0.1:{port}/")
        self.assertEqual(self.token_status(port), 401)
        self.assertEqual(self.token_status(port, "/", "Authorization: Bearer a-word_of-0123456789"),
                         200)
        for text in ("", "short", "x" * 129, "a word of 0123456789", "0123456789abcdef\n\n",
                     "0123456789abcdef\0"):
            with open(path, "w", encoding="ascii") as file:
                file.write(text)
            self.assert_fails(1, "flat.raygrid", "--from", "frames.yuyv", "--format", "YUYV",
                              "--http", port, "--token-file", path, words=["16 to 128"])

    def host_statuses(self, port, hosts):
        return {host: self.status(port, f"GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n"
                                  "\r\n".encode("latin-1")) for host in hosts}

    def test_requests_under_other_names_are_refused(self):
        process, port = self.serve("--http-name", "cam.example", "--http-name", "far.example:99")
        name = socket.gethostname()
        own = ["localhost", "LocalHost", "127.0.0.1", "127.0.0.2", "[::1]", "[0:0:0:0:0:0:0:1]",
               name, name + ".local", "cam.example"]
        own = [f"{host}:{port}" for host in own] + ["cam.example", "far.example:99"]
        for host, status in self.host_statuses(port, own).items():
            self.assertEqual(status, 200, host)
        other = ["evil.example", f"evil.example:{port}", "localhost", f"localhost:{port + 1}",
                 f"localhost:{port}:{port}", f"localhost.evil.example:{port}",
                 f"127.0.0.1.evil.example:{port}", f"127.1:{port}", f"128.0.0.1:{port}",
                 f"::1:{port}", f"[::2]:{port}", f"[::1]x:{port}", f"[::1:{port}",
                 f"x@localhost:{port}",
                 f"localhost:{port}, evil.example", f"localhost :{port}", f"localhost:{port}x",
                 "far.example", f"far.example:{port}", "cam.example:1", f":{port}", ":", "", "]",
                 "\xff" * 1000]
        for host, status in self.host_statuses(port, other).items():
            self.assertIn(status, (400, 421), host)
        for fields in (f"Host: localhost:{port}\r\nHost: evil.example\r\n",
                       f"Host: evil.example\r\nHost: localhost:{port}\r\n", ""):
            for version in ("1.0", "1.1"):
                request = f"GET /before HTTP/{version}\r\n{fields}\r\n".encode()
                self.assertIn(self.status(port, request), (400, 421), fields)
        self.assert_ends(process, 0, signal.SIGTERM)

    def test_nothing_may_follow_a_path(self):
        process, port = self.serve()
        for path in ("/before%00x", "/before%00", "/%00", "/after%00/../..", "/befor%65"):
            self.assertEqual(self.status(port, self.request(port, path)), 404, path)
        self.assert_ends(process, 0, signal.SIGTERM)

    def test_clients_that_drip_do_not_hold_the_others_up(self):
        process, port = self.serve()
        dripping = [self.send(port, b"G") for _ in range(16)]
        rest = iter(self.request(port, "/")[1:])
        for _ in range(3):
            byte = bytes([next(rest)])
            for connection in dripping:
                try:
                    connection.sendall(byte)
                except OSError:
                    pass
            start = time.monotonic()
            self.assertIn("raygrid-camera", self.ask(port))
            self.assertEqual(len(self.pictures(port, "/after", 2)), 2)
            self.assertLess(time.monotonic() - start, 1)
            time.sleep(1)
        # Nor do those that take pictures so.
        watching = [self.send(port, self.request(port, "/before")) for _ in range(16)]
        for connection in watching:
            connection.recv(1)
        self.assertIn("raygrid-camera", self.ask(port))
        self.assertEqual(self.status(port, self.request(port, "/before")), 503)
        for connection in dripping + watching:
            connection.close()
        self.assert_ends(process, 0, signal.SIGTERM)

    def test_malformed_requests_do_no_harm(self):
        process, port = self.serve()
        requests = [b"\0" * 100, b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"\r\n" * 1000,
                    b"GET /" + b"a" * 100_000 + b" HTTP/1.1\r\n\r\n",
                    b"GET / HTTP/1.1\r\n" + b"A: b\r\n" * 50_000 + b"\r\n",
                    b"POST / HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n\r\n",
                    b"POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n",
                    b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n",
                    b"GET / HTTP/1.1\r\nHost: " + b"\xff" * 1000, b"GET /after HTTP/1.1\r\n"]
        for request in requests:
            try:
                with self.send(port, request) as connection:
                    connection.shutdown(socket.SHUT_WR)
                    connection.settimeout(3)
                    connection.recv(1000)
            except OSError:
                pass
            self.assertIsNone(process.poll(), request[:40])
        self.assertIn("raygrid-camera", self.ask(port))
        self.assert_ends(process, 0, signal.SIGTERM)

    def test_slow_and_many_clients_do_not_hold_the_others_up(self):
        process, port = self.serve()
        request = self.request(port, "/after")
        # Never read from; more than are served.
        slow = [self.send(port, request) for _ in range(8)]
        self.assertGreater(len(set(self.pictures(port, "/before", 20))), 1)
        try:
            slow += [self.send(port, request) for _ in range(40)]
        except OSError:
            pass
        self.assertIsNone(process.poll())
        error = self.assert_ends(process, 0, signal.SIGTERM)
        self.assertIn("undistorted", error)
        for connection in slow:
            connection.close()

    def test_clients_that_come_and_go(self):
        process, port = self.serve()
        request = self.request(port, "/before")

        def come_and_go():
            for _ in range(20):
                try:
                    with self.send(port, request) as connection:
                        connection.recv(100)
                except OSError:
                    pass
        threads = [threading.Thread(target=come_and_go) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertGreater(len(self.pictures(port, "/after", 2)), 1)
        self.assert_ends(process, 0, signal.SIGINT)

    def test_a_port_that_is_taken(self):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            self.assert_fails(7, "flat.raygrid", "--from", "frames.yuyv", "--format", "YUYV",
                              "--http", taken.getsockname()[1], words=["another port"])
        process, port = self.serve()
        self.assert_fails(7, "flat.raygrid", "--from", "frames.yuyv", "--format", "YUYV",
                          "--http", port, words=["another port"])
        self.assert_ends(process, 0, signal.SIGTERM)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    for option in ("raygrid", "camera", "undistort-frames"):
        parser.add_argument("--" + option, required=True)
    _, rest = parser.parse_known_args(namespace=programs)
    unittest.main(argv=[sys.argv[0]] + rest, verbosity=2)
