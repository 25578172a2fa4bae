#!/usr/bin/env python3
"""COLMAP sees what raygrid says it sees, and its files come through."""
import math
import os
import re
import shutil
import subprocess
import sys
import unittest

from command_test import HERE, main, read, run, write
from exchange_test import ExchangeTest, turned

VENV = os.path.join(HERE, "..", "..", "build", "pycolmap")
COLMAP = shutil.which("colmap")
NO_COLMAP = "no colmap; 'tools/install_packages tests' installs it"
EMPTY = {"images.txt": b"", "points3D.txt": b"", "images.bin": bytes(8), "points3D.bin": bytes(8)}


def pycolmap():
    """A Python that has pycolmap, in a folder of the build; None if it cannot be had."""
    python = os.path.join(VENV, "bin", "python")
    has_it = lambda: os.path.exists(python) and subprocess.run(
        [python, "-c", "import pycolmap"], capture_output=True, check=False).returncode == 0
    if not has_it():
        subprocess.run([sys.executable, "-m", "venv", VENV], capture_output=True, check=False)
        subprocess.run([python, "-m", "pip", "install", "-q", "--retries", "0", "--timeout", "5",
                        "pycolmap"], capture_output=True, check=False)
    return python if has_it() else None


class Colmap(ExchangeTest):
    MODELS = ("THIN_PRISM_FISHEYE", "OPENCV_FISHEYE", "FULL_OPENCV", "OPENCV", "SIMPLE_RADIAL",
              "EUCM")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.camera = cls.simulated_camera("wide", "640x256")

    def model(self, name):
        """A folder for COLMAP's files, of no image."""
        for file, contents in EMPTY.items():
            write(self.path(f"{name}/{file}"), contents)
        return self.path(name)

    def drop(self, folder, ending):
        """Without the files of one kind, so that COLMAP reads the other."""
        for file in EMPTY:
            if file.endswith(ending):
                os.remove(os.path.join(folder, file))

    def seen_by_colmap(self, python, rays, *folders):
        result = subprocess.run([python, os.path.join(HERE, "colmap_peer.py"), self.points(rays),
                                 *folders], capture_output=True, text=True, check=False)
        self.assert_done(result)
        seen = [tuple(map(float, line.split(","))) for line in result.stdout.split()]
        return [seen[k:k + len(rays)] for k in range(0, len(seen), len(rays))]

    def assert_sees(self, theirs, ours, largest):
        """COLMAP's first pixel is at (0.5, 0.5), raygrid's at (0, 0)."""
        off = [math.dist((u - 0.5, v - 0.5), own) for (u, v), own in zip(theirs, ours) if own]
        self.assertGreater(len(off), 0.97 * len(ours))
        self.assertLess(max(off), largest)

    def test_colmap_projects_as_raygrid_says(self):
        """10,000 rays; and half a pixel is seen."""
        python = pycolmap()
        if not python:
            self.skipTest("pip cannot install pycolmap; the test needs access to PyPI")
        step = 639 / 160
        _, rays = self.rays(self.camera, [(x * step, y * step) for y in range(64)
                                          for x in range(161) if x * step <= 639])
        self.assertGreater(len(rays), 10000)
        folders, ours = [], []
        for k, model in enumerate(self.MODELS):
            ending = (".txt", ".bin")[k % 2]
            folder = self.model(model)
            self.drop(folder, (".bin", ".txt")[k % 2])
            fit = self.export(self.camera, "--to", "colmap", "--model", model,
                              out=f"{model}/cameras{ending}")["cameras"][0]["fit"]
            if k == 0:
                rays = [turned(fit["model_from_camera_wxyz"], ray) for ray in rays]
            folders.append(folder)
            ours.append(self.seen(self.path(f"{model}/cameras{ending}"), rays))
        shifted = self.model("shifted")
        self.drop(shifted, ".bin")
        good = read(self.path(f"{self.MODELS[0]}/cameras.txt")).decode()
        write(self.path("shifted/cameras.txt"), re.sub(
            "(?m)^(1 \\w+ 640 256 [\\d.]+ [\\d.]+) ([\\d.]+)",
            lambda found: f"{found[1]} {float(found[2]) - 0.5!r}", good))
        theirs = self.seen_by_colmap(python, rays, *folders, shifted)
        for model, seen, own in zip(self.MODELS, theirs, ours):
            with self.subTest(model):
                self.assert_sees(seen, own, 1e-6)
        with self.assertRaises(AssertionError):
            self.assert_sees(theirs[-1], ours[0], 1e-6)

    @unittest.skipUnless(COLMAP, NO_COLMAP)
    def test_colmap_converts_what_raygrid_writes(self):
        """The parameters come back to the bit, through text and bytes of COLMAP's own."""
        for model in ("THIN_PRISM_FISHEYE", "FULL_OPENCV"):
            for kind, other in (("txt", "BIN"), ("bin", "TXT")):
                folder = self.model(f"from_{model}_{kind}")
                self.drop(folder, "." + other.lower())
                self.export(self.camera, "--to", "colmap", "--model", model,
                            out=f"from_{model}_{kind}/cameras.{kind}")
                converted = self.path(f"to_{model}_{kind}")
                os.makedirs(converted)
                self.succeed("model_converter", "--input_path", folder, "--output_path",
                             converted, "--output_type", other, program=COLMAP)
                cameras = []
                for source in (f"{folder}/cameras.{kind}", f"{converted}/cameras.{other.lower()}"):
                    self.succeed("import", source, "-o", self.path("c.yaml"))
                    text = read(self.path("c.yaml"))
                    cameras.append(re.sub(rb"(?m)^name:.*\n", b"", text))
                self.assertEqual(*cameras)

    def test_import_after_export_is_the_camera(self):
        write(self.path("m/cameras.txt"), "7 SIMPLE_RADIAL 160 120 150.25 80.5 60 -0.125\n")
        self.succeed("import", self.path("m/cameras.txt"), "-o", self.path("first.yaml"))
        for more, model in (((), "OPENCV"), (("--model", "SIMPLE_RADIAL"), "SIMPLE_RADIAL")):
            for ending in ("txt", "bin"):
                told = self.export(self.path("first.yaml"), "--to", "colmap", *more,
                                   out="cameras." + ending)["cameras"][0]
                self.assertEqual((told["model"], told["exact"]), (model, True))
                self.succeed("import", self.path("cameras." + ending), "-o",
                             self.path("second.yaml"))
                self.assertEqual(read(self.path("first.yaml")), read(self.path("second.yaml")))
        self.assertIn(b"cx: 80\n", read(self.path("first.yaml")))

    def test_rigs_stand_beside_their_cameras(self):
        cameras = "".join(f"{k} OPENCV 160 120 150 151 80 60 0.1 0 0 0\n" for k in (3, 5))
        rig = "1 2 CAMERA 3 CAMERA 5 1 0.8 0 0 0.6 1 2 3\n"
        write(self.path("r/cameras.txt"), cameras)
        write(self.path("r/rigs.txt"), rig)
        self.succeed("import", self.path("r/cameras.txt"), "-o", self.path("r1/rig.yaml"))
        first = read(self.path("r1/rig.yaml"))
        self.assertEqual(first.count(b"z: 0.600000000000"), 1)
        for ending in ("txt", "bin"):
            told = self.export(self.path("r1/rig.yaml"), "--to", "colmap",
                               out=f"r_{ending}/cameras.{ending}")
            self.assertEqual([os.path.basename(file) for file in told["files"]],
                             ["cameras." + ending, "rigs." + ending])
            self.succeed("import", told["files"][0], "-o",
                         self.path(f"r2_{ending}/rig.yaml"))
            again = read(self.path(f"r2_{ending}/rig.yaml"))
            if ending == "bin":  # which has no names
                again = again.replace(b"camera2", b"camera5").replace(b"camera1", b"camera3")
            self.assertEqual(first, again)

    def posed(self, ending, *names):
        """A model with poses, and the poses."""
        self.count = getattr(self, "count", 0) + 1
        out = f"{self.id()}_{self.count}"
        lines = ["image,board,qw,qx,qy,qz,tx,ty,tz"]
        for k, name in enumerate(names):
            turn = math.sqrt(0.5 - 0.01 * k)
            lines.append(f"{name},0,{turn:.9f},{math.sqrt(1 - round(turn, 9) ** 2):.9f},0.000000000,"
                         f"0.000000000,{k / 7:.9f},-0.250000000,{1 + k / 3:.9f}")
        poses = write(self.path("known.csv"), "\n".join(lines) + "\n")
        write(self.path("c/cameras.txt"), "7 OPENCV 160 120 150 151 80 60 0.1 0 0 0\n")
        self.succeed("import", self.path("c/cameras.txt"), "-o", self.path("c.yaml"))
        told = self.export(self.path("c.yaml"), "--to", "colmap", "--poses", poses,
                           out=f"{out}/cameras.{ending}")
        self.assertEqual([os.path.basename(file) for file in told["files"]],
                         [f"{stem}.{ending}" for stem in ("cameras", "images", "points3D")])
        return self.path(out), poses

    def imported(self, folder):
        self.succeed("import", folder, "-o", self.path("poses.csv"))
        return read(self.path("poses.csv"))

    @unittest.skipUnless(COLMAP, NO_COLMAP)
    def test_poses_go_through_colmap(self):
        """Text and bytes, before and after COLMAP's own conversion; a moved image is seen."""
        for ending, other in (("txt", "BIN"), ("bin", "TXT")):
            folder, poses = self.posed(ending, "a.png", "b.png", "deep/c.png")
            self.assertEqual(self.imported(folder), read(poses))
            converted = self.path("converted_" + ending)
            os.makedirs(converted)
            self.succeed("model_converter", "--input_path", folder, "--output_path",
                         converted, "--output_type", other, program=COLMAP)
            self.assertEqual(self.imported(converted), read(poses))
        images = read(self.path("converted_bin/images.txt")).decode()
        moved = re.sub(r"(?m)^(1( \S+){4}) (\S+)", r"\1 0.5", images)
        self.assertNotEqual(moved, images)
        write(self.path("converted_bin/images.txt"), moved)
        self.assertNotEqual(self.imported(converted), read(poses))

    def test_colmap_stands_where_the_poses_say(self):
        """Where COLMAP sees points of the board is where raygrid does."""
        python = pycolmap()
        if not python:
            self.skipTest("pip cannot install pycolmap; the test needs access to PyPI")
        folder, poses = self.posed("bin", "a.png", "b.png")
        seen = self.seen_by_images(python, folder)
        for pose in read(poses).decode().split()[1:]:
            image, _, *numbers = pose.split(",")
            numbers = list(map(float, numbers))
            ours = [a + b for a, b in zip(turned(numbers[:4], self.POINT), numbers[4:])]
            self.assertLess(math.dist(ours, seen.pop(image)), 1e-8)
        self.assertEqual(seen, {})

    POINT = (0.1, 0.2, 0.3)

    def seen_by_images(self, python, folder):
        """A point of the world in the axes of each image of COLMAP's."""
        peer = """
import sys, numpy as np, pycolmap
for image in pycolmap.Reconstruction(sys.argv[1]).images.values():
    seen = image.cam_from_world() * np.array(list(map(float, sys.argv[2:])))
    print(image.name, *map(repr, map(float, seen)))
"""
        result = subprocess.run([python, "-c", peer, folder, *map(str, self.POINT)], text=True,
                                capture_output=True, check=False)
        self.assert_done(result)
        rows = [line.split() for line in result.stdout.splitlines()]
        return {name: list(map(float, seen)) for name, *seen in rows}

    def test_frames_hold_the_images_of_a_rig(self):
        python = pycolmap()
        if not python:
            self.skipTest("pip cannot install pycolmap; the test needs access to PyPI")
        write(self.path("f/cameras.txt"), "".join(
            f"{k} OPENCV 160 120 150 151 80 60 0.1 0 0 0\n" for k in (3, 5)))
        write(self.path("f/rigs.txt"), "1 2 CAMERA 3 CAMERA 5 1 0.8 0 0 0.6 1 2 3\n")
        self.succeed("import", self.path("f"), "-o", self.path("f1/rig.yaml"))
        poses = write(self.path("f1/poses.csv"), "camera,image,board,qw,qx,qy,qz,tx,ty,tz\n"
                      "camera3,a.png,0,1.000000000,0.000000000,0.000000000,0.000000000,"
                      "0.000000000,0.000000000,1.000000000\n"
                      "camera5,a.png,0,0.800000000,0.000000000,0.000000000,0.600000000,"
                      "1.000000000,2.000000000,4.000000000\n")
        for ending in ("txt", "bin"):
            told = self.export(self.path("f1/rig.yaml"), "--to", "colmap", "--poses", poses,
                               out=f"f_{ending}/cameras.{ending}")
            self.assertEqual([os.path.basename(file) for file in told["files"]], [
                f"{stem}.{ending}" for stem in ("cameras", "rigs", "frames", "images", "points3D")])
            seen = self.seen_by_images(python, self.path(f"f_{ending}"))
            first, second = seen["camera3/a.png"], seen["camera5/a.png"]
            self.assertLess(math.dist(first, (0.1, 0.2, 1.3)), 1e-12)
            turn = turned((0.8, 0, 0, 0.6), first)
            self.assertLess(math.dist(second, [turn[0] + 1, turn[1] + 2, turn[2] + 3]), 1e-12)
        self.assertEqual(self.imported(self.path("f_txt")), read(poses))

    def test_a_reconstruction_is_not_replaced(self):
        folder, poses = self.posed("txt", "a.png")
        again = ("export", self.path("c.yaml"), "--to", "colmap", "--poses", poses, "-o",
                 folder + "/cameras.txt")
        write(poses, read(poses).replace(b"-0.250000000", b"0.500000000"))
        self.succeed(*again)
        self.assertEqual(self.imported(folder), read(poses))
        write(folder + "/points3D.txt", "1 0 0 0 0 0 0 0\n")
        self.assert_refused(run(*again), 7, "points3D.txt", "another folder")
        self.assertEqual(read(folder + "/points3D.txt"), b"1 0 0 0 0 0 0 0\n")
        self.assert_refused(run("import", self.path("sim_wide"), "-o", self.path("x.yaml")), 2,
                            "cameras.bin")

    def test_what_cannot_be(self):
        text = "1 OPENCV 160 120 150 151 80 60 0.1 0 0 0\n"
        self.succeed("import", write(self.path("x/cameras.txt"), text), "-o",
                     self.path("x.yaml"))
        binary = self.path("x/cameras.bin")
        self.succeed("export", self.path("x.yaml"), "--to", "colmap", "-o", binary)
        for name, contents, words in (
                ("a.txt", text.replace("OPENCV", "FOV"), ("FOV", "not supported")),
                ("b.txt", text.replace("0.1", "nan"), ("line 1", "'nan'")),
                ("c.bin", read(binary)[:-3], ("truncated after 93 bytes",)),
                ("d.bin", read(binary)[:12] + b"\x63" + read(binary)[13:], ("unknown model 99",)),
                ("e.txt", text + text, ("duplicate",))):
            with self.subTest(name):
                self.assert_refused(run("import", write(self.path(name), contents), "-o",
                                        self.path("never.yaml")), 2, name, *words)
        self.assert_refused(run("import", binary, "--from", "opencv", "-o",
                                self.path("never.yaml")), 2, "colmap, not opencv")
        self.assertFalse(os.path.exists(self.path("never.yaml")))


if __name__ == "__main__":
    main(__name__)
