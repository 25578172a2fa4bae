#!/usr/bin/env python3
"""An output replaces no input, and a command says what cannot be written."""
import os
import resource
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
            cls.succeed(*arguments)

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
                self.assert_refused(self.undistort(blob, frame, out), 7, "overwrite an input")
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
            result = self.undistort(*arguments, self.path("never.raw"))
            self.assert_refused(result, 2, "pipe", "cannot be read")

    # ---- Limits of the shell ----------------------------------------------------

    def limited(self, limit, value, *arguments, program=None):
        return subprocess.run(
            [program or programs.raygrid, *map(str, arguments)], capture_output=True, text=True,
            stdin=subprocess.DEVNULL, check=False,
            preexec_fn=lambda: resource.setrlimit(limit, (value, value)))

    def calibration(self, output):
        return ("calibrate", "--features", self.path("sim/features.csv"), "--image-size",
                "160x120", "--pattern", self.path("board.yaml"), "--model", "opencv",
                "--skip-comparison", "--fix-target-geometry", "--hold-out", "sim0001.png", "--quiet", "-o",
                self.path(output))

    def test_no_folder_gets_the_name_of_a_file(self):
        board = "chessboard:9x6:25mm"
        features = write(self.path("features.csv"), "image,board,column,row,x,y\na,0,0,0,1,1\n")
        image = write(self.path("image.pgm"), b"P5 64 48 255\n" + bytes(64 * 48))
        for name in ("camera.yaml", "out.png", "front.raygrid", "features.csv", "a.b/report.html"):
            path = self.path("named/" + name)
            for command in (("simulate", "--images", 2, "--pattern", board),
                            ("calibrate", "--features", features, "--image-size", "64x48", "--pattern", board),
                            ("undistort", self.path("c.raygrid"), image)):
                self.assert_refused(run(*command, "-o", path), 1, path, "specify a folder")
                self.assertFalse(os.path.exists(path))

        two = write(self.path("two.json"), '{"a": {"K": [9, 0, 4, 0, 9, 3, 0, 0, 1], "D": [0, 0, 0, 0, 0]}, '
                    '"b": {"K": [9, 0, 4, 0, 9, 3, 0, 0, 1], "D": [0, 0, 0, 0, 0]}}')
        self.assert_refused(run("import", two, "--image-size", "8x6", "-o", self.path("named/camera.yaml")), 1,
                            "specify a folder")

    def test_a_refused_command_leaves_no_empty_folder(self):
        image = write(self.path("left/image.pgm"), b"P5 64 48 255\n" + bytes(64 * 48))
        features = write(self.path("left/features.csv"), "image,board,column,row,x,y\na,0,0,0,1,1\n")
        for command in (("undistort", self.path("c.raygrid"), image),
                        ("experiment", "repeatability", "--features", features, "--image-size", "64x48",
                         "--pattern", self.path("board.yaml"))):
            with self.subTest(command[0]):
                result = run(*command, "-o", self.path("refused/out"))
                self.assertNotEqual(result.returncode, 0)
                self.assertFalse(os.path.exists(self.path("refused")))

    def test_a_limit_on_the_size_of_files_is_a_failure_to_write(self):
        frame = write(self.path("small/in.raw"), FRAME)
        result = self.limited(resource.RLIMIT_FSIZE, 4096, self.path("c.raygrid"), frame,
                              self.path("small/out.raw"), program=programs.undistort)
        self.assert_refused(result, 7, "cannot be written")
        result = self.limited(resource.RLIMIT_FSIZE, 1024, "pack",
                              self.path("sim/true_camera.yaml"), "-o", self.path("small/c.raygrid"))
        self.assert_refused(result, 7, "cannot be written")
        self.assertEqual(os.listdir(self.path("small")), ["in.raw"])
        result = self.limited(resource.RLIMIT_FSIZE, 4096, *self.calibration("limits/size"))
        self.assert_refused(result, 7, "cannot be written")
        self.assert_nothing_in(self.path("limits/size"))
        self.assertEqual(os.listdir(self.path("limits")), ["size"])

    def test_a_limit_on_open_files_leaves_nothing_behind(self):
        for limit in (4, 5, 6):
            with self.subTest(limit):
                result = self.limited(resource.RLIMIT_NOFILE, limit,
                                      *self.calibration("open/files"))
                if result.returncode == 0:
                    break
                self.assert_refused(result, 7, "Too many open files")
                # A checkpoint may stay: what was calibrated need not be calibrated again.
                self.assertIn(os.listdir(self.path("open/files")), ([], ["resume.json"]))
                self.assertEqual(os.listdir(self.path("open")), ["files"])


if __name__ == "__main__":
    main(__name__)
