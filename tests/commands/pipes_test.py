#!/usr/bin/env python3
"""Pipes: read where somebody writes to them, as <(...) of a shell does; else named."""
import os
import subprocess
import threading
import time
from concurrent.futures import ThreadPoolExecutor

from command_test import CommandTest, main, programs, read, run, write


class Pipes(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.succeed("simulate", "--images", 2, "--lens", "wide", "--size", "160x120", "-o",
                    cls.path("sim"))
        cls.camera = cls.path("sim/true_camera.yaml")
        cls.pixels = write(cls.path("px.csv"), "x,y\n80,60\n")
        cls.pipe = cls.path("pipe")
        os.mkfifo(cls.pipe)

    def test_a_pipe_that_nobody_writes_to_is_named(self):
        cases = (("inspect", self.pipe), ("unproject", self.camera, "--pixels", self.pipe),
                 ("unproject", self.pipe, "--pixels", self.pixels),
                 ("evaluate", self.camera, "--features", self.pipe, "--pattern",
                  self.path("sim/pattern.yaml")),
                 ("calibrate", "--features", self.path("sim/features.csv"), "--image-size",
                  "160x120", "--pattern", self.pipe, "-o", self.path("out")))
        with ThreadPoolExecutor(len(cases)) as pool:  # each waits for seconds
            results = list(pool.map(lambda arguments: run(*arguments), cases))
        for arguments, result in zip(cases, results):
            with self.subTest(arguments[0]):
                self.assert_refused(result, 2, "pipe", "no process writes")

    def test_a_pipe_that_nobody_reads_is_named(self):
        result = run("unproject", self.camera, "--pixels", self.pixels, "-o", self.pipe)
        self.assert_refused(result, 7, "pipe", "cannot be written")

    def test_what_a_shell_substitutes_is_read(self):
        expected = self.succeed("unproject", self.camera, "--pixels", self.pixels)
        for line in ('"$0" unproject <(cat "$1") --pixels <(cat "$2")',
                     '"$0" unproject "$1" --pixels <(sleep 7; cat "$2")',
                     'cat "$2" | "$0" unproject "$1" --pixels /dev/stdin'):
            with self.subTest(line):
                result = subprocess.run(
                    ["bash", "-c", line, programs.raygrid, self.camera, self.pixels],
                    capture_output=True, text=True, check=False)
                self.assert_done(result)
                self.assertEqual(result.stdout, expected.stdout)
        for name in ("true_camera.yaml", "pattern.yaml", "features.csv"):
            path = self.path("sim/" + name)
            result = subprocess.run(["bash", "-c", '"$0" inspect <(cat "$1")', programs.raygrid,
                                     path], capture_output=True, text=True, check=False)
            self.assert_done(result)
            self.assertEqual(result.stdout, run("inspect", path).stdout)

    def test_a_pipe_that_is_written_or_read_a_little_later(self):
        def write_later():
            time.sleep(1)
            write(self.pipe, read(self.pixels))

        writer = threading.Thread(target=write_later)
        writer.start()
        self.succeed("unproject", self.camera, "--pixels", self.pipe)
        writer.join()
        got = []
        reader = threading.Thread(target=lambda: (time.sleep(1), got.append(read(self.pipe))))
        reader.start()
        self.succeed("unproject", self.camera, "--pixels", self.pixels, "-o", self.pipe)
        reader.join()
        self.assertTrue(got[0].startswith(b"x,y,dx,dy,dz\n"), got)


if __name__ == "__main__":
    main(__name__)
