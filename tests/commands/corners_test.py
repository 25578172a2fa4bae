#!/usr/bin/env python3
"""Import of other programs' corners and targets: what calibrates here is what they found."""
import json
import math
import os
import re
import subprocess
import sys
import unittest

from command_test import CommandTest, main, read, run, write

OPENCV = next((python for python in (sys.executable, "/usr/bin/python3") if subprocess.run(
    [python, "-c", "import cv2"], capture_output=True, check=False).returncode == 0), None)
NO_OPENCV = "no Python has cv2; 'tools/install_packages tests' installs it"

COLUMNS, ROWS, SQUARE_M = 9, 6, 0.03


class CornersTest(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        result = run("simulate", "--images", 5, "--lens", "wide", "--features-per-image", 40,
                     "--pattern", f"chessboard:{COLUMNS}x{ROWS}:{SQUARE_M * 1000:g}mm", "-o",
                     cls.path("sim"))
        assert result.returncode == 0, result.stderr
        cls.features = cls.path("sim/features.csv")
        cls.images = {}
        for line in read(cls.features).decode().splitlines()[1:]:
            image, _, column, row, x, y = line.split(",")
            cls.images.setdefault(image, {})[int(column), int(row)] = float(x), float(y)
        cls.poses = {line.split(",")[0]: [float(word) for word in line.split(",")[2:]]
                     for line in read(cls.path("sim/true_poses.csv")).decode().splitlines()[1:]}

    def rows(self, name):
        """Of a file of features or poses: its header's names without the first two, and a
        dictionary of numbers."""
        lines = [line.split(",") for line in read(self.path(name)).decode().splitlines()]
        return {(line[0], *map(int, line[1:4])): tuple(map(float, line[4:])) if
                "x" in lines[0] else tuple(map(float, line[2:])) for line in lines[1:]}

    def seen(self):
        return {(image, 0, *place): pixel for image, corners in self.images.items()
                for place, pixel in corners.items()}


class PhotonVision(CornersTest):
    """The JSON that PhotonVision's page exports, key by key; it cannot be asked here."""

    LENS = {"rows": 1, "cols": 8, "type": 6,
            "data": [-0.125, 0.0625, 0.001, -0.002, -0.01, 0.02, 0.03, 0.004]}
    MATRIX = {"rows": 3, "cols": 3, "type": 6, "data": [400.5, 0, 319.25, 0, 401.5, 239.75, 0, 0, 1]}

    def observation(self, image, first=0):
        """What was seen of one board: corners that were not found are at (-1, -1)."""
        places, pixels, used = [], [], []
        for row in range(ROWS):
            for column in range(COLUMNS):
                x, y = self.images[image].get((column, row), (-1.0, -1.0))
                pixels.append({"x": x, "y": y})
                places.append({"x": (column + first) * SQUARE_M, "y": (row + first) * SQUARE_M,
                               "z": 0.0})
                used.append(x >= 0)
        qw, qx, qy, qz, *translation = self.poses[image]
        return {"locationInObjectSpace": places, "locationInImageSpace": pixels,
                "reprojectionErrors": [{"x": 0.0, "y": 0.0}] * len(pixels),
                "optimisedCameraToObject": {
                    "translation": dict(zip("xyz", translation)),
                    "rotation": {"quaternion": {"W": qw, "X": qx, "Y": qy, "Z": qz}}},
                "cornersUsed": used, "snapshotName": image,
                "snapshotData": {"rows": 1, "cols": 1, "type": 0, "data": "iVBORw0KGgo="}}

    def calibration(self, first=0):
        return json.loads(json.dumps({
            "resolution": {"width": 640.0, "height": 480.0}, "cameraIntrinsics": self.MATRIX,
            "distCoeffs": self.LENS, "calobjectWarp": [0.0001, -0.0002],
            "observations": [self.observation(image, first) for image in self.images],
            "calobjectSize": {"width": float(COLUMNS), "height": float(ROWS)},
            "calobjectSpacing": SQUARE_M, "lensmodel": "LENSMODEL_OPENCV"}))

    def imported(self, calibration, out):
        file = write(self.path("photon.json"), json.dumps(calibration))
        result = run("import", file, "-o", self.path(out))
        self.assert_done(result)
        return result

    def test_corners_and_poses_are_those_that_were_seen(self):
        """All digits of them; half a pixel is seen."""
        result = self.imported(self.calibration(), "features.csv")
        self.assertIn("features.csv: 200 features in 5 images\n", result.stdout)
        self.assertEqual(self.rows("features.csv"), self.seen())
        self.imported(self.calibration(), "poses.csv")
        for line, pose in zip(read(self.path("poses.csv")).decode().splitlines()[1:],
                              self.poses.values()):
            self.assertLess(math.dist(map(float, line.split(",")[2:]), pose), 1e-8)
        moved = self.calibration()
        for point in moved["observations"][0]["locationInImageSpace"]:
            point["x"] += 0.5
        self.imported(moved, "features.csv")
        self.assertNotEqual(self.rows("features.csv"), self.seen())

    def test_corners_that_the_solver_left_out_are_left_out(self):
        calibration = self.calibration()
        first = next(k for k, used in enumerate(calibration["observations"][0]["cornersUsed"]) if used)
        calibration["observations"][0]["cornersUsed"][first] = False
        calibration["observations"][1]["includeObservationInCalibration"] = False
        result = self.imported(calibration, "features.csv")
        self.assertIn("1 corner that its solver left out", result.stderr)
        self.assertIn("1 image that its solver left out", result.stderr)
        names = list(self.images)
        seen = {key: pixel for key, pixel in self.seen().items() if key[0] != names[1]}
        del seen[names[0], 0, first % COLUMNS, first // COLUMNS]
        self.assertEqual(self.rows("features.csv"), seen)

    def test_charuco_boards_begin_a_square_from_their_origin(self):
        result = self.imported(self.calibration(first=1), "features.csv")
        self.assertEqual(self.rows("features.csv"), self.seen())
        self.assertIn("poses are not taken", result.stderr)

    def test_older_files_have_other_names(self):
        calibration = self.calibration()
        calibration["cameraExtrinsics"] = {**calibration.pop("distCoeffs"), "cols": 5}
        calibration["cameraExtrinsics"]["data"] = self.LENS["data"][:5]
        for key in ("calobjectWarp", "calobjectSize", "calobjectSpacing", "lensmodel"):
            del calibration[key]
        for observation in calibration["observations"]:
            del observation["cornersUsed"]
        self.imported(calibration, "features.csv")
        self.assertEqual(self.rows("features.csv"), self.seen())
        self.imported(calibration, "camera.yaml")
        self.assertIn(b"k3: -0.01\n", read(self.path("camera.yaml")))

    @unittest.skipUnless(OPENCV, NO_OPENCV)
    def test_opencv_sees_what_raygrid_does(self):
        """10,000 rays, with the numbers as PhotonVision hands them to OpenCV; half a pixel is
        seen."""
        self.imported(self.calibration(), "camera.yaml")
        points = [((x - 50) / 60, (y - 50) / 80, 1) for x in range(100) for y in range(101)]
        text = "x,y,z\n" + "".join(",".join(map(repr, point)) + "\n" for point in points)
        result = run("project", self.path("camera.yaml"), "--points",
                     write(self.path("points.csv"), text), "--json")
        self.assert_done(result)
        ours = [(row["u"], row["v"]) for row in json.loads(result.stdout)]
        self.assert_done(run("export", self.path("camera.yaml"), "--to", "photonvision", "-o",
                             self.path("again.json")))
        again = json.loads(read(self.path("again.json")))
        for key in ("resolution", "cameraIntrinsics", "distCoeffs", "lensmodel"):
            self.assertEqual(again[key], self.calibration()[key])
        peer = """
import json, sys
import cv2, numpy as np
camera = json.load(open(sys.argv[1]))
matrix, lens = (np.array(camera[key]["data"], float).reshape(camera[key]["rows"], -1)
                for key in ("cameraIntrinsics", "distCoeffs"))
points = np.array(json.load(sys.stdin), float)
print(json.dumps(cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix, lens)[0].tolist()))
"""
        done = subprocess.run([OPENCV, "-c", peer, self.path("again.json")], text=True,
                              input=json.dumps(points), capture_output=True, check=False)
        self.assert_done(done)
        off = [math.dist(a, b[0]) for a, b in zip(ours, json.loads(done.stdout)) if a[0]]
        self.assertGreater(len(off), 9900)
        self.assertLess(max(off), 1e-6)
        shifted = [math.dist((a[0] + 0.5, a[1]), b[0]) for a, b in
                   zip(ours, json.loads(done.stdout)) if a[0]]
        self.assertGreater(min(shifted), 0.49)

    def test_what_cannot_be(self):
        def refused(change, *words, out="features.csv"):
            calibration = self.calibration()
            change(calibration)
            file = write(self.path("bad.json"), json.dumps(calibration))
            with self.subTest(words):
                self.assert_refused(run("import", file, "-o", self.path("never/" + out)), 2,
                                    "bad.json: ", *words)
        view = lambda calibration: calibration["observations"][2]
        refused(lambda c: view(c)["locationInImageSpace"].pop(), "observations[2]", "54", "53")
        refused(lambda c: view(c)["locationInImageSpace"][7].update(x="4"), "observations[2]",
                "locationInImageSpace: x", "number")
        refused(lambda c: c.update(calobjectSpacing=0.031), "calobjectSpacing 0.031")
        refused(lambda c: c.update(calobjectSpacing=1e-9), "calobjectSpacing 1e-09")
        refused(lambda c: view(c).update(locationInObjectSpace=[{"x": 0, "y": 0}] * 54), "twice")
        refused(lambda c: c.update(observations=[]), "no features")
        refused(lambda c: c.update(observations=5), "observations: no list")
        refused(lambda c: c.update(lensmodel="LENSMODEL_SPLINED_STERIOGRAPHIC"), "lensmodel")
        refused(lambda c: c["distCoeffs"].update(data=[0] * 6), "6 distortion coefficients")
        refused(lambda c: c["cameraIntrinsics"]["data"].__setitem__(1, 2), "cameraIntrinsics")
        refused(lambda c: c["resolution"].pop("width"), "resolution.width")
        refused(lambda c: c.pop("distCoeffs"), "'distCoeffs' is missing")
        text = json.dumps(self.calibration())
        for name, contents, words in (("cut.json", text[:-9], "no JSON at byte"),
                                      ("nan.json", text.replace("400.5", "NaN"), "no JSON")):
            self.assert_refused(run("import", write(self.path(name), contents), "-o",
                                    self.path("never/camera.yaml")), 2, name + ": ", words)
        self.assert_nothing_in(self.path("never"))


@unittest.skipUnless(OPENCV, NO_OPENCV)
class OpenCvCorners(CornersTest):
    """Lists of corners that cv2.FileStorage wrote, without a camera."""

    # Arrays of (images, corners, 2), and of lists as findChessboardCorners returns them.
    PEER = """
import json, sys
import cv2, numpy as np
points = np.array(json.load(sys.stdin), np.float32)
for path, array in ((sys.argv[1], points), (sys.argv[2], points[:, :, None])):
    storage = cv2.FileStorage(path, cv2.FILE_STORAGE_WRITE)
    for key, number in (("board_width", 3), ("board_height", 4), ("square_size", 25.0)):
        storage.write(key, number)
    storage.write("image_points", array)
    storage.release()
"""

    @classmethod
    def setUpClass(cls):
        CommandTest.setUpClass.__func__(cls)

    def refused(self, file, *words, code=2, more=(), out="never/features.csv"):
        with self.subTest(words):
            self.assert_refused(run("import", file, *more, "-o", self.path(out)), code, *words)

    def test_corners_are_those_that_were_seen(self):
        """Another board, or none, is refused."""
        pixels = [[(40.25 * (k % 3) + 7 * image, 30.5 * (k // 3) + k / 8) for k in range(12)]
                  for image in range(2)]
        files = [self.path(name) for name in ("lists.yml", "lists.json")]
        done = subprocess.run([OPENCV, "-c", self.PEER, *files], text=True, capture_output=True,
                              input=json.dumps(pixels), check=False)
        self.assert_done(done)
        expected = {(f"view000{image}", 0, k % 3, k // 3): pixel for image in range(2)
                    for k, pixel in enumerate(pixels[image])}
        for file in files:
            result = run("import", file, "-o", self.path("features.csv"))
            self.assert_done(result)
            self.assertIn("24 features in 2 images", result.stdout)
            self.assertEqual(self.rows("features.csv"), expected)
        text = read(files[0]).decode()
        without = write(self.path("w.yml"), re.sub("board_.*\n", "", text))
        self.refused(without, "w.yml: image_points", "--board")
        self.assert_done(run("import", without, "--board", "3x4", "-o", self.path("f.csv")))
        self.assertEqual(self.rows("f.csv"), expected)
        self.refused(files[0], "--board", "3 x 4", more=("--board", "4x3"))
        self.refused(files[0], "c.yaml", "features.csv", code=1, out="never/c.yaml")
        self.assert_refused(run("inspect", files[0]), 2, "raygrid import", "features.csv")
        self.assert_nothing_in(self.path("never"))


class KalibrTargets(CornersTest):
    """Targets as Kalibr's wiki shows them."""

    APRILGRID = """target_type: 'aprilgrid' #gridtype
tagCols: 6               #number of apriltags
tagRows: 5               #number of apriltags
tagSize: 0.021           #size of apriltag, edge to edge [m]
tagSpacing: 0.25         #ratio of space between tags to tagSize
"""
    CHECKERBOARD = """target_type: 'checkerboard' #gridtype
targetCols: 6               #number of internal chessboard corners
targetRows: 7               #number of internal chessboard corners
rowSpacingMeters: 0.06      #size of one chessboard square [m]
colSpacingMeters: 0.06      #size of one chessboard square [m]
"""

    def imported(self, text):
        result = run("import", write(self.path("target.yaml"), text), "-o",
                     self.path("pattern.yaml"))
        self.assert_done(result)
        return result.stdout, read(self.path("pattern.yaml")).decode()

    def test_an_aprilgrid_is_the_board_that_is_printed(self):
        """Which raygrid prints as Kalibr draws it. Another ratio is seen."""
        self.assert_done(run("pattern", "aprilgrid", "--tag-columns", 6, "--tag-rows", 5, "--tag-mm",
                             21, "--spacing-ratio", 0.25, "-o", self.path("printed")))
        printed = re.search("  - {id.*", read(self.path("printed/pattern.yaml")).decode())[0]
        told, pattern = self.imported(self.APRILGRID)
        self.assertIn("aprilgrid with 12 x 10 features", told)
        self.assertEqual(re.search("  - {id.*", pattern)[0], printed)
        self.assertNotIn(printed, self.imported(self.APRILGRID.replace("0.25", "0.3"))[1])

    def test_a_checkerboard_has_its_inner_corners(self):
        _, pattern = self.imported(self.CHECKERBOARD)
        self.assertIn("kind: chessboard, columns: 6, rows: 7, square_m: 0.06}", pattern)
        _, pattern = self.imported(self.CHECKERBOARD.replace("colSpacingMeters: 0.06",
                                                             "colSpacingMeters: 0.061"))
        points = re.findall(r"      - \[(\S+), (\S+), 0.0+\]", pattern)
        self.assertEqual(points, [(f"{0.061 * k:.9f}", f"{0.06 * j:.9f}") for j in range(7)
                                  for k in range(6)])

    def test_what_cannot_be(self):
        for text, words in ((self.APRILGRID.replace("aprilgrid", "circlegrid"), ("circlegrid",)),
                            (self.APRILGRID.replace("tagCols: 6", "tagCols: 6.5"), ("tagCols",)),
                            (self.APRILGRID.replace("tagCols: 6", "tagCols: 600"), ("tagCols",)),
                            (self.APRILGRID.replace("tagCols: 6", "tagCols: 200"), ("0 to 586",)),
                            (self.APRILGRID.replace("0.021", ".nan"), ("tagSize",)),
                            (self.APRILGRID.replace("tagRows", "rows"), ("tagRows",)),
                            (self.CHECKERBOARD.replace("0.06", "-1"), ("Spacing",)),
                            (self.CHECKERBOARD.replace("targetRows: 7", "targetRows: 1"),
                             ("2 to 1000",))):
            with self.subTest(words):
                self.assert_refused(run("import", write(self.path("t.yaml"), text), "-o",
                                        self.path("never/p.yaml")), 2, "t.yaml", *words)
        target = write(self.path("t.yaml"), self.APRILGRID)
        never = self.path("never/p.yaml")
        for arguments, code, words in ((("-o", never, "--board", "6x6"), 1, ("--board",)),
                                       (("-o", never, "--model", "opencv"), 1, ("--model",)),
                                       ((target, "-o", never), 1, ("alone",)),
                                       (("-o", self.path("never/f.csv")), 1, ("pattern.yaml",)),
                                       (("-o", target), 7, ("replace the input",))):
            self.assert_refused(run("import", target, *arguments), code, *words)
        for command in (("inspect", target), ("pack", target, "-o", never)):
            self.assert_refused(run(*command), 2, "raygrid import", "pattern.yaml")
        self.assert_nothing_in(self.path("never"))


if __name__ == "__main__":
    main(__name__)
