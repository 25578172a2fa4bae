#!/usr/bin/env python3
"""Luxonis's depthai reads the calibrations that raygrid writes, and sees what raygrid does."""
import json
import math
import os
import re
import subprocess
import sys

from command_test import CommandTest, HERE, main, read, write

VENV = os.path.join(HERE, "..", "..", "build", "depthai")
SIZE = (160, 120)


def depthai():
    """A Python that has depthai, in a folder of the build; None if it cannot be had."""
    python = os.path.join(VENV, "bin", "python")
    has_it = lambda: os.path.exists(python) and subprocess.run(
        [python, "-c", "import sys, importlib.util as u; sys.exit(not u.find_spec('depthai'))"],
        capture_output=True, check=False).returncode == 0
    if not has_it():
        subprocess.run([sys.executable, "-m", "venv", VENV], capture_output=True, check=False)
        subprocess.run([python, "-m", "pip", "install", "-q", "--retries", "0", "--timeout", "5",
                        "depthai"], capture_output=True, check=False)
    return python if has_it() else None


def camera(model, values):
    return ("raygrid_camera: 1\nmodel: {}\nimage_size: [{}, {}]\narea: [0, 0, {}, {}]\n"
            "parameters: {{{}}}\n".format(model, *SIZE, SIZE[0] - 1, SIZE[1] - 1, ", ".join(
                f"{name}: {value!r}" for name, value in values.items())))


INTRINSICS = {"fx": 110.25, "fy": 111.5, "cx": 80.75, "cy": 58.25}
COEFFICIENTS = (-0.2, 0.05, 1e-3, -2e-3, 0.01, 0.02, -0.01, 0.005, 1e-3, 2e-3, -1e-3, 5e-4, 0.01,
                -0.02)
NAMES = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4", "tx", "ty")
RIG = """raygrid_rig: 1
cameras:
  "left":
    file: "lens.yaml"
    camera_from_rig:
      rotation: {w: 1, x: 0, y: 0, z: 0}
      translation: {x: 0, y: 0, z: 0}
  "right":
    file: "lens.yaml"
    camera_from_rig:
      rotation: {w: 0.8, x: 0, y: 0, z: 0.6}
      translation: {x: -0.075, y: 0.01, z: 0.002}
  "rgb":
    file: "wide.yaml"
    camera_from_rig:
      rotation: {w: 1, x: 0, y: 0, z: 0}
      translation: {x: -0.0375, y: 0, z: 0}
"""


class DepthAi(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        write(cls.path("lens.yaml"), camera("opencv-14", {
            **INTRINSICS, **dict(zip(NAMES, COEFFICIENTS))}))
        write(cls.path("wide.yaml"), camera("thin-prism-fisheye", {
            **INTRINSICS, "fx": 70.5, "fy": 70.25, "k1": 0.02, "k2": -0.01, "k3": 0.003,
            "k4": -1e-3, "p1": 0.0, "p2": 0.0, "sx1": 0.0, "sy1": 0.0}))
        write(cls.path("rig.yaml"), RIG)

    def export(self, source, out):
        result = self.succeed("export", self.path(source), "--to", "depthai", "-o", self.path(out))
        self.assertIn("exact", result.stdout)
        return self.path(out)

    def told(self, python, points, *files):
        write(self.path("points.json"), json.dumps(points))
        result = subprocess.run(
            [python, os.path.join(HERE, "depthai_peer.py"), self.path("points.json"),
             json.dumps(SIZE), *files], capture_output=True, text=True, check=False)
        self.assert_done(result)
        return json.loads(result.stdout.partition("\nresult:")[2])

    def seen(self, source, points):
        text = "x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in points)
        result = self.succeed("project", self.path(source), "--points", write(self.path("p.csv"), text))
        rows = [line.split(",") for line in result.stdout.split()[1:]]
        return [(float(row[3]), float(row[4])) if row[5] == "1" else None for row in rows]

    def off(self, theirs, ours):
        pairs = [pair for pair in zip(theirs, ours) if pair[1]]
        self.assertGreater(len(pairs), 0.6 * len(ours))
        return max(math.dist(*pair) for pair in pairs)

    def test_depthai_sees_what_raygrid_does(self):
        """More than 10,000 rays of two lenses, but for depthai's numbers of 32 bits; half a pixel is
        seen. Its order is that of OpenCV."""
        python = depthai()
        if not python:
            self.skipTest("pip cannot install depthai; the test needs access to PyPI")
        points = [(x / 50, y / 50, 1.0) for y in range(-37, 38) for x in range(-45, 46)]
        files = {name: self.export(name + ".yaml", name + ".json") for name in ("lens", "wide")}
        text = read(files["lens"]).decode()
        moved = write(self.path("moved.json"), text.replace("80.75", "81.25"))
        self.assertNotEqual(read(moved).decode(), text)
        rig = self.export("rig.yaml", "rig.json")
        lens, wide, mutant, three = self.told(python, points, *files.values(), moved, rig)
        lens, wide, mutant = (told["cameras"]["CAM_A"] for told in (lens, wide, mutant))
        self.assertEqual((lens["model"], wide["model"]), ("Perspective", "Fisheye"))
        for ours, theirs in zip(COEFFICIENTS, lens["coefficients"]):
            self.assertAlmostEqual(ours, theirs, 7)
        self.assertEqual(lens["matrix"], [[110.25, 0, 80.75], [0, 111.5, 58.25], [0, 0, 1]])
        ours = {name: self.seen(name + ".yaml", points) for name in files}
        self.assertGreater(sum(seen is not None for seen in ours["lens"] + ours["wide"]), 10000)
        self.assertLess(self.off(lens["seen"], ours["lens"]), 1e-4)
        self.assertLess(self.off(wide["seen"], ours["wide"]), 1e-4)
        self.assertGreater(self.off(mutant["seen"], ours["lens"]), 0.49)
        self.check_rig(three)

    def check_rig(self, told):
        """Sockets by the cameras' names; poses in the first camera's frame, in centimetres."""
        self.assertEqual(sorted(told["cameras"]), ["CAM_A", "CAM_B", "CAM_C"])
        # The right camera is turned by 73.74 degrees about z: cos 0.28, sin 0.96.
        for socket, expected in (("CAM_C", [[0.28, 0.96, 0, 0.28 * 7.5 - 0.96],
                                            [-0.96, 0.28, 0, -0.96 * 7.5 - 0.28],
                                            [0, 0, 1, -0.2]]),
                                 ("CAM_A", [[1, 0, 0, 3.75], [0, 1, 0, 0], [0, 0, 1, 0]])):
            for ours, theirs in zip(expected, told["to_first"][socket]):
                for a, b in zip(ours, theirs):
                    self.assertAlmostEqual(a, b, 5)
        for a, b in zip((-0.075, 0.01, 0.002), told["from_first_m"]["CAM_C"]):
            self.assertAlmostEqual(a, b, 6)

    def test_a_rig_comes_back(self):
        """Exactly, with names and poses."""
        rig = self.export("rig.yaml", "rig.json")
        self.succeed("import", rig, "-o", self.path("back/rig.yaml"))
        numbers = lambda path: [float(word) for word in re.findall(
            r"[xyzw]: ([-\d.]+)", read(path).decode())]
        for a, b in zip(numbers(self.path("rig.yaml")), numbers(self.path("back/rig.yaml"))):
            self.assertAlmostEqual(a, b, 8)
        points = [(0.1, 0.2, 1), (-0.3, 0.1, 1)]
        self.assertEqual(self.seen("back/left/camera.yaml", points), self.seen("lens.yaml", points))
        self.assertEqual(self.seen("back/rgb/camera.yaml", points), self.seen("wide.yaml", points))


if __name__ == "__main__":
    main(__name__)
