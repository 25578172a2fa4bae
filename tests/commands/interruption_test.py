#!/usr/bin/env python3
"""Ctrl-C during a calibration, and going on."""
import json
import os
import shutil
import signal
import subprocess
import time

from command_test import (HANG_S, CommandTest, SIMULATED_PATTERN, cpu_seconds, cpu_seconds_of_children,
                          main, programs, read, run, write)


# This test polls, and has to be scheduled before what it waits for, on busy machines too.
POLLED = {"preexec_fn": lambda: os.nice(5)}


class Interruption(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.board = write(cls.path("board.yaml"), SIMULATED_PATTERN)
        cls.succeed("simulate", "--images", 9, "--features-per-image", 40, "--pattern",
                    cls.board, "-o", cls.path("sim"))

    def arguments(self, output, *more):
        return ["calibrate", "--features", self.path("sim/features.csv"), "--image-size",
                "640x480", "--pattern", self.path("sim/pattern.yaml"), "--threads", 1, "-o",
                self.path(output), *more]

    def signalled(self, command, seconds, *numbers):
        """Sends a program signals once it has used so much CPU time. Returns its exit code, and
        the CPU time from the first signal to its end."""
        with subprocess.Popen(command, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, **POLLED) as process:
            end = time.monotonic() + HANG_S
            while cpu_seconds(process.pid) < seconds:
                self.assertIsNone(process.poll(), "it ended too early")
                self.assertLess(time.monotonic(), end)
                time.sleep(0.01)
            before = cpu_seconds(process.pid)
            for number in numbers:
                os.kill(process.pid, number)  # not reaped before wait4()
                time.sleep(0.05)
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, usage.ru_utime + usage.ru_stime - before

    def finished(self, arguments):
        """Runs a calibration to its end, and returns its CPU time."""
        before = cpu_seconds_of_children()
        self.succeed(*arguments)
        return cpu_seconds_of_children() - before

    def interrupted(self, arguments, number, seconds, attempts=8):
        """Sends a calibration a signal once it has used so much CPU time, less or more if that is too late or too early, and waits for its end."""
        command = [programs.raygrid, *map(str, arguments)]
        for _ in range(attempts):
            with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                  text=True, **POLLED) as process:
                while process.poll() is None and cpu_seconds(process.pid) < seconds:
                    time.sleep(0.005)
                process.send_signal(number)
                _, error = process.communicate(timeout=HANG_S)
            if "--resume" in error:
                break
            # A finished result would be kept, whatever code its attempt ended with.
            shutil.rmtree(arguments[arguments.index("-o") + 1], ignore_errors=True)
            seconds *= 0.7 if process.returncode >= 0 else 1.5  # done, or being packed
        return process.returncode, error

    def files_in(self, output):
        files = {}
        for place, _, names in os.walk(self.path(output)):
            for name in names:
                path = os.path.join(place, name)
                files[os.path.relpath(path, self.path(output))] = read(path)
        return files

    def without_times(self, output):
        """A result's files; what was measured of the run itself is left out of result.json."""
        files = self.files_in(output)
        result = json.loads(files["result.json"])
        for key in ("stage_seconds", "peak_memory_bytes"):
            del result[key]
        files["result.json"] = result
        return files

    def assert_same_bytes(self, output, whole):
        files, expected = self.without_times(output), self.without_times(whole)
        self.assertEqual(set(files), set(expected))
        for name, contents in expected.items():
            self.assertEqual(files[name], contents, name)

    def killed(self, arguments, output, more_than):
        """Kills a calibration as soon as its checkpoint is larger than before."""
        command = [programs.raygrid, *map(str, arguments)]
        path = self.path(output + "/resume.json")
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              **POLLED) as process:
            while process.poll() is None:
                if os.path.exists(path) and os.path.getsize(path) > more_than:
                    break
                time.sleep(0.01)
            process.kill()
            process.communicate(timeout=HANG_S)
        self.assertEqual(process.returncode, -signal.SIGKILL)
        return os.path.getsize(path)

    def check_state(self, output):
        names = set(os.listdir(self.path(output)))
        self.assertLessEqual({"camera.yaml", "poses.csv", "pattern.yaml", "features.csv",
                              "result.json", "report.html", "resume.json"}, names)
        self.assertFalse([name for name in names if ".part" in name])
        result = json.loads(read(self.path(output + "/result.json")))
        self.assertEqual(result["status"], "interrupted")
        self.assertEqual(result["verdict"], "fail")
        self.succeed("inspect", self.path(output + "/camera.yaml"))

    def test_state_so_far_is_written_and_gone_on_from(self):
        coarse = ("--knot-spacing-px", 160)
        whole_seconds = self.finished(self.arguments("whole", "--seed", 0, *coarse))
        for number, part in ((signal.SIGINT, 0.5), (signal.SIGTERM, 0.95)):
            with self.subTest(signal=number):
                output = f"part{part}"
                code, error = self.interrupted(self.arguments(output, *coarse), number,
                                               part * whole_seconds)
                self.assertEqual(code, 5, error)
                self.assertIn("--resume", error)
                self.assertEqual(error.count("\n"), 1, error)
                self.check_state(output)
                # Other options: not the same calibration.
                other = run(*self.arguments(output, "--resume", *coarse, "--model", "opencv"))
                self.assertEqual(other.returncode, 2)
                self.assertIn("other features, pattern", other.stderr)
                other = run(*self.arguments(output, "--resume", *coarse, "--duplicate-px", 9))
                self.assertEqual(other.returncode, 2)

                self.succeed(*self.arguments(output, "--resume", *coarse))
                self.assert_same_bytes(output, "whole")

    def test_a_finished_result_is_kept(self):
        quick = ("--knot-spacing-px", 160, "--skip-comparison")
        seconds = self.finished(self.arguments("finished", *quick))
        arguments = self.arguments("kept", "--seed", 1, *quick)
        part = 0.5
        for _ in range(8):
            shutil.rmtree(self.path("kept"), ignore_errors=True)
            shutil.copytree(self.path("finished"), self.path("kept"))
            before = self.files_in("kept")
            code, error = self.interrupted(arguments, signal.SIGTERM, part * seconds, attempts=1)
            if code == 5:
                break
            part *= 0.7 if code >= 0 else 1.5
        self.assertEqual(code, 5, error)
        self.assertIn("still contains the previous result", error)
        self.assertEqual(error.count("\n"), 1, error)
        after = self.files_in("kept")
        self.assertTrue(after.pop("resume.json"))
        self.assertTrue(after == before)
        self.succeed(*arguments, "--resume")
        self.succeed(*self.arguments("at-once", "--seed", 1, *quick))
        self.assert_same_bytes("kept", "at-once")

    def test_a_calibration_that_is_killed_again_and_again_is_gone_on_from(self):
        arguments = self.arguments("killed", "--skip-comparison")
        self.succeed(*self.arguments("unkilled", "--skip-comparison"))
        size = self.killed(arguments, "killed", 0)
        size = self.killed(arguments + ["--resume"], "killed", size)
        resume = self.path("killed/resume.json")
        good = read(resume)
        # Another seed, features or numbers than those it is of.
        self.assert_refused(run(*arguments, "--resume", "--seed", 1), 2, "other features")
        features = read(self.path("sim/features.csv")).replace(b"1\n", b"2\n", 1)
        other = write(self.path("other.csv"), features)
        changed = [other if part == self.path("sim/features.csv") else part for part in arguments]
        self.assert_refused(run(*changed, "--resume"), 2, "other features")
        digit = good.rindex(b".") + 1
        write(resume, good[:digit] + (b"1" if good[digit:digit + 1] != b"1" else b"2")
              + good[digit + 1:])
        self.assert_refused(run(*arguments, "--resume"), 2, "was modified")
        write(resume, good)
        self.succeed(*arguments, "--resume")
        self.assert_same_bytes("killed", "unkilled")

    def test_a_rig_is_gone_on_from(self):
        self.succeed("simulate", "--images", 8, "--features-per-image", 40, "--cameras",
                     2, "--pattern", self.board, "-o", self.path("rig"))

        def arguments(output, *more):
            return ["calibrate", "--features", self.path("rig/features.csv"), "--image-size",
                    "640x480", "--pattern", self.path("rig/pattern.yaml"), "--knot-spacing-px", 160,
                    "--skip-comparison", "--threads", 1, "-o", self.path(output), *more]

        seconds = self.finished(arguments("rig-whole"))
        code, error = self.interrupted(arguments("rig-part"), signal.SIGINT, 0.5 * seconds)
        self.assertEqual(code, 5, error)
        self.assertIn("--resume", error)
        self.assertIn("resume.json", os.listdir(self.path("rig-part")))
        self.assertEqual(json.loads(read(self.path("rig-part/result.json")))["status"],
                         "interrupted")
        self.succeed(*arguments("rig-part", "--resume"))
        self.assert_same_bytes("rig-part", "rig-whole")

    def test_packing_hears_it_too(self):
        """A signal is heard within a second: of work, since tests run side by side."""
        self.succeed("simulate", "--images", 8, "--lens", "wide", "--size", "4000x3000",
                     "--features-per-image", 100, "-o", self.path("large"))
        command = [programs.raygrid, "calibrate", "--features", self.path("large/features.csv"),
                   "--image-size", "4000x3000", "--pattern", self.path("large/pattern.yaml"),
                   "--knot-spacing-px", "500", "--skip-comparison", "--threads", "1", "-o",
                   self.path("large-out")]
        code, seconds = self.signalled(command, 0.3, signal.SIGTERM)
        self.assertIn(code, (5, -signal.SIGTERM))
        self.assertLess(seconds, 2.5)

    def test_a_second_signal_ends_it_at_once(self):
        command = [programs.raygrid, *map(str, self.arguments("twice", "--knot-spacing-px", 12))]
        code, seconds = self.signalled(command, 0.8, signal.SIGINT, signal.SIGINT)
        self.assertIn(code, (-signal.SIGINT, 5))
        self.assertLess(seconds, 3)

    def test_other_commands_end_at_once_and_leave_no_half_written_file(self):
        folder = self.path("rendered")
        command = [programs.raygrid, "simulate", "--render", "--images", "500", "-o", folder]
        code, seconds = self.signalled(command, 1, signal.SIGINT)
        self.assertEqual(code, -signal.SIGINT)
        self.assertLess(seconds, 3)
        for place, _, names in os.walk(folder):
            for name in names:
                if name.endswith(".png"):
                    self.assertEqual(read(os.path.join(place, name))[-8:-4], b"IEND", name)

    def test_a_script_that_tries_again_may_always_say_resume(self):
        """Where there is nothing yet, and where all is done."""
        coarse = ("--resume", "--knot-spacing-px", 160)
        self.succeed(*self.arguments("empty", *coarse))
        camera = read(self.path("empty/camera.yaml"))
        self.succeed(*self.arguments("empty", *coarse))
        self.assertEqual(read(self.path("empty/camera.yaml")), camera)


if __name__ == "__main__":
    main(__name__)
