#!/usr/bin/env python3
"""Large text files take little more memory than their size, or are refused by a limit."""
import json
import os
import subprocess
import sys

from command_test import CommandTest, PATTERN, main, programs, write

HEADER = "image,board,column,row,x,y\n"
MEGABYTE = 1 << 20

# What the program takes with a small file or a file at one of its limits, and what it may take
# beyond that per byte of a file: 100 MB fit in 500 MB. Sanitizers take about three times as much.
BASE_MB = 100
MB_PER_MB = 4
SECONDS_PER_MB = 0.2

# Runs a command from a small process: the peak memory of a child counts that of its parent, which
# holds large texts here.
MEASURE = """
import json, resource, subprocess, sys
done = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps([done.returncode, done.stderr.decode(), usage.ru_maxrss / 1024,
                  usage.ru_utime + usage.ru_stime]))
"""


class LargeFiles(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.pattern = write(cls.path("pattern.yaml"), PATTERN)
        cls.succeed("simulate", "--images", 2, "-o", cls.path("sim"))
        cls.camera = cls.path("sim/true_camera.yaml")

    def run_bounded(self, size_mb, *arguments):
        """Exit code and standard error of a command, after checks of its memory and CPU time."""
        options = os.environ.get("ASAN_OPTIONS", "") + ":quarantine_size_mb=1"
        done = subprocess.run([sys.executable, "-S", "-c", MEASURE, programs.raygrid, *arguments],
                              capture_output=True, text=True, check=True,
                              env={**os.environ, "ASAN_OPTIONS": options})
        code, error, max_mb, seconds = json.loads(done.stdout)
        factor = 3 if "sanitized" in programs.raygrid.lower() or "asan" in programs.raygrid else 1
        self.assertLess(max_mb, factor * (BASE_MB + MB_PER_MB * size_mb), error)
        self.assertLess(seconds, factor * (1 + SECONDS_PER_MB * size_mb))
        return code, error

    def refuse(self, path, words, *arguments):
        code, error = self.run_bounded(os.path.getsize(path) / MEGABYTE, *arguments)
        self.assertEqual(code, 2, error)
        self.assertEqual(error.count("\n"), 1, error)
        for word in (os.path.basename(path), *words):
            self.assertIn(word, error)

    def test_features_are_read_whatever_their_number(self):
        lines = [f"image_{image:05}.png,0,{column},{row},{10 + 60 * column:.5f},"
                 f"{12 + 70 * row:.5f}\n"
                 for image in range(4000) for row in range(6) for column in range(9)]
        path = write(self.path("features.csv"), HEADER + "".join(lines))
        code, error = self.run_bounded(os.path.getsize(path) / MEGABYTE, "inspect", path)
        self.assertEqual(code, 0, error)
        # A feature that its image has twice is found at the second of its lines.
        twice = write(self.path("twice.csv"), HEADER + "".join(lines[:3000] + [lines[7]]))
        self.refuse(twice, ("line 3002", "duplicate feature"), "inspect", twice)

    def test_tables_with_more_rows_than_any_calibration_has(self):
        images = write(self.path("images.csv"),
                       HEADER + "".join(f"{k},0,0,0,1,1\n" for k in range(500001)))
        self.refuse(images, ("line 500002", "500000 images"), "inspect", images)
        image = write(self.path("image.csv"), HEADER + "".join(
            f"a,0,{k},0,1,1\n" for k in range(100001)))
        self.refuse(image, ("line 100002", "100000 features"), "inspect", image)
        pixels = write(self.path("pixels.csv"), "x,y\n" + "0,0\n" * 500001)
        self.refuse(pixels, ("line 500002", "500000 rows"), "unproject", self.camera,
                    "--pixels", pixels, "--json")

    def test_features_are_calibrated_up_to_a_number(self):
        lines = "".join(f"image_{{0:05}}.png,0,{column},{row},{10 + 60 * column},{12 + 70 * row}\n"
                        for row in range(6) for column in range(9))
        path = write(self.path("video.csv"),
                     HEADER + "".join(lines.format(image) for image in range(9300)))
        self.refuse(path, ("502200 features in 9300 images", "500000", "one of every 2 images"),
                    "calibrate", "--features", path, "--image-size", "640x480", "--pattern",
                    self.pattern, "-o", self.path("video"))

    def test_what_a_run_leaves_for_the_next_one(self):
        os.makedirs(self.path("session"), exist_ok=True)
        session = write(self.path("session/session.json"),
                        '{"raygrid_session": 1, "frames": [' + "1," * MEGABYTE + "1]}\n")
        self.refuse(session, ("1000000", "values"), "calibrate", self.path("session"))
        # Nothing is parsed that is not what was written for these inputs.
        os.makedirs(self.path("killed"), exist_ok=True)
        resume = write(self.path("killed/resume.json"),
                       '{"raygrid_resume":4,"inputs":"a","cameras":[' + "1," * (8 * MEGABYTE) + "1]}\n")
        code, error = self.run_bounded(
            5, "calibrate", "--features", self.path("sim/features.csv"), "--image-size", "640x480",
            "--pattern", self.path("sim/pattern.yaml"), "--resume", "-o", self.path("killed"))
        self.assertEqual(code, 2, error)
        self.assertIn(f"{resume}: was written for other features", error)

    def test_trees_with_more_values_than_any_camera_has(self):
        values = "- 1\n" * (2 * MEGABYTE)
        for name, text in (("camera.yaml", "raygrid_camera: 1\nx:\n" + values),
                           ("pattern.yaml", "raygrid_pattern: 1\nboards:\n" + values),
                           ("rig.yaml", "raygrid_rig: 1\ncameras:\n" + values),
                           ("mtx.json", '{"mtx": [' + "1," * (4 * MEGABYTE) + '1], "dist": []}\n'),
                           ("mtx.xml", '<?xml version="1.0"?>\n<opencv_storage>'
                            + "<a/>" * (2 * MEGABYTE) + "</opencv_storage>\n")):
            path = write(self.path("many_" + name), text)
            with self.subTest(name):
                self.refuse(path, ("1000000", "values"), "inspect", path)
        path = write(self.path("long.yaml"), "raygrid_camera: 1\nx: " + "a b " * (17 * MEGABYTE))
        self.refuse(path, ("69 MB", "64"), "inspect", path)

    def test_keys_of_a_table_are_found_quickly(self):
        for name, text in (
                ("many.toml", "[a]\nmatrix = 1\ndistortions = 1\nrotation = 1\n" + "".join(
                    f"k{k} = 1\n" for k in range(60000))),
                ("many.xml", '<?xml version="1.0"?>\n<opencv_storage>' + "".join(
                    f"<k{k}>1</k{k}>" for k in range(60000)) + "</opencv_storage>\n")):
            path = write(self.path(name), text)
            with self.subTest(name):
                code, error = self.run_bounded(30, "inspect", path)
                self.assertEqual(code, 2, error)


if __name__ == "__main__":
    main(__name__)
