#!/usr/bin/env python3
"""Export and import: other programs see what raygrid says they see, and files come through."""
import json
import math
import os
import random
import re
import subprocess
import sys
import unittest
from xml.etree import ElementTree

from command_test import (CommandTest, HERE, NO_OPENCV, SIMULATED_PATTERN, main, python_with, read, run,
                          write)

OPENCV_PEER = os.path.join(HERE, "opencv_peer.py")
PYTHONS = (sys.executable, "/usr/bin/python3")
OPENCV = python_with("cv2")
CONVERT = "/usr/lib/camera_calibration_parsers/convert"

OPENCV_FILE = """%YAML:1.0
---
image_width: 160
image_height: 120
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 150., 0., 80.25, 0., 151., 59.5, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -0.25, 0.08, 1e-3, -2e-3, -0.01 ]
"""


def turned(quaternion, vector):
    """A vector after a rotation w, x, y, z."""
    w, *axis = quaternion
    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                          a[0] * b[1] - a[1] * b[0]]
    once = cross(axis, vector)
    twice = cross(axis, once)
    return [v + 2 * (w * a + b) for v, a, b in zip(vector, once, twice)]


def rms(errors):
    return math.sqrt(sum(error * error for error in errors) / len(errors))


class ExchangeTest(CommandTest):
    def rays(self, camera, pixels):
        """The directions of pixels; those without any are left out, as are their pixels."""
        text = "x,y\n" + "".join(f"{x!r},{y!r}\n" for x, y in pixels)
        result = self.succeed("unproject", camera, "--pixels", write(self.path("px.csv"), text), "--json")
        rows = [row for row in json.loads(result.stdout) if row["dx"] is not None]
        return ([(row["x"], row["y"]) for row in rows],
                [(row["dx"], row["dy"], row["dz"]) for row in rows])

    def points(self, rays):
        return write(self.path("xyz.csv"),
                     "x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in rays))

    def seen(self, camera, rays):
        """Where raygrid sees directions; None where it does not."""
        result = self.succeed("project", camera, "--points", self.points(rays), "--json")
        return [(row["u"], row["v"]) if row["valid"] else None
                for row in json.loads(result.stdout)]

    def export(self, camera, *arguments, out="out.yaml"):
        result = self.succeed("export", camera, *arguments, "--json", "-o", self.path(out))
        return json.loads(result.stdout)


class OpenCv(ExchangeTest):
    MODELS = ("opencv4", "opencv5", "opencv8", "opencv12", "opencv14", "fisheye")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.camera = cls.simulated_camera("wide", "640x256")

    def seen_by_opencv(self, rays, *files):
        """Where OpenCV sees directions in the camera's frame, for each file."""
        result = subprocess.run([OPENCV, OPENCV_PEER, self.points(rays), *map(self.path, files)],
                                capture_output=True, text=True, check=False)
        self.assert_done(result)
        seen = [tuple(map(float, line.split(","))) for line in result.stdout.split()]
        return [seen[k:k + len(rays)] for k in range(0, len(seen), len(rays))]

    @unittest.skipUnless(OPENCV, NO_OPENCV)
    def test_opencv_projects_as_raygrid_says(self):
        """10,000 rays; the error that is told is the one that OpenCV has."""
        step = 639 / 160
        pixels, rays = self.rays(self.camera, [(x * step, y * step) for y in range(64)
                                               for x in range(161) if x * step <= 639])
        self.assertGreater(len(rays), 10000)
        files = [f"{model}.{ending}" for model, ending in
                 zip(self.MODELS, ("yaml", "xml", "json") * 2)]
        fits = [self.export(self.camera, "--to", "opencv", "--model", model,
                            out=file)["cameras"][0]["fit"]
                for model, file in zip(self.MODELS, files)]
        for file, fit, theirs in zip(files, fits, self.seen_by_opencv(rays, *files)):
            with self.subTest(file):
                ours = self.seen(self.path(file), [turned(fit["model_from_camera_wxyz"], ray)
                                                   for ray in rays])
                distances = [math.dist(a, b) for a, b in zip(ours, theirs) if a]
                self.assertGreater(len(distances), 0.98 * len(rays))
                self.assertLess(max(distances), 1e-6)
                errors = sorted(math.dist(*pair) for pair in zip(pixels, theirs))
                self.assertAlmostEqual(rms(errors), fit["rms_px"], 4)
                self.assertAlmostEqual(errors[len(errors) * 99 // 100], fit["p99_px"], 2)
                self.assertAlmostEqual(errors[-1], fit["max_px"], 3)

    @unittest.skipUnless(OPENCV, NO_OPENCV)
    def test_half_a_pixel_is_seen(self):
        self.export(self.camera, "--to", "opencv", "--model", "opencv8", out="good.yaml")
        good = read(self.path("good.yaml"))
        shifted = re.sub(rb"(data: \[ [\d.]+, 0.0, )([\d.]+)",
                         lambda found: found[1] + b"%.9f" % (float(found[2]) + 0.5), good)
        self.assertNotEqual(good, shifted)
        write(self.path("shifted.yaml"), shifted)
        rays = [(x / 10, y / 10, 1) for x in range(-5, 6) for y in range(-2, 3)]
        seen = self.seen_by_opencv(rays, "good.yaml", "shifted.yaml")
        for a, b in zip(*seen):
            self.assertAlmostEqual(math.dist(a, b), 0.5, 6)

    def test_a_file_of_opencv_is_a_camera_everywhere(self):
        theirs = write(self.path("theirs.yml"), OPENCV_FILE)
        self.succeed("pack", theirs, "--remap", "160x120,alpha=0", "-o", self.path("front.raygrid"))
        self.succeed("inspect", self.path("front.camera.yaml"))
        told = self.succeed("inspect", theirs)
        self.assertIn("intrinsics: fx 150, fy 151, cx 80.25, cy 59.5, k1 -0.25, k2 0.08, p1 0.001, "
                      "p2 -0.002, k3 -0.01, k4 0, k5 0, k6 0", told.stdout)
        told = json.loads(run("inspect", theirs, "--json").stdout)
        self.assertEqual((told["format"], told["model"], list(told["intrinsics"])[4:8]),
                         ("opencv", "opencv", ["k1", "k2", "p1", "p2"]))
        pixels, rays = self.rays(theirs, [(5, 5), (80, 60), (150, 110)])
        for pixel, seen in zip(pixels, self.seen(self.path("front.raygrid"), rays)):
            self.assertLess(math.dist(pixel, seen), 0.05)
        self.succeed("import", theirs, "-o", self.path("mine.yaml"))
        result = self.succeed("compare", theirs, self.path("mine.yaml"), "--json")
        self.assertLess(json.loads(result.stdout)["max_px"], 1e-6)

    def test_import_after_export_is_the_camera(self):
        self.succeed("import", write(self.path("t.yml"), OPENCV_FILE), "-o",
                     self.path("first.yaml"))
        for ending in ("yaml", "xml", "json"):
            told = self.export(self.path("first.yaml"), "--to", "opencv", out="x." + ending)
            self.assertEqual((told["cameras"][0]["model"], told["cameras"][0]["exact"]),
                             ("opencv5", True))
            self.succeed("import", self.path("x." + ending), "-o",
                         self.path("second.yaml"))
            self.assertEqual(read(self.path("first.yaml")), read(self.path("second.yaml")))


# Kalibr and ROS cannot be asked here: their formulas again, from their papers.

def radtan(x, y, k1, k2, p1, p2):
    r2 = x * x + y * y
    g = 1 + k1 * r2 + k2 * r2 * r2
    return (x * g + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * g + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y)


def equidistant(x, y, *k):
    r = math.hypot(x, y)
    theta = math.atan(r)
    scale = theta * (1 + sum(c * theta ** (2 * i + 2) for i, c in enumerate(k))) / r
    return x * scale, y * scale


def kalibr_pixel(camera, ray):
    """Where a camera of a camchain, as a dictionary of its keys, sees a unit direction."""
    x, y, z = ray
    *first, fu, fv, pu, pv = camera["intrinsics"]
    model = camera["camera_model"]
    if model == "pinhole":
        depth = z
    elif model == "omni":
        depth = z + first[0]
    elif model == "ds":
        xi, alpha = first
        depth = alpha * math.sqrt(x * x + y * y + (xi + z) ** 2) + (1 - alpha) * (xi + z)
    else:
        alpha, beta = first
        depth = alpha * math.sqrt(beta * (x * x + y * y) + z * z) + (1 - alpha) * z
    x, y = x / depth, y / depth
    distort = {"radtan": radtan, "equidistant": equidistant,
               "none": lambda x, y: (x, y)}[camera["distortion_model"]]
    x, y = distort(x, y, *camera["distortion_coeffs"])
    return fu * x + pu, fv * y + pv


def camchain(text):
    """The cameras of a camchain that raygrid wrote: a key a line."""
    cameras = []
    for line in text.splitlines():
        if re.match(r"cam\d+:", line):
            cameras.append({})
        found = re.match(r"  (\w+): (.*)", line)
        if found:
            value = found[2]
            cameras[-1][found[1]] = json.loads(value) if value[0] in "[\"" else value
    return cameras


class Kalibr(ExchangeTest):
    MODELS = ("pinhole-none", "pinhole-radtan", "pinhole-equi", "omni-none", "omni-radtan",
              "ds-none", "eucm-none")

    def test_kalibrs_formulas_see_what_raygrid_says(self):
        """10,000 rays of all models together, those of a fisheye of 190 degrees where it can."""
        wide, fisheye = self.simulated_camera("wide"), self.simulated_camera("fisheye190")
        draw = random.Random(3).uniform
        pixels = [(draw(1, 158), draw(1, 118)) for _ in range(1500)]
        rays = {camera: self.rays(camera, pixels)[1] for camera in (wide, fisheye)}
        for model in self.MODELS:
            with self.subTest(model):
                source = wide if model.startswith("pinhole") else fisheye
                fit = self.export(source, "--to", "kalibr", "--model",
                                  model)["cameras"][0]["fit"]
                camera, = camchain(read(self.path("out.yaml")).decode())
                bodies = [turned(fit["model_from_camera_wxyz"], ray) for ray in rays[source]]
                pairs = [(a, kalibr_pixel(camera, ray)) for a, ray in
                         zip(self.seen(self.path("out.yaml"), bodies), bodies) if a]
                self.assertGreater(len(pairs), 1400)
                self.assertLess(max(math.dist(*pair) for pair in pairs), 1e-6)
                camera["intrinsics"][-2] += 0.5
                body = bodies[0]
                self.assertAlmostEqual(math.dist(self.seen(self.path("out.yaml"), [body])[0] or
                                                 pairs[0][0], kalibr_pixel(camera, body)), 0.5, 5)


# Basalt cannot be asked here: its formulas again, from the double sphere paper (arXiv 1807.08957)
# and OpenCV's documentation.

def basalt_pixel(camera, ray):
    """Where a camera of a calibration, as it stands there, sees a unit direction."""
    p = camera["intrinsics"]
    x, y, z = ray
    rho2 = x * x + y * y
    kind = camera["camera_type"]
    if kind == "kb4":
        rho, theta = math.sqrt(rho2), math.atan2(math.sqrt(rho2), z)
        scale = (theta + sum(p[f"k{k}"] * theta ** (2 * k + 1) for k in range(1, 5))) / rho
        x, y = x * scale, y * scale
    elif kind.startswith("pinhole"):
        x, y, r2 = x / z, y / z, rho2 / z / z
        k1, k2, k3, k4, k5, k6, p1, p2 = (p.get(key, 0) for key in (
            "k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"))
        g = (1 + k1 * r2 + k2 * r2 ** 2 + k3 * r2 ** 3) / (1 + k4 * r2 + k5 * r2 ** 2 + k6 * r2 ** 3)
        x, y = (x * g + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                y * g + 2 * p2 * x * y + p1 * (r2 + 2 * y * y))
    else:
        alpha, beta, along = p["alpha"], p.get("beta", 1), z
        if kind == "ds":
            along = z + p["xi"] * math.sqrt(rho2 + z * z)
        depth = alpha * math.sqrt(beta * rho2 + along ** 2) + (1 - alpha) * along
        x, y = x / depth, y / depth
    return p["fx"] * x + p["cx"], p["fy"] * y + p["cy"]


# nerfstudio takes too long to load: its formula again, from radial_and_tangential_undistort() and
# the rays of its cameras, whose first pixel is at (0.5, 0.5).

def nerfstudio_pixel(camera, ray):
    """Where the camera of a transforms.json sees a unit direction, in raygrid's pixels."""
    k1, k2, k3, k4, p1, p2 = (camera[key] for key in ("k1", "k2", "k3", "k4", "p1", "p2"))
    x, y, z = ray
    along = z
    if camera["camera_model"] == "OPENCV_FISHEYE":
        rho = math.hypot(x, y)
        along = rho / math.atan2(rho, z)
    x, y = x / along, y / along
    r = x * x + y * y
    g = 1 + r * (k1 + r * (k2 + r * (k3 + r * k4)))
    x, y = (x * g + 2 * p1 * x * y + p2 * (r + 2 * x * x),
            y * g + 2 * p2 * x * y + p1 * (r + 2 * y * y))
    return camera["fl_x"] * x + camera["cx"] - 0.5, camera["fl_y"] * y + camera["cy"] - 0.5


# Metashape cannot be asked here: its formulas again, from the appendix of its manual. The centre of
# its first pixel is at (0.5, 0.5).

def metashape_pixel(camera, ray):
    """Where the camera of a calibration, by its elements, sees a unit direction."""
    x, y, z = ray
    x, y = x / z, y / z
    if camera["projection"] == "fisheye":
        r0 = math.hypot(x, y)
        x, y = x * math.atan(r0) / r0, y * math.atan(r0) / r0
    r2 = x * x + y * y
    k1, k2, k3, k4, p1, p2 = (float(camera.get(key, 0)) for key in (
        "k1", "k2", "k3", "k4", "p1", "p2"))
    g = 1 + k1 * r2 + k2 * r2 ** 2 + k3 * r2 ** 3 + k4 * r2 ** 4
    x, y = (x * g + p1 * (r2 + 2 * x * x) + 2 * p2 * x * y,
            y * g + p2 * (r2 + 2 * y * y) + 2 * p1 * x * y)
    f, b1, cx, cy, width, height = (float(camera[key]) for key in (
        "f", "b1", "cx", "cy", "width", "height"))
    return (width * 0.5 + cx + x * f + x * b1 - 0.5, height * 0.5 + cy + y * f - 0.5)


# libcamera's vertex map is not part of its interface: its formula again, from dewarpPoint().

def libcamera_camera(text):
    numbers = {key: [float(word) for word in re.search(key + r": \[(.*?)\]", text, re.DOTALL)[1]
                     .replace(",", " ").split()] for key in ("cm", "coefficients")}
    camera = {"fx": numbers["cm"][0], "fy": numbers["cm"][4], "cx": numbers["cm"][2],
              "cy": numbers["cm"][5], "k": (numbers["coefficients"] + [0] * 8)[:12]}
    return camera, camera


def libcamera_pixel(camera, ray):
    x, y = ray[0] / ray[2], ray[1] / ray[2]
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = camera["k"]
    r2 = x * x + y * y
    d = ((1 + k1 * r2 + k2 * r2 ** 2 + k3 * r2 ** 3) / (1 + k4 * r2 + k5 * r2 ** 2 + k6 * r2 ** 3))
    x, y = (x * d + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + s1 * r2 + s2 * r2 * r2,
            y * d + 2 * p2 * x * y + p1 * (r2 + 2 * y * y) + s3 * r2 + s4 * r2 * r2)
    return x * camera["fx"] + camera["cx"], y * camera["fy"] + camera["cy"]


# The authors' program cannot be had here: its formula again, from the paper and its files.

def spline_weights(t):
    return ((1 - t) ** 3 / 6, (3 * t ** 3 - 6 * t * t + 4) / 6,
            (-3 * t ** 3 + 3 * t * t + 3 * t + 1) / 6, t ** 3 / 6)


def puzzlepaint_ray(camera, pixel):
    """The direction of a pixel of raygrid, of any length; the program's pixels begin at the
    corner."""
    cells, weights = [], []
    for axis, (x, side) in enumerate(zip(pixel, ("grid_width", "grid_height"))):
        low, high = (camera[f"calibration_{end}_{'xy'[axis]}"] for end in ("min", "max"))
        place = 1 + (camera[side] - 3) * (x + 0.5 - low) / (high + 1 - low)
        cells.append(int(place))
        weights.append(spline_weights(place - cells[-1]))
    ray = [0, 0, 0]
    for j, wy in enumerate(weights[1]):
        for i, wx in enumerate(weights[0]):
            at = 3 * ((cells[1] + j - 1) * camera["grid_width"] + cells[0] + i - 1)
            for axis in range(3):
                ray[axis] += wx * wy * camera["grid"][at + axis]
    return ray


class Formulas(ExchangeTest):
    """Formulas of programs that cannot be asked here see 10,000 rays where raygrid says, and half a
    pixel is seen."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.cameras = [cls.simulated_camera(lens) for lens in ("wide", "fisheye190")]

    def assert_pixels(self, name, models, load, pixel):
        """load() is the camera of a file's text, in which pixel() sees a ray. Its "cx" is a map's."""
        draw = random.Random(4).uniform
        pixels = [(draw(1, 158), draw(1, 118)) for _ in range(11000 // len(models))]
        rays = [self.rays(camera, pixels)[1] for camera in self.cameras]
        count = 0
        for model, is_fisheye in models.items():
            with self.subTest(model):
                fit = self.export(self.cameras[is_fisheye], "--to", name, "--model",
                                  model)["cameras"][0]["fit"]
                camera, center = load(read(self.path("out.yaml")).decode())
                bodies = [turned(fit["model_from_camera_wxyz"], ray) for ray in rays[is_fisheye]]
                pairs = [(seen, body) for seen, body in
                         zip(self.seen(self.path("out.yaml"), bodies), bodies)
                         if seen and (body[2] > 0 or name != "metashape")]
                count += len(pairs)
                off = lambda: max(math.dist(seen, pixel(camera, body)) for seen, body in pairs)
                self.assertLess(off(), 1e-6)
                center["cx"] += 0.5
                self.assertGreater(off(), 0.49)
        self.assertGreater(count, 10000)

    def test_basalt(self):
        def load(text):
            camera, = json.loads(text)["value0"]["intrinsics"]
            return camera, camera["intrinsics"]
        self.assert_pixels("basalt", {"pinhole": 0, "pinhole-radtan8": 0, "kb4": 1, "ds": 1,
                                      "eucm": 1, "ucm": 1}, load, basalt_pixel)

    def test_libcamera(self):
        self.assert_pixels("libcamera", {"dewarp5": 0, "dewarp12": 0}, libcamera_camera,
                           libcamera_pixel)

    def test_nerfstudio(self):
        self.assert_pixels("nerfstudio", {"PINHOLE": 0, "OPENCV": 0, "OPENCV_FISHEYE": 1},
                           lambda text: [json.loads(text)] * 2, nerfstudio_pixel)

    def test_metashape(self):
        def load(text):
            camera = {element.tag: element.text for element in ElementTree.fromstring(text)}
            camera["cx"] = float(camera["cx"])
            return camera, camera
        self.assert_pixels("metashape", {"frame": 0, "fisheye": 1}, load, metashape_pixel)

    def test_puzzlepaint(self):
        """The errors that are told of a grid that is written, and of one that is read, are those
        that the formula has."""
        source = self.cameras[1]
        fit = self.export(source, "--to", "puzzlepaint")["cameras"][0]["fit"]
        self.assertLess(fit["max_px"], 0.01)
        camera = {key: json.loads(value) for key, value in re.findall(
            r"(?m)^(\w+) : (\d+|\[.*\])$", read(self.path("out.yaml")).decode())}
        imported = self.succeed("import", self.path("out.yaml"), "-o", self.path("grid.yaml"), "--json")
        told = re.search(r"RMS ([\d.e-]+) px, .* max ([\d.e-]+) px",
                         json.loads(imported.stdout)["warnings"][0])
        pixels = [(x, y) for y in range(120) for x in range(160) if (x + y) % 3]
        rays = [puzzlepaint_ray(camera, pixel) for pixel in pixels]
        shifted = [puzzlepaint_ray(camera, (x + 0.5, y)) for x, y in pixels[500:700]]
        for file, rms_px, max_px in ((source, fit["rms_px"], fit["max_px"]),
                                     (self.path("grid.yaml"), float(told[1]), float(told[2]))):
            with self.subTest(file):
                seen = self.seen(file, rays + shifted)
                off = [math.dist(*pair) for pair in zip(seen, pixels) if pair[0]]
                self.assertGreater(len(off), 10000)
                self.assertAlmostEqual(rms(off), rms_px, 4)
                self.assertAlmostEqual(max(off), max_px, 3)
                self.assertGreater(rms([math.dist(*pair) for pair in zip(
                    seen[len(rays):], pixels[500:700]) if pair[0]]), 0.4)


class Rigs(ExchangeTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.succeed("simulate", "--cameras", 3, "--baseline-m", 0.1, "--lens", "wide", "--size",
                    "160x120", "--images", 1, "--pattern",
                    write(cls.path("board.yaml"), SIMULATED_PATTERN), "-o", cls.path("sim"))
        cls.rig = cls.path("sim/true_rig.yaml")
        cls.camera = cls.path("sim/true_camera.yaml")

    def two_of_the_rig(self):
        return write(self.path("sim/two.yaml"),
                     re.sub(r'  "cam2":\n(    .*\n)*', "", read(self.rig).decode()))

    def relative_pose(self, rig):
        """Of the second camera in the first one's frame: w, x, y, z and translation."""
        told = read(rig).decode()
        number = r"([-\d.e+]+)"
        rows = re.findall(rf"rotation: {{w: {number}, x: {number}, y: {number}, z: {number}}}\s+"
                          rf"translation: {{x: {number}, y: {number}, z: {number}}}", told)
        first, second = ([float(word) for word in row] for row in rows[:2])
        self.assertAlmostEqual(abs(first[0]), 1, 9)
        self.assertLess(max(map(abs, first[4:])), 1e-9)
        return second

    def check_imported(self, rig, told):
        """What both cameras of the imported rig see of far and near points is what those of the
        source do, but for the error that was told."""
        second = self.relative_pose(rig)
        turn = told["cameras"][0]["fit"]["model_from_camera_wxyz"]
        points = [(x / 5, y / 5, 0.5 + (x + y) % 3) for x in range(-2, 3) for y in range(-2, 3)]
        shifted = [(x - 0.1, y, z) for x, y, z in points]
        truth = [self.seen(self.camera, points), self.seen(self.camera, shifted)]
        lens = [turned(turn, point) for point in points]
        moved = [[a + b for a, b in zip(turned(second[:4], point), second[4:])] for point in lens]
        folder = os.path.dirname(rig)
        names = re.findall(r'file: "(.*)"', read(rig).decode())
        for k, seen_from in enumerate((lens, moved)):
            seen = self.seen(os.path.join(folder, names[k]), seen_from)
            pairs = [pair for pair in zip(seen, truth[k]) if None not in pair]
            self.assertGreater(len(pairs), 15)
            self.assertLess(max(math.dist(*pair) for pair in pairs),
                            1.5 * told["cameras"][k]["fit"]["max_px"])

    def test_a_rig_turns_with_its_lenses(self):
        for name, model, files in (("kalibr", "pinhole-radtan", ["out.yaml"]),
                                   ("opencv", "opencv5", ["cvs/cam0.yaml", "cvs/cam1.yaml"]),
                                   ("ros", "plumb_bob", ["ros/cam0.yaml", "ros/cam1.yaml"]),
                                   ("basalt", "kb4", ["out.json"])):
            with self.subTest(name):
                out = files[0].split("/")[0]
                told = self.export(self.two_of_the_rig(), "--to", name, "--model", model, out=out)
                self.assertGreater(abs(told["cameras"][0]["fit"]["model_from_camera_wxyz"][1]), 1e-4)
                rig = self.path(f"rig_{name}/rig.yaml")
                self.succeed("import", *map(self.path, files), "-o", rig)
                self.check_imported(rig, told)

    def test_a_rig_of_three_comes_back(self):
        """Exactly: the cameras are lenses that the formats hold."""
        lens = self.succeed("import", write(self.path("lens.yml"), OPENCV_FILE.replace(", -0.01 ]", ", 0. ]")),
                            "-o", self.path("lens.yaml"))
        text = read(self.rig).decode().replace("sim/true", "true")
        rig = write(self.path("exact/rig.yaml"),
                    re.sub('file: ".*"', 'file: "../lens.yaml"', text))
        first = re.sub('file: ".*"', "", text).replace("-0.000000000", "0.000000000")
        for name, file in (("kalibr", "chain.yaml"), ("basalt", "calibration.json")):
            told = self.export(rig, "--to", name, out=file)
            self.assertEqual([camera["exact"] for camera in told["cameras"]], [True] * 3)
            result = self.succeed("import", self.path(file), "-o", self.path(f"{name}/rig.yaml"))
            self.assertEqual(result.stderr, "")
            back = re.sub('file: ".*"', "", read(self.path(f"{name}/rig.yaml")).decode())
            self.assertEqual(back.replace("-0.000000000", "0.000000000"), first)
            for k in range(3):
                again = read(self.path(f"{name}/cam{k}/camera.yaml"))
                self.assertEqual(again.replace(b'name: "cam%d"\n' % k, b""),
                                 read(self.path("lens.yaml")))
        self.assert_refused(run("pack", self.path("chain.yaml"), "-o", self.path("x.raygrid")), 2,
                            "3 cameras", "raygrid import")

    def check_poses(self, poses, fit):
        """Points of a board are seen in out.yaml where the source sees them."""
        self.succeed("import", self.path("out.yaml"), "-o", self.path("poses.csv"))
        row = lambda path: [float(word) for word in
                            read(path).decode().splitlines()[1].split(",")[2:]]
        first, second = row(poses), row(self.path("poses.csv"))
        points = [(x / 30, y / 30, 0) for x in range(12) for y in range(9)]
        seen = []
        for pose, camera in ((first, self.camera), (second, self.path("out.yaml"))):
            placed = [[a + b for a, b in zip(turned(pose[:4], point), pose[4:])]
                      for point in points]
            seen.append(self.seen(camera, placed))
        pairs = [pair for pair in zip(*seen) if None not in pair]
        self.assertGreater(len(pairs), 5)
        self.assertLess(max(math.dist(*pair) for pair in pairs), 1.5 * fit["max_px"])
        self.assertGreater(math.dist(first[:4], second[:4]), 1e-4)

    def exact_rig(self, rig, name):
        """The rig with lenses that most formats hold exactly."""
        lens = write(self.path("exact.yml"), OPENCV_FILE.replace(", -0.01 ]", ", 0. ]"))
        self.succeed("import", lens, "-o", self.path("exact.yaml"))
        return write(self.path(name), re.sub('file: ".*"', 'file: "exact.yaml"',
                                             read(rig).decode()))

    def test_poses_in_a_rig_are_not_lost_silently(self):
        """Of two and of three cameras, in every format: they come back, or it is said."""
        formats = [entry for entry in json.loads(run("export", "--list", "--json").stdout)
                   if entry["source"] == "a lens" and entry["can_export"] and entry["can_import"]
                   and entry["name"] != "puzzlepaint"]  # whose state has a test of its own
        self.assertGreater(len(formats), 8)
        rigs = {2: self.exact_rig(self.two_of_the_rig(), "two.yaml"),
                3: self.exact_rig(self.rig, "three.yaml")}
        kept = set()
        for entry in formats:
            for count, rig in rigs.items():
                out = self.path(f"as_{entry['name']}_{count}")
                result = self.succeed("export", rig, "--to", entry["name"], "--json", "-o",
                                      out + (".txt" if entry["rigs"] else ""))
                files = json.loads(result.stdout)["files"]
                again = self.path(f"again_{entry['name']}_{count}/rig.yaml")
                imported = run("import", *files[:1 if entry["rigs"] else count],
                               "--image-size", "160x120", "-o", again)
                is_rig = os.path.isfile(again)
                if not is_rig:  # cameras without poses go into a folder
                    self.assert_refused(imported, 1, "specify a folder")
                with self.subTest(format=entry["name"], cameras=count):
                    self.assertEqual("poses of a rig" in result.stderr, not is_rig)
                if is_rig:
                    kept.add((entry["name"], count))
        self.assertLessEqual({("opencv", 3), ("kalibr", 3), ("ros", 2)}, kept)
        self.assertNotIn(("ros", 3), kept)

    def test_poses_turn_with_the_lens(self):
        """Boards stand where the camera sees them, but for the error that was told."""
        poses = self.path("sim/true_poses.csv")
        one = write(self.path("one.csv"), "\n".join(
            ["image,board,qw,qx,qy,qz,tx,ty,tz"] + [line.split(",", 1)[1] for line in
             read(poses).decode().splitlines() if line.startswith("cam0,")]) + "\n")
        for name, model in (("nerfstudio", "OPENCV"), ("opencv", "opencv5")):
            with self.subTest(name):
                self.check_poses(one, self.export(self.camera, "--to", name, "--model", model,
                                                  "--poses", one)["cameras"][0]["fit"])
        rig = self.export(self.two_of_the_rig(), "--to", "opencv", "--model", "opencv4", "--poses",
                          write(self.path("two.csv"), "\n".join(
                              line for line in read(poses).decode().splitlines()
                              if not line.startswith("cam2,")) + "\n"), out="posed")
        self.assertEqual(len(rig["files"]), 2)
        for arguments, code, words in (
                ((self.camera, "--to", "kalibr", "--poses", one), 1, ("--poses", "kalibr")),
                ((self.camera, "--to", "opencv", "--model", "opencv4", "--poses", poses), 2,
                 ("cam0",))):
            self.assert_refused(run("export", *arguments, "-o", self.path("never/x")), code, *words)
        self.assert_refused(run("import", self.path("out.yaml"), "-o", self.path("features.csv")),
                            2, "no features")
        self.assert_refused(run("import", self.path("out.yaml"), "-o", self.path("what.csv")), 1,
                            "features.csv or poses.csv")
        self.assert_nothing_in(self.path("never"))

    @staticmethod
    def puzzlepaint_poses(path):
        """By index: w, x, y, z and translation."""
        poses = {}
        for entry in read(path).decode().split("- index: ")[1:]:
            numbers = dict(re.findall(r"([qt][wxyz]): (\S+)", entry))
            poses[int(entry.split()[0])] = [float(numbers[key]) for key in (
                "qw", "qx", "qy", "qz", "tx", "ty", "tz")]
        return poses

    @staticmethod
    def placed(pose, point):
        return [a + b for a, b in zip(turned(pose[:4], point), pose[4:])]

    def poses_of(self, path):
        """Of a rig's file: camera, image and board, and the pose."""
        return {tuple(line.split(",")[:3]): [float(word) for word in line.split(",")[3:]]
                for line in read(path).decode().splitlines()[1:]}

    def of_two(self, name):
        """A file of the simulation without the third camera."""
        return write(self.path("two_" + name), "\n".join(
            line for line in read(self.path("sim/" + name)).decode().splitlines()
            if not line.startswith("cam2,")) + "\n")

    def assert_poses(self, file, truth):
        poses = self.poses_of(file)
        self.assertEqual(poses.keys(), truth.keys())
        self.assertLess(max(math.dist(poses[key], truth[key]) for key in truth), 1e-8)

    def moved_world(self, state, motion):
        """A state whose world is another one: X' = motion X."""
        w, x, y, z, *t = motion
        back = [w, -x, -y, -z]
        poses = self.puzzlepaint_poses(self.path(state + "/rig_tr_global.yaml"))
        text = f"pose_count: {len(poses)}\nposes:\n"
        for index, (a, b, c, d, *own) in poses.items():
            e, f, g, h = back
            q = (a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g,
                 a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e)
            place = [p - r for p, r in zip(own, turned(q, t))]
            text += f"  - index: {index}\n" + "".join(
                f"    {key}: {value!r}\n" for key, value in zip(
                    ("qw", "qx", "qy", "qz", "tx", "ty", "tz"), (*q, *place)))
        write(self.path(state + "/rig_tr_global.yaml"), text)
        head, numbers, rest = re.match(r"(points : \[)(.*?)(\].*)", read(
            self.path(state + "/points.yaml")).decode(), re.DOTALL).groups()
        numbers = json.loads(f"[{numbers}]")
        points = [self.placed(motion, numbers[k:k + 3]) for k in range(0, len(numbers), 3)]
        write(self.path(state + "/points.yaml"),
              head + ", ".join(repr(value) for point in points for value in point) + rest)

    def test_a_state_of_puzzlepaint_is_the_rig_and_its_poses(self):
        """image = camera_tr_rig rig_tr_global X. Another order is seen, and so is a world that is
        not the board's."""
        poses = self.of_two("true_poses.csv")
        self.succeed("export", self.of_two("features.csv"), "--to", "puzzlepaint-dataset",
                     "--pattern", self.path("board.yaml"), "--image-size", "160x120", "-o",
                     self.path("state/dataset.bin"))
        result = self.succeed("export", self.two_of_the_rig(), "--to", "puzzlepaint", "--poses", poses, "-o",
                              self.path("state"))
        self.assertEqual(result.stderr, "")
        self.assertEqual(sorted(os.listdir(self.path("state"))), [
            "camera_tr_rig.yaml", "dataset.bin", "intrinsics0.yaml", "intrinsics1.yaml",
            "points.yaml", "rig_tr_global.yaml"])
        cameras, (rig,) = (list(self.puzzlepaint_poses(self.path(f"state/{name}.yaml")).values())
                           for name in ("camera_tr_rig", "rig_tr_global"))
        points = [(0, 0, 0), (0.39, 0, 0), (0, 0.27, 0)]
        truth = self.poses_of(poses)
        for k, (camera, pose) in enumerate(zip(cameras, truth.values())):
            for point in points:
                board = self.placed(pose, point)
                self.assertLess(math.dist(self.placed(camera, self.placed(rig, point)), board), 1e-8)
                other = math.dist(self.placed(rig, self.placed(camera, point)), board)
                self.assertGreater(other, 1e-3 if k else -1)
        truth = {(name.replace("cam", "intrinsics"), *rest): pose
                 for (name, *rest), pose in truth.items()}
        self.succeed("import", self.path("state/intrinsics0.yaml"), "-o",
                     self.path("back/rig.yaml"))
        self.assertLess(math.dist(self.relative_pose(self.path("back/rig.yaml")),
                                  self.relative_pose(self.path("sim/two.yaml"))), 1e-8)
        self.succeed("import", self.path("state"), "-o", self.path("state_poses.csv"))
        self.assert_poses(self.path("state_poses.csv"), truth)
        self.moved_world("state", (0.6, 0.48, -0.64, 0.0, 0.1, -0.2, 0.3))
        self.succeed("import", self.path("state"), "-o", self.path("state_poses.csv"))
        self.assert_poses(self.path("state_poses.csv"), truth)
        os.remove(self.path("state/points.yaml"))
        self.succeed("import", self.path("state"), "-o", self.path("state_poses.csv"))
        with self.assertRaises(AssertionError):
            self.assert_poses(self.path("state_poses.csv"), truth)
        result = self.succeed("import", self.path("state/intrinsics1.yaml"), "-o", self.path("one.yaml"))
        self.assertIn("its pose is ignored", result.stderr)

    def test_a_damaged_state_of_puzzlepaint_is_named(self):
        """Before its cameras are read."""
        write(self.path("bad/intrinsics0.yaml"), "calibration_min_x : 0\n")
        never = self.path("never/rig.yaml")
        for name, text, words in (
                ("points.yaml", "points : [1, 2]\n", "points: expected three coordinates"),
                ("dataset.bin", b"calib_data\0\0", "truncated after 12 bytes"),
                ("rig_tr_global.yaml", "pose_count: 1\nposes:\n  - index: 0\n    tx: .nan\n",
                 "poses[0]: qw: expected a finite number"),
                ("camera_tr_rig.yaml", "pose_count: 1\nposes: 5\n", "poses: expected a list")):
            with self.subTest(name):
                file = write(self.path("bad/" + name), text)
                self.assert_refused(run("import", self.path("bad"), "-o", never), 2, file, words)
        self.assert_refused(run("import", self.path("sim"), "-o", never), 2, "sim: the folder contains neither")
        self.assert_nothing_in(self.path("never"))

    def test_rectified_views_are_an_exact_pair(self):
        self.succeed("rectify", self.rig, "--left", "cam0", "--right", "cam1",
                     "--max-error-px", 0.25, "-o", self.path("pair"))
        told = self.export(self.path("pair/rectified.yaml"), "--to", "ros", out="views")
        self.assertEqual([camera["exact"] for camera in told["cameras"]], [True] * 2)
        left, right = ([float(word) for word in re.findall(
            r"projection_matrix:\n.*\n.*\n  data: \[(.*)\]",
            read(self.path(f"views/{name}.yaml")).decode())[0].split(",")]
            for name in ("cam0", "cam1"))
        self.assertAlmostEqual(right[3], -0.1 * right[0], 9)
        self.assertEqual(left[:3] + left[4:], right[:3] + right[4:])
        self.succeed("import", self.path("views/cam0.yaml"), self.path("views/cam1.yaml"),
                     "-o", self.path("views/rig.yaml"))
        self.assertAlmostEqual(self.relative_pose(self.path("views/rig.yaml"))[4], -0.1, 9)

    def test_same_bytes_with_any_number_of_threads(self):
        for threads in (1, 2):
            self.succeed("export", self.camera, "--to", "kalibr", "--threads", threads,
                         "-o", self.path(f"threads{threads}.yaml"))
        self.assertEqual(read(self.path("threads1.yaml")), read(self.path("threads2.yaml")))

    @unittest.skipUnless(os.path.exists(CONVERT), "no ROS parser; 'tools/install_packages tests' installs it")
    def test_the_parser_of_ros_reads_what_is_written(self):
        self.export(self.two_of_the_rig(), "--to", "ros", out="parsed")
        for name in ("cam0.yaml", "cam1.yaml"):
            theirs = self.path("theirs_" + name)
            result = subprocess.run([CONVERT, self.path("parsed/" + name), theirs],
                                    capture_output=True, check=False)
            self.assertEqual(result.returncode, 0, result.stderr)
            for file, out in ((theirs, "a.yaml"), (self.path("parsed/" + name), "b.yaml")):
                self.succeed("import", file, "-o", self.path(out))
            self.assertEqual(read(self.path("a.yaml")), read(self.path("b.yaml")))
            numbers = [re.findall(r"-?\d[\d.e+-]*", read(file).decode().split("rectification")[1])
                       for file in (theirs, self.path("parsed/" + name))]
            self.assertEqual([float(word) for word in numbers[0]],
                             [float(word) for word in numbers[1]])


class Exports(ExchangeTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.camera = cls.simulated_camera("wide")

    def test_the_error_is_told_and_bounded(self):
        result = self.succeed("export", self.camera, "--to", "opencv", "--model", "opencv5", "-o",
                              self.path("e.yaml"))
        for word in ("RMS", "99th percentile", "max", "px at"):
            self.assertIn(word, result.stdout)
        self.assertIn(b"raygrid_fit", read(self.path("e.yaml")))
        result = run("export", self.camera, "--to", "ros", "--max-fit-error-px", 1e-3, "-o",
                     self.path("never/e.yaml"))
        self.assert_refused(result, 6, "--max-fit-error-px 0.001", "--rectified", "degrees")
        self.assert_nothing_in(self.path("never"))

    def test_views_are_exact(self):
        self.succeed("pack", self.camera, "--remap", "200x150,hfov=60", "-o",
                     self.path("v.raygrid"))
        for source, more in ((self.path("v.camera.yaml"), ()), (self.path("v.raygrid"),
                                                               ("--rectified",)),
                             (self.camera, ("--rectified", "--size", "200x150", "--hfov", 60))):
            told = self.export(source, "--to", "opencv", "--max-fit-error-px", 0, *more)
            self.assertTrue(told["cameras"][0]["exact"])
            data = re.findall(rb"data: \[ (.*) \]", read(self.path("out.yaml")))
            fx, _, cx, _, fy, cy, *_ = map(float, data[0].split(b","))
            self.assertAlmostEqual(fx, 100 / math.tan(math.pi / 6), 3)
            self.assertEqual((fx, cx, cy), (fy, 99.5, 74.5))
            self.assertEqual(set(data[1].split(b", ")), {b"0.0"})

    def test_files_that_python_writes_are_cameras(self):
        """Archives of numpy, with what calibrateCamera returns beside the lens."""
        code = ("import sys, numpy as np\n"
                "np.savez(sys.argv[1], ret=0.5, mtx=np.array([[150, 0, 80.25], [0, 151, 59.5], "
                "[0, 0, 1]]), dist=np.array([[-0.25, 0.08, 1e-3, -2e-3, -0.01]]), "
                "rvecs=np.zeros((40, 3, 1)), tvecs=np.zeros((40, 3, 1)), names=['a', 'b'])")
        python = next((python for python in PYTHONS if subprocess.run(
            [python, "-c", code, self.path("camera.npz")], capture_output=True,
            check=False).returncode == 0), None)
        if not python:
            self.skipTest("no Python has numpy; 'tools/install_packages tests' installs it")
        size = ("--image-size", "160x120")
        self.succeed("import", self.path("camera.npz"), *size, "-o",
                     self.path("numpy.yaml"))
        self.succeed("import", write(self.path("same.yml"), OPENCV_FILE), "-o",
                     self.path("same.yaml"))
        self.assertEqual(read(self.path("numpy.yaml")), read(self.path("same.yaml")))

    def test_a_pair_is_a_rig_of_two_files(self):
        matrix = lambda key, rows, data: (f"{key}: !!opencv-matrix\n   rows: {rows}\n   cols: "
                                          f"{data.count(',') // rows + 1}\n   dt: d\n"
                                          f"   data: [ {data} ]\n")
        lens = "150., 0., 80.25, 0., 151., 59.5, 0., 0., 1."
        cameras = write(self.path("intrinsics.yml"), "%YAML:1.0\n---\n" + "".join(
            matrix(f"M{k}", 3, lens) + matrix(f"D{k}", 1, "-0.25, 0.08, 1e-3, -2e-3, -0.01")
            for k in (1, 2)))
        pose = write(self.path("extrinsics.yml"), "%YAML:1.0\n---\n" +
                     matrix("R", 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.") +
                     matrix("T", 3, "-0.12, 0., 0."))
        for files in ((cameras, pose), (pose, cameras)):
            self.succeed("import", *files, "--image-size", "160x120", "-o",
                         self.path("pair/rig.yaml"))
            self.assertIn("x: -0.12", read(self.path("pair/rig.yaml")).decode())
        self.assert_refused(run("import", pose, "-o", self.path("never/x.yaml")), 2,
                            "extrinsics.yml", "R and T")
        self.assert_refused(run("inspect", pose), 2, "extrinsics.yml", "R and T")

    def test_options_do_not_replace_what_files_say(self):
        file = write(self.path("said.yml"), OPENCV_FILE + "fisheye_model: 0\n")
        for option, value, words in (("--image-size", "80x60", ("80x60", "160x120", "scale=0.5")),
                                     ("--model", "fisheye", ("--model fisheye",
                                                             "fisheye_model"))):
            self.assert_refused(run("import", file, option, value, "-o", self.path("never/x.yaml")),
                                2, "said.yml", *words)
        self.assert_nothing_in(self.path("never"))

    def test_commands_name_the_formats_that_they_tried(self):
        text = write(self.path("no_camera.txt"), "hello: 1\n")
        for arguments in (("pack", text, "-o", self.path("never/x.raygrid")),
                          ("undistort", text, text, "-o", self.path("never")),
                          ("export", text, "--to", "ros", "-o", self.path("never/x.yaml")),
                          ("compare", text, self.camera),
                          ("inspect", text)):
            with self.subTest(arguments[0]):
                self.assert_refused(run(*arguments), 2, "no_camera.txt", "opencv", "gyroflow",
                                    "orbslam")

    def test_lists_what_there_is(self):
        result = self.succeed("export", "--list")
        formats = json.loads(run("export", "--list", "--json").stdout)
        for entry in formats:
            self.assertIn(entry["name"] + ": " + entry["description"], result.stdout)
            for model in entry.get("models", ()):
                self.assertIn(model, result.stdout)

    def test_what_cannot_be(self):
        export = ("export", self.camera, "--to", "opencv", "-o", self.path("never/o.yaml"))
        for arguments, code, words in (
                (("export",), 1, ("camera is required",)),
                (("export", self.camera), 1, ("--to is required",)),
                (("export", self.camera, "--to", "opencv"), 1, ("-o is required",)),
                ((*export, "--model", "none"), 1, ("--model none", "opencv5")),
                ((*export, "--hfov", 60), 1, ("--hfov", "--rectified")),
                ((*export, "--max-fit-error-px", -1), 1, ("--max-fit-error-px",)),
                (("export", self.camera, "--to", "none", "-o", "x"), 1, ("--to none", "opencv")),
                (("import", self.camera, "-o", "x.yaml"), 2, ("already a raygrid file",)),
                (("import", write(self.path("a.txt"), "hello\n"), "-o", "x.yaml"), 2,
                 ("a.txt", "supported format")),
                (("import", write(self.path("b.yaml"), OPENCV_FILE), "--from", "none", "-o", "x"),
                 1, ("--from none",)),
                (("import", write(self.path("b.yaml"), OPENCV_FILE), "--model", "none", "-o",
                  "x.yaml"), 2, ("'none'",))):
            with self.subTest(arguments):
                self.assert_refused(run(*arguments), code, *words)
        self.assert_nothing_in(self.path("never"))

    def test_outputs_replace_no_input(self):
        own = write(self.path("own.yaml"), OPENCV_FILE)
        for arguments in (("import", own, "-o", own), ("export", own, "--to", "opencv", "-o", own)):
            self.assert_refused(run(*arguments), 7, "overwrite the input")
        self.assertEqual(read(own).decode(), OPENCV_FILE)

    def test_names_come_through(self):
        name = 'le"ft & <b> \\ \u00e9'
        text = read(self.camera).decode()
        text = re.sub("^name: .*\n", "", text, flags=re.MULTILINE)
        camera = write(self.path("source.yaml"), f"name: {json.dumps(name)}\n" + text)
        for ending in ("yaml", "xml", "json"):
            self.export(camera, "--to", "opencv", "--model", "opencv4", out="named." + ending)
            told = json.loads(run("inspect", self.path("named." + ending), "--json").stdout)
            self.assertEqual(told["camera"]["name"], name)


if __name__ == "__main__":
    main(__name__)
