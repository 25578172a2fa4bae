#!/usr/bin/env python3
"""What is written replaces no input, and what cannot be written is said."""
import os
import subprocess

from command_test import CommandTest, SIMULATED_PATTERN, main, programs, read, run, write

FRAME = bytes((x * y) % 251 for y in range(120) for x in range(160))


class Outputs(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for arguments in (("simulate", "--images", 8, "--lens", "wide", "--size", "160x120",
                           "--pattern", write(cls.path("board.yaml"), SIMULATED_PATTERN), "-o",
                           cls.path("sim")),
                          ("pack", cls.path("sim/true_camera.yaml"), "--remap", "160x120", "-o",
                           cls.path("c.raygrid"))):
            result = run(*arguments)
            assert result.returncode == 0, result.stderr

    def undistort(self, *arguments, **options):
        return run(*arguments, program=programs.undistort, **options)

    # ---- The board's program --------------------------------------------------

    def test_the_boards_program_replaces_neither_blob_nor_frame(self):
        blob, frame = self.path("c.raygrid"), write(self.path("board/in.raw"), FRAME)
        os.symlink(frame, self.path("board/link.raw"))
        os.link(blob, self.path("board/hard"))
        good = read(blob)
        for out in (blob, frame, self.path("board/link.raw"), self.path("board/hard"),
                    self.path("board/../board/in.raw")):
            with self.subTest(out):
                self.assert_refused(self.undistort(blob, frame, out), 7, "replace an input")
                self.assertTrue(read(blob) == good and read(frame) == FRAME)
        # Not even a frame of the name that the output has while it is written.
        part = write(self.path("board/out.raw.part"), FRAME)
        self.assert_done(self.undistort(blob, part, self.path("board/out.raw")))
        self.assertEqual(read(part), FRAME)

    def test_the_boards_program_says_when_nobody_can_read_what_it_prints(self):
        frame = write(self.path("full/in.raw"), FRAME)
        for arguments in ((self.path("c.raygrid"), frame, self.path("full/out.raw")), ("--help",)):
            with open("/dev/full", "w") as full:
                result = subprocess.run([programs.undistort, *arguments], stdout=full,
                                        stderr=subprocess.PIPE, text=True, check=False)
            result.stdout = ""
            self.assert_refused(result, 7, "standard output")

    def test_the_boards_program_waits_for_no_pipe(self):
        os.mkfifo(self.path("pipe"))
        for arguments in ((self.path("pipe"), self.path("c.raygrid")),
                          (self.path("c.raygrid"), self.path("pipe"))):
            result = self.undistort(*arguments, self.path("never.raw"), timeout=10)
            self.assert_refused(result, 2, "pipe", "cannot be read")


if __name__ == "__main__":
    main(__name__)
