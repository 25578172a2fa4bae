"""Runs the commands of offline/TUTORIAL.md, in their order, on OpenCV's photographs."""
import os
import re
import shlex

import command_test
from command_test import CommandTest, programs, read, write

TUTORIAL = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../offline/TUTORIAL.md")


class Tutorial(CommandTest):
    def test_every_command_runs(self):
        if not os.path.isdir(os.path.join(programs.photographs, "left")):
            self.skipTest("no photographs; tools/fetch_photographs fetches them")
        blocks = re.findall(r"^```sh\n(.*?)^```", read(TUTORIAL).decode(), re.MULTILINE | re.DOTALL)
        commands = [shlex.split(line) for block in blocks for line in block.splitlines()]
        self.assertGreater(len(commands), 8)
        for name, side in (("photos", "left"), ("left", "left"), ("right", "right")):
            os.symlink(os.path.abspath(os.path.join(programs.photographs, side)), self.path(name))
        write(self.path("pixels.csv"), "x,y\n320,240\n")
        before = os.getcwd()
        os.chdir(self.path("."))
        try:
            for name, *words in commands:
                with self.subTest(command=[name, *words]):
                    program = programs.undistort if name == "raygrid-undistort" else programs.raygrid
                    # The comparison of models takes most of the time, and is tested elsewhere.
                    more = ["--skip-comparison"] if words[0] == "calibrate" else []
                    self.succeed(*words, *more, program=program)
        finally:
            os.chdir(before)
        for made in ("board/pattern.pdf", "seen/coverage.png", "result/report.html", "sheet.png",
                     "result/uncertainty.png", "front.camera.yaml", "flat.pgm", "front.c", "calibration.yaml",
                     "rectified/rectified.yaml", "rectified/right/right12.png"):
            self.assertTrue(os.path.getsize(self.path(made)), made)


if __name__ == "__main__":
    command_test.main(__name__)
