#!/usr/bin/env python3
"""raygrid capture: frames of a folder, a video or a pipe become a session, and that a camera."""
import glob
import json
import os
import pty
import resource
import shutil
import signal
import subprocess
import unittest

from command_test import HANG_S, CommandTest, main, programs, read, run, wait_until, write
from png_files import read_png

BOARD = "chessboard:9x6:25mm"
NUM_PHOTOGRAPHS = 16


def limit_files():
    resource.setrlimit(resource.RLIMIT_FSIZE, (6000, 6000))


def pixels_of(path):
    """8 bits, grey."""
    channels, bits, pixels = read_png(path)
    assert (channels, bits) == (1, 8)
    return bytes(pixels)


class Session(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.photographs = cls.path("photographs")
        cls.succeed("simulate", "--render", "--images", NUM_PHOTOGRAPHS, "--lens", "wide", "--size",
                    "320x240", "--pattern", BOARD, "-o", cls.path("simulated"))
        os.makedirs(cls.photographs)
        for path in glob.glob(cls.path("simulated/*.png")):
            shutil.copy(path, cls.photographs)
        cls.names = sorted(os.listdir(cls.photographs))
        cls.video = cls.video_of(cls.names)

    @classmethod
    def video_of(cls, names, repeated=3):
        """Y4M in which each photograph stands still for some frames."""
        frames = b""
        for name in names:
            frames += (b"FRAME\n" + pixels_of(os.path.join(cls.photographs, name))) * repeated
        return b"YUV4MPEG2 W320 H240 F30:1 Ip A1:1 Cmono\n" + frames

    def setUp(self):
        self.session = self.path("session-" + self.id().rsplit(".", 1)[1])

    def capture(self, *options, source=None, **how):
        return run("capture", "--source", source or self.photographs, "--pattern", BOARD, "-o",
                   self.session, "--no-calibrate", *options, **how)

    def start(self, *options, source="-"):
        """A capture, of a pipe that stays open if nothing else is said."""
        return subprocess.Popen(
            [programs.raygrid, "capture", "--source", source, "--pattern", BOARD, "-o", self.session,
             "--no-calibrate", "--no-page", *options],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def told(self):
        return json.loads(read(os.path.join(self.session, "session.json")))

    def assert_whole(self):
        """The frames that session.json names are all there, whole, and nothing else is."""
        names = [frame["image"] for frame in self.told()["frames"]]
        self.assertEqual(sorted(names), sorted(os.listdir(os.path.join(self.session, "frames"))))
        for name in names:
            self.assertEqual(len(pixels_of(os.path.join(self.session, "frames", name))), 320 * 240)
        return names

    def wait_for(self, condition):
        wait_until(condition)

    def has_frames(self, number):
        frames = os.path.join(self.session, "frames")
        return os.path.isdir(frames) and len(os.listdir(frames)) >= number

    def test_a_folder_becomes_a_camera_without_options(self):
        self.succeed("capture", "--source", self.photographs, "--pattern", BOARD, "-o", self.session)
        names = self.assert_whole()
        self.assertGreaterEqual(len(names), 6)
        self.assertLess(len(names), NUM_PHOTOGRAPHS)
        for name in names:  # copies
            self.assertEqual(read(os.path.join(self.session, "frames", name)),
                             read(os.path.join(self.photographs, name)))
        camera = os.path.join(self.session, "calibration/camera.yaml")
        first = read(camera)
        # A frame that session.json does not name is none.
        other = next(name for name in self.names if name not in names)
        shutil.copy(os.path.join(self.photographs, other), os.path.join(self.session, "frames"))
        self.succeed("calibrate", self.session)
        self.assertEqual(read(camera), first)
        result = run("compare", camera, self.path("simulated/true_camera.yaml"), "--json")
        self.assertLess(json.loads(result.stdout)["median_px"], 0.05)

    def test_a_check_says_how_a_camera_stands_otherwise(self):
        self.assert_done(self.capture())
        told = self.told()
        # As version 0.2 wrote it.
        former = {"lens_position_dpt": "lens_position", "time_s": "seconds", "edge_width_px": "edge_spread_px",
                  "white_level": "white", "variance_reduction": "variance_taken"}
        old = {**told, "raygrid_session": 1, "frames": [
            {**{former.get(key, key): value for key, value in frame.items()}, "lens_position": 2.0,
             "sensor_temperature_c": 30.5, "exposure_us": 8000} for frame in told["frames"]]}
        del old["schema_version"]
        write(os.path.join(self.session, "session.json"), json.dumps(old).encode())
        self.succeed("calibrate", self.session, "--skip-comparison")
        camera = os.path.join(self.session, "calibration/camera.yaml")
        self.assertIn(b"sensor_temperature_c: 30.5\n  exposure_us: 8000\n", read(camera))
        check = self.succeed("check", camera, self.session)
        self.assertNotIn("capture settings differ", check.stdout)
        for frame in told["frames"]:
            frame.update(lens_position_dpt=2.5, sensor_temperature_c=52, exposure_us=99)
        write(os.path.join(self.session, "session.json"), json.dumps(told).encode())
        check = self.succeed("check", camera, self.session)
        self.assertIn("capture settings differ: lens position 2.5 dioptres, calibrated at 2 dioptres\n", check.stdout)
        self.assertIn("capture settings differ: sensor temperature 52 degrees Celsius, calibrated at 30.5", check.stdout)
        self.assertEqual(check.stdout.count("capture settings differ"), 2)
        check = json.loads(run("check", camera, self.session, "--json").stdout)
        self.assertEqual(len(check["changed_settings"]), 2)

    def test_frames_say_how_good_they_are(self):
        self.assert_done(self.capture())
        frames = self.told()["frames"]
        spreads = [frame["edge_width_px"] for frame in frames if "edge_width_px" in frame]
        self.assertGreater(len(spreads), len(frames) / 2)
        for spread in spreads:
            self.assertTrue(0.5 < spread < 1.2, spread)
        self.assertTrue(all(0 < frame["variance_reduction"] <= 1 for frame in frames))

    def test_a_video_gives_the_same_bytes_again(self):
        """Whatever the number of threads, from a file or from standard input."""
        video = write(self.path("video.y4m"), self.video)
        sessions = []
        for threads in (1, 2):
            self.assert_done(self.capture("--threads", threads, source=video))
            self.assert_whole()
            sessions.append(self.told())
            shutil.rmtree(self.session)
        with open(video, "rb") as file:
            result = subprocess.run(
                [programs.raygrid, "capture", "--source", "-", "--pattern", BOARD, "-o", self.session,
                 "--no-calibrate"], stdin=file, capture_output=True, text=True, timeout=HANG_S, check=False)
        self.assert_done(result)
        sessions.append(self.told())
        self.assertEqual(sessions[0], sessions[1])
        self.assertEqual(sessions[0], sessions[2])
        self.assertEqual(sessions[0]["frames"][0]["image"], "frame-0001.png")

    def test_frames_of_a_video_are_kept_as_they_are(self):
        self.assert_done(self.capture(source=write(self.path("as_is.y4m"), self.video)))
        pictures = {pixels_of(os.path.join(self.photographs, name)) for name in self.names}
        for name in self.assert_whole():
            self.assertIn(pixels_of(os.path.join(self.session, "frames", name)), pictures)

    @unittest.skipUnless(shutil.which("ffmpeg"), "no ffmpeg; tools/install_packages tests installs it")
    def test_every_frame_of_a_video_is_kept_with_its_time(self):
        source = write(self.path("every.y4m"), self.video)
        self.assert_done(self.capture("--every-frame", source=source))
        frames = self.told()["frames"]
        # Boards that leave the image are seen too little of; each stands still for three frames.
        self.assertGreater(len(frames), 2 * len(self.names))
        self.assertEqual(len(frames) % 3, 0)
        self.assert_whole()
        times = [30 * frame["time_s"] for frame in frames]
        self.assertTrue(all(b > a and abs(b - round(b)) < 1e-3 for a, b in zip(times, times[1:])))

    def test_photographs_have_no_times_for_a_rolling_shutter(self):
        self.assert_done(self.capture("--every-frame"))
        self.assert_refused(run("calibrate", self.session, "--rolling-shutter"), 2,
                            "the session: lacks timestamps of images")

    def test_other_videos_are_read_by_ffmpeg(self):
        video = write(self.path("in.y4m"), self.video)
        subprocess.run(["ffmpeg", "-v", "error", "-i", video, "-c:v", "ffv1", self.path("video.mkv")],
                       check=True, timeout=HANG_S)
        self.assert_done(self.capture(source=self.path("video.mkv")))
        self.assert_whole()

    def test_what_is_no_video_is_refused(self):
        for name, contents in (("empty.y4m", b""), ("text.y4m", b"hello"), ("empty.mkv", b""),
                               ("cut.y4m", self.video[:40])):
            result = self.capture(source=write(self.path(name), contents))
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(name, result.stderr.strip().splitlines()[-1])
            self.assertFalse(os.path.exists(self.session))
        self.assert_refused(self.capture(source=self.path("nowhere")), 2, "nowhere", "v4l2:")

    def test_it_goes_on_with_a_session(self):
        half = self.path("half")
        os.makedirs(half)
        for name in self.names[:NUM_PHOTOGRAPHS // 2]:
            shutil.copy(os.path.join(self.photographs, name), half)
        self.assert_refused(self.capture("--resume"), 2, "no session")
        self.assert_done(self.capture(source=half))
        first = self.assert_whole()
        self.assert_refused(self.capture(), 7, "--resume")
        result = run("capture", "--source", half, "--pattern", "chessboard:9x6:26mm", "-o", self.session,
                     "--resume")
        self.assert_refused(result, 1, "another target")
        self.assertEqual(self.assert_whole(), first)
        self.assert_done(self.capture("--resume"))
        both = self.assert_whole()
        self.assertEqual(both[:len(first)], first)
        self.assertGreater(len(both), len(first))

    def test_a_pattern_that_lies_there_is_never_replaced(self):
        board = self.path("star-board")
        self.succeed("pattern", "star", "--columns", 9, "--rows", 6, "--square-mm", 25, "-o", board)
        os.makedirs(self.session)
        path = os.path.join(self.session, "pattern.yaml")
        shutil.copy(os.path.join(board, "pattern.yaml"), path)
        before = read(path)
        self.assert_refused(self.capture(), 7, "pattern.yaml: describes another target", "--pattern")
        # As the pattern of a capture that keeps nothing it stays as it is, too.
        result = run("capture", "--source", self.photographs, "--pattern", path, "-o", self.session,
                     "--no-calibrate")
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertEqual(os.listdir(self.session), ["pattern.yaml"])
        self.assertEqual(read(path), before)

    def test_a_target_that_is_not_reached_is_told(self):
        result = self.capture("--until", "0.0001px")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("--until 0.0001px was not reached: uncertainty ", result.stderr)

    def test_a_few_frames_are_never_done(self):
        few = self.path("few")
        os.makedirs(few)
        for name in self.names[:6]:
            shutil.copy(os.path.join(self.photographs, name), few)
        result = self.capture("--until", "100px", "--json", source=few)
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = [json.loads(line) for line in result.stdout.splitlines()]
        self.assertFalse(any(line["done"] for line in lines))
        self.assertTrue(all(line["uncertainty_is_lower_bound"] for line in lines))
        self.assertIn("was not reached", lines[-1]["warnings"][-1])

    def test_frames_of_another_size_are_refused(self):
        self.assert_done(self.capture())
        kept = self.assert_whole()
        video = write(self.path("small.y4m"),
                      b"YUV4MPEG2 W160 H120 Cmono\nFRAME\n" + bytes(160 * 120))
        self.assert_refused(self.capture("--resume", source=video), 1, "320 x 240", "160 x 120")
        self.assertEqual(self.assert_whole(), kept)

    def test_no_board_is_an_error_with_its_word(self):
        result = run("capture", "--source", self.photographs, "--pattern", "star:9x6:25mm", "-o",
                     self.session)
        self.assert_refused(result, 3, "absent", "star:9x6:25mm")

    def test_two_never_write_to_one_session(self):
        first = self.start()
        first.stdin.write(self.video)
        first.stdin.flush()
        self.wait_for(lambda: self.has_frames(1))
        self.assert_refused(self.capture("--resume"), 7, "another capture")
        first.communicate(timeout=HANG_S)
        self.assertEqual(first.returncode, 0)
        self.assert_whole()

    def test_an_interruption_leaves_what_was_kept(self):
        video = write(self.path("interrupted.y4m"), self.video)
        for number in (0, 2, 5):
            process = self.start(source=video)
            self.wait_for(lambda: number == 0 or self.has_frames(number))
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=HANG_S)
            self.assertIn(process.returncode, (0, 3, -signal.SIGINT))
            if number > 0:
                self.assertGreaterEqual(len(self.assert_whole()), number)
            shutil.rmtree(self.session, ignore_errors=True)

    def test_a_killed_program_loses_nothing(self):
        process = self.start(source=write(self.path("killed.y4m"), self.video))
        self.wait_for(lambda: self.has_frames(4))
        process.kill()
        process.communicate(timeout=HANG_S)
        names = {frame["image"] for frame in self.told()["frames"]}
        self.assertGreaterEqual(len(names), 3)
        self.assertLessEqual(names, set(os.listdir(os.path.join(self.session, "frames"))))
        self.assert_done(self.capture("--resume"))

    def test_a_source_that_falls_silent_ends_it(self):
        process = self.start("--timeout", "1")
        process.stdin.write(self.video_of(self.names[:6]))
        process.stdin.flush()
        process.wait(timeout=HANG_S)
        error = process.stderr.read().decode()
        self.assertEqual(process.returncode, 2, error)
        self.assertIn("--resume", error.strip().splitlines()[-1])
        process.communicate()
        self.assertGreaterEqual(len(self.assert_whole()), 1)

    def test_a_full_disk_keeps_what_was_kept(self):
        """A limit of files stands for it: session.json grows until it is no longer written."""
        video = write(self.path("full.y4m"), self.video)
        result = subprocess.run(
            [programs.raygrid, "capture", "--source", video, "--pattern", BOARD, "-o", self.session,
             "--no-calibrate"], preexec_fn=limit_files, capture_output=True, text=True, timeout=HANG_S,
            stdin=subprocess.DEVNULL, check=False)
        self.assertEqual(result.returncode, 7, result.stderr)
        self.assertIn("cannot be written", result.stderr.strip().splitlines()[-1])
        self.assertEqual(glob.glob(os.path.join(self.session, "frames", "*")), [])

    def test_programs_read_lines_of_json(self):
        result = self.capture("--json")
        self.assert_done(result)
        lines = [json.loads(line) for line in result.stdout.splitlines()]
        self.assertGreater(len(lines), 6)
        self.assertEqual(lines[-1]["kept_frames"], [frame["image"] for frame in self.told()["frames"]])
        self.assertTrue(any(line["uncertainty_px"] > 0 for line in lines))
        self.assertTrue(all(line["width"] == 320 for line in lines))

    def test_a_terminal_shows_a_block(self):
        ours, theirs = pty.openpty()
        process = subprocess.Popen(
            [programs.raygrid, "capture", "--source", self.photographs, "--pattern", BOARD, "-o",
             self.session, "--no-calibrate"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=theirs)
        os.close(theirs)
        text = b""
        while True:
            try:
                part = os.read(ours, 65536)
            except OSError:  # its end
                break
            if not part:
                break
            text += part
        os.close(ours)
        self.assertEqual(process.wait(timeout=HANG_S), 0)
        process.stdout.close()
        last = text.decode().split("\x1b[J")[-1].replace("\r", "")
        self.assertRegex(last, r"\+-+\+\n(\|.*\|\n)+\+-+\+\n")
        self.assertRegex(last, r"\d+ kept.*uncertainty 0\.\d+ px")
        self.assertRegex(text.decode(), "o")
        self.assertRegex(text.decode(), "#")

    def test_damaged_sessions_are_refused(self):
        self.assert_done(self.capture())
        path = os.path.join(self.session, "session.json")
        whole = read(path)
        for contents in (b"", b"[]", b"{}", whole[:100], whole.replace(b'"schema_version": 2',
                                                                       b'"schema_version": 9'),
                         whole.replace(b'"image": "sim', b'"image": "../sim', 1)):
            write(path, contents)
            self.assert_refused(run("calibrate", self.session), 2, "session.json")
            self.assert_refused(self.capture("--resume"), 2, "session.json")

    def test_wrong_usage_is_told(self):
        self.assert_refused(run("capture"), 1, "--source", "raygrid capture --help")
        self.assert_refused(self.capture("--until", "soon"), 1, "--until", "0.02px")
        self.assert_refused(self.capture("--still-px", "0"), 1, "--still-px")
        self.assertFalse(os.path.exists(self.session))


if __name__ == "__main__":
    main(__name__)
