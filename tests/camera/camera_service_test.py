#!/usr/bin/env python3
"""raygrid-camera as a service of systemd: what it tells systemd, --check, and its unit."""
import argparse
import os
import resource
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest

programs = argparse.Namespace()

SIZE = (128, 96)
FRAME = bytes(range(256)) * (SIZE[0] * SIZE[1] // 256)
INPUT = ("--from", "-", "--format", "R8")
WATCHDOG_S = 0.4
HANG_S = 300


class CameraService(unittest.TestCase):
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

    # ---- What it tells systemd ----

    def listen(self):
        """The socket of systemd, and the environment that names it."""
        notices = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(notices.close)
        path = os.path.join(self.folder, self.id().rsplit(".", maxsplit=1)[-1][:40])
        notices.bind(path)
        notices.setblocking(False)
        return notices, {**os.environ, "NOTIFY_SOCKET": path,
                         "WATCHDOG_USEC": str(round(WATCHDOG_S * 1e6))}

    def start(self, environment, *arguments, **how):
        # pylint: disable=consider-using-with
        process = subprocess.Popen([programs.camera, "good.raygrid", *INPUT, *arguments],
                                   cwd=self.folder, env=environment, stdin=subprocess.PIPE,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **how)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.addCleanup(process.stdin.close)
        return process

    @staticmethod
    def take(notices):
        """All that came."""
        texts = []
        while True:
            try:
                texts += notices.recv(4096).decode().splitlines()
            except BlockingIOError:
                return texts

    def feed(self, process, notices, seconds):
        """Writes a frame now and then; returns all that came meanwhile."""
        texts = []
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            process.stdin.write(FRAME)
            process.stdin.flush()
            time.sleep(0.01)
            texts += self.take(notices)  # a socket that is full would hold the program up
        return texts

    def test_systemd_hears_of_frames_for_as_long_as_they_pass(self):
        if not programs.notifies:
            self.skipTest("raygrid-camera was built without libsystemd, which notifies; "
                          "tools/install_packages camera installs it")
        notices, environment = self.listen()
        process = self.start(environment, "--timeout", "30")
        time.sleep(0.2)
        self.assertEqual(self.take(notices), [])  # no frame came yet
        start = time.monotonic()
        texts = self.feed(process, notices, 4 * WATCHDOG_S)
        seconds = time.monotonic() - start
        self.assertEqual(texts[:2], ["READY=1", "WATCHDOG=1"])
        self.assertEqual(set(texts[1:]), {"WATCHDOG=1"})
        # Twice in the watchdog's time at least, and not for each of 100 frames.
        self.assertGreaterEqual(len(texts), 8)
        self.assertLess(len(texts), 5 * seconds / WATCHDOG_S)
        time.sleep(0.2)  # frames that are under way
        self.take(notices)
        time.sleep(2 * WATCHDOG_S)
        self.assertEqual(self.take(notices), [])
        self.assertIsNone(process.poll())
        texts = self.feed(process, notices, WATCHDOG_S)  # it goes on
        self.assertEqual(set(texts), {"WATCHDOG=1"})
        process.stdin.close()
        self.assertEqual(process.wait(timeout=HANG_S), 0)
        self.assertNotIn("READY=1", self.take(notices))

    def test_frames_that_cannot_be_written_are_not_told(self):
        notices, environment = self.listen()
        process = self.start(environment, "-o", "full", preexec_fn=lambda: resource.setrlimit(
            resource.RLIMIT_FSIZE, (100, 100)))
        process.stdin.write(FRAME)
        process.stdin.close()
        self.assertEqual(process.wait(timeout=HANG_S), 7)
        self.assertEqual(self.take(notices), [])

    def test_systemd_without_a_watchdog_hears_once(self):
        notices, environment = self.listen()
        del environment["WATCHDOG_USEC"]
        process = self.start(environment)
        texts = self.feed(process, notices, 0.2)
        process.stdin.close()
        self.assertEqual(process.wait(timeout=HANG_S), 0)
        texts += self.take(notices)
        self.assertEqual(texts, ["READY=1"] if programs.notifies else [])

    # ---- --check ----

    def check(self, blob, *arguments, **how):
        return subprocess.run([programs.camera, "--check", blob, *arguments], cwd=self.folder,
                              capture_output=True, timeout=HANG_S, check=False, text=True, **how)

    def assert_fails(self, code, word, blob, *arguments, **how):
        result = self.check(blob, *arguments, **{"stdin": subprocess.DEVNULL, **how})
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(result.stdout, "")
        self.assertRegex(result.stderr, rf"^raygrid-camera: [^\n]*{word}[^\n]*\n$")

    def test_a_check_takes_one_frame_and_writes_nothing(self):
        before = sorted(os.listdir(self.folder))
        notices, environment = self.listen()
        with socket.socket() as taken:  # a server of the options could not start
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            result = self.check("good.raygrid", "--from", "frame.grey", "--format", "R8", "-o",
                                "outputs", "--http", str(taken.getsockname()[1]),
                                stdin=subprocess.DEVNULL, env=environment)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        self.assertRegex(result.stdout, r"^good\.raygrid: undistorts 128x96 R8 of frame\.grey to "
                         r"80x60 in [0-9.]+ ms\n$")
        self.assertEqual(self.take(notices), [])  # the service itself is not ready
        os.remove(environment["NOTIFY_SOCKET"])
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
            self.assert_fails(2, "before a frame was received", "good.raygrid", "--from", "-", stdin=file)

    # ---- The unit ----

    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd-analyze, which checks the unit; "
                                                            "it comes with Debian's package systemd")
    def test_systemd_takes_the_unit_and_finds_it_locked_in(self):
        with open(programs.unit, encoding="ascii") as file:
            text = file.read()
        self.assertEqual(text.count("ExecStart=raygrid-camera "), 1)
        path = os.path.join(self.folder, os.path.basename(programs.unit))
        with open(path, "w", encoding="ascii") as file:  # the program is not installed
            file.write(text.replace("ExecStart=raygrid-camera ", f"ExecStart={programs.camera} "))
        for command in (("verify",), ("security", "--offline=true", "--threshold=20")):
            result = subprocess.run(["systemd-analyze", *command, path], capture_output=True,
                                    text=True, timeout=HANG_S, check=False)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            # Other units of the machine are read, too.
            self.assertNotIn("raygrid-camera@", result.stderr)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    for option in ("raygrid", "camera", "undistort-frames", "unit"):
        parser.add_argument("--" + option, required=True)
    parser.add_argument("--notifies", action="store_true", help="libsystemd is built in")
    _, rest = parser.parse_known_args(namespace=programs)
    unittest.main(argv=[sys.argv[0]] + rest, verbosity=2)
