#!/usr/bin/env python3
"""Files of keys that raygrid exports, read by rules of their programs, and read back."""
import math
import os
import subprocess
import unittest

from command_test import CommandTest, HERE, main, python_with, read, run, write
from exchange_test import CONVERT, OPENCV_FILE

PEER = os.path.join(HERE, "keyed_peer.py")
PYTHON = python_with("cv2", "tomllib", "yaml")

FISHEYE_FILE = (OPENCV_FILE.replace("image_width", "fisheye_model: 1\nimage_width")
                .replace("cols: 5", "cols: 4")
                .replace("-0.25, 0.08, 1e-3, -2e-3, -0.01", "0.03, -0.01, 4e-3, -1e-3"))
POINTS = [(0.1 * i, 0.09 * j, 1.1) for i in range(-4, 5) for j in range(-4, 5)]

# The formats that are exported, and their files' names.
ENDINGS = {"gyroflow": "json", "orbslam": "yaml", "camodocal": "yaml", "euroc": "yaml",
           "anipose": "toml", "okvis": "yaml", "opensfm": "json", "kitti": "txt"}
WITH_POSES = ("anipose", "okvis", "kitti", "euroc")


def pixels_of(text):
    return [tuple(map(float, line.split(",")[:2])) for line in text.split()]


class KeyedFormats(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for name, text in (("pinhole", OPENCV_FILE), ("fisheye", FISHEYE_FILE)):
            source = write(cls.path(f"{name}.source.yaml"), text)
            cls.succeed("import", source, "-o", cls.path(f"{name}.yaml"))
        write(cls.path("points.csv"), "x,y,z\n" + "".join(
            f"{x!r},{y!r},{z!r}\n" for x, y, z in POINTS))
        # The second camera turns by 0.2 rad about y and stands 0.1 m beside the first.
        write(cls.path("rig.yaml"),
              "raygrid_rig: 1\ncameras:\n"
              "  cam0: {file: pinhole.yaml, camera_from_rig: {rotation: {w: 1, x: 0, y: 0, z: 0}, "
              "translation: {x: 0, y: 0, z: 0}}}\n"
              f"  cam1: {{file: pinhole.yaml, camera_from_rig: {{rotation: {{w: {math.cos(0.1)!r}, "
              f"x: 0, y: {math.sin(0.1)!r}, z: 0}}, translation: {{x: -0.1, y: 0.01, z: 0.02}}}}}}"
              "\n")

    def export(self, source, name, *options):
        out = self.path(f"{os.path.basename(source)}.{name}.{ENDINGS.get(name, 'xml')}")
        result = self.succeed("export", source, "--to", name, "-o", out, *options)
        return out, result.stdout

    def projected(self, camera, points="points.csv"):
        result = self.succeed("project", camera, "--points", self.path(points))
        return [tuple(map(float, line.split(",")[3:5])) if line.endswith(",1") else None
                for line in result.stdout.split()[1:]]

    def assert_same(self, seen, expected, tolerance=2e-8):
        self.assertEqual(len(seen), len(expected))
        self.assertGreater(len([pixel for pixel in expected if pixel]), 20)
        for (u, v), pixel in zip(seen, expected):
            if pixel:
                self.assertLess(math.hypot(u - pixel[0], v - pixel[1]), tolerance)

    def peer(self, name, file, camera):
        result = subprocess.run([PYTHON, PEER, name, file, self.path("points.csv"), camera],
                                capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        return pixels_of(result.stdout)

    @unittest.skipUnless(PYTHON, "no Python has cv2, tomllib and yaml; "
                                 "'tools/install_packages tests' installs them")
    def test_programs_see_what_raygrid_sees(self):
        for lens in ("pinhole", "fisheye"):
            expected = self.projected(self.path(lens + ".yaml"))
            for name in ENDINGS:
                if lens == "fisheye" and name == "kitti":
                    continue
                with self.subTest(name, lens=lens):
                    file, said = self.export(self.path(lens + ".yaml"), name)
                    self.assertIn("exact", said)
                    camera = "cam_0" if name in ("anipose", "opensfm") else "cam0"
                    self.assert_same(self.peer(name, file, camera), expected)

    def test_files_come_back(self):
        for lens in ("pinhole", "fisheye"):
            expected = self.projected(self.path(lens + ".yaml"))
            for name in (*ENDINGS, "ros-ini"):
                if lens == "fisheye" and name in ("kitti", "ros-ini"):
                    continue
                with self.subTest(name, lens=lens):
                    file, _ = self.export(self.path(lens + ".yaml"), name)
                    back = self.path("back.yaml")
                    self.succeed("import", file, "-o", back)
                    self.assert_same([pixel or (0, 0) for pixel in self.projected(back)], expected,
                                     1e-9)

    @unittest.skipUnless(PYTHON, "no Python has cv2, tomllib and yaml; "
                                 "'tools/install_packages tests' installs them")
    def test_poses_of_a_rig(self):
        rotate = lambda x, y, z: (x * math.cos(0.2) + z * math.sin(0.2) - 0.1, y + 0.01,
                                  z * math.cos(0.2) - x * math.sin(0.2) + 0.02)
        write(self.path("second.csv"), "x,y,z\n" + "".join(
            "{!r},{!r},{!r}\n".format(*rotate(*point)) for point in POINTS))
        expected = self.projected(self.path("pinhole.yaml"), "second.csv")
        for name in WITH_POSES:
            with self.subTest(name):
                out = self.path("rig_" + name + ("" if name == "euroc" else "." + ENDINGS[name]))
                self.succeed("export", self.path("rig.yaml"), "--to", name, "-o", out)
                file = os.path.join(out, "cam1.yaml") if name == "euroc" else out
                self.assert_same(self.peer(name, file, "cam1"), expected)

    def test_names_of_cameras_become_names_of_files(self):
        lens = ("size = [160, 120]\nmatrix = [[150, 0, 80], [0, 150, 60], [0, 0, 1]]\n"
                "distortions = [0, 0, 0, 0, 0]\nrotation = [0, 0, {}]\ntranslation = [0, 0, 0]\n")
        file = write(self.path("names.toml"), "".join(
            f'[cam_{k}]\nname = "Camera 00{k}"\n{lens.format(k)}' for k in (0, 1)))
        self.succeed("import", file, "-o", self.path("names/rig.yaml"))
        for name in ("Camera-000/camera.yaml", "Camera-001/camera.yaml", "rig.yaml"):
            self.assertTrue(os.path.exists(os.path.join(self.path("names"), name)), name)

    def test_nearest_lenses_say_their_error(self):
        for name in ("kitti", "ros-ini"):
            file, said = self.export(self.path("fisheye.yaml"), name)
            self.assertRegex(said, r"RMS 0\.[0-9]+ px")
        self.assertIn("Fitted", read(file).decode())
        file, said = self.export(self.path("fisheye.yaml"), "ocamcalib")
        self.assertRegex(said, r"RMS \S+ px")
        self.assertIn("#fitted polynomial: RMS ", read(file).decode())
        self.succeed("import", file, "-o", self.path("back.yaml"))
        file, said = self.export(self.path("fisheye.yaml"), "dso")
        self.assertIn("EquiDistant, exact", said)
        refused = run("export", self.path("fisheye.yaml"), "--to", "kitti", "-o",
                      self.path("none.txt"), "--max-fit-error-px", "0.0001")
        self.assert_refused(refused, 6, "--max-fit-error-px")

    @unittest.skipUnless(os.path.exists(CONVERT), "no ROS parser; "
                                               "'tools/install_packages tests' installs it")
    def test_the_parser_of_ros_reads_the_ini(self):
        file = self.path("camera.ini")
        self.succeed("export", self.path("pinhole.yaml"), "--to", "ros-ini", "-o", file)
        theirs = self.path("theirs.yaml")
        result = subprocess.run([CONVERT, file, theirs], capture_output=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        for source, out in ((theirs, "a.yaml"), (file, "b.yaml")):
            self.succeed("import", source, "-o", self.path(out))
        self.assertEqual(self.projected(self.path("a.yaml")), self.projected(self.path("b.yaml")))


if __name__ == "__main__":
    main(__name__)
