#!/usr/bin/env python3
"""Import of other programs' corners and targets: what calibrates here is what they found."""
import csv
import json
import math
import re
import struct
import subprocess
import unittest

from command_test import CommandTest, NO_OPENCV, main, python_with, read, run, write

OPENCV = python_with("cv2")

COLUMNS, ROWS, SQUARE_M = 9, 6, 0.03


class CornersTest(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.succeed("simulate", "--images", 5, "--lens", "wide", "--features-per-image", 40,
                    "--pattern", f"chessboard:{COLUMNS}x{ROWS}:{SQUARE_M * 1000:g}mm", "-o",
                    cls.path("sim"))
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
        result = self.succeed("import", file, "-o", self.path(out))
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
        self.assertIn("ignored 1 corner", result.stderr)
        self.assertIn("ignored 1 image", result.stderr)
        names = list(self.images)
        seen = {key: pixel for key, pixel in self.seen().items() if key[0] != names[1]}
        del seen[names[0], 0, first % COLUMNS, first // COLUMNS]
        self.assertEqual(self.rows("features.csv"), seen)

    def test_charuco_boards_begin_a_square_from_their_origin(self):
        result = self.imported(self.calibration(first=1), "features.csv")
        self.assertEqual(self.rows("features.csv"), self.seen())
        self.assertIn("poses are ignored", result.stderr)

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
        result = self.succeed("project", self.path("camera.yaml"), "--points",
                              write(self.path("points.csv"), text), "--json")
        ours = [(row["u"], row["v"]) for row in json.loads(result.stdout)]
        self.succeed("export", self.path("camera.yaml"), "--to", "photonvision", "-o",
                     self.path("again.json"))
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
        refused(lambda c: view(c).update(locationInObjectSpace=[{"x": 0, "y": 0}] * 54), "duplicate")
        refused(lambda c: c.update(observations=[]), "no features")
        refused(lambda c: c.update(observations=5), "observations: expected a list")
        refused(lambda c: c.update(lensmodel="LENSMODEL_SPLINED_STERIOGRAPHIC"), "lensmodel")
        refused(lambda c: c["distCoeffs"].update(data=[0] * 6), "6 distortion coefficients")
        refused(lambda c: c["cameraIntrinsics"]["data"].__setitem__(3, 2), "cameraIntrinsics")
        refused(lambda c: c["resolution"].pop("width"), "resolution.width")
        refused(lambda c: c.pop("distCoeffs"), "'distCoeffs' is missing")
        text = json.dumps(self.calibration())
        for name, contents, words in (("cut.json", text[:-9], "invalid JSON at byte"),
                                      ("nan.json", text.replace("400.5", "NaN"), "invalid JSON")):
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
            result = self.succeed("import", file, "-o", self.path("features.csv"))
            self.assertIn("24 features in 2 images", result.stdout)
            self.assertEqual(self.rows("features.csv"), expected)
        text = read(files[0]).decode()
        without = write(self.path("w.yml"), re.sub("board_.*\n", "", text))
        self.refused(without, "w.yml: image_points", "--board-size")
        self.succeed("import", without, "--board-size", "3x4", "-o", self.path("f.csv"))
        self.assertEqual(self.rows("f.csv"), expected)
        self.refused(files[0], "--board-size", "3 x 4", more=("--board-size", "4x3"))
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
        result = self.succeed("import", write(self.path("target.yaml"), text), "-o",
                              self.path("pattern.yaml"))
        return result.stdout, read(self.path("pattern.yaml")).decode()

    def test_an_aprilgrid_is_the_board_that_is_printed(self):
        """Which raygrid prints as Kalibr draws it. Another ratio is seen."""
        self.succeed("pattern", "aprilgrid", "--tag-columns", 6, "--tag-rows", 5, "--tag-mm",
                     21, "--spacing-ratio", 0.25, "-o", self.path("printed"))
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
        for arguments, code, words in ((("-o", never, "--board-size", "6x6"), 1, ("--board-size",)),
                                       (("-o", never, "--model", "opencv"), 1, ("--model",)),
                                       ((target, "-o", never), 1, ("separately",)),
                                       (("-o", self.path("never/f.csv")), 1, ("pattern.yaml",)),
                                       (("-o", target), 7, ("overwrite the input",))):
            self.assert_refused(run("import", target, *arguments), code, *words)
        for command in (("inspect", target), ("pack", target, "-o", never)):
            self.assert_refused(run(*command), 2, "raygrid import", "pattern.yaml")
        self.assert_nothing_in(self.path("never"))


class PuzzlepaintPatterns(CornersTest):
    """The file of the authors' printed pattern, whose stars are those that raygrid draws."""

    FILE = """num_star_segments: 16
squares_x: 17
squares_y: 24
square_length_in_meters: 0.011
page:
    width_mm: 210.0
    height_mm: 297.0
apriltags:
  - tag_x: 6
    tag_y: 10
    width: 4
    height: 4
    index: 3
"""

    @classmethod
    def setUpClass(cls):
        CommandTest.setUpClass.__func__(cls)

    def test_a_pattern_is_the_board_that_is_printed(self):
        """Another tag is seen."""
        self.succeed("pattern", "star", "--columns", 16, "--rows", 23, "--square-mm", 11,
                     "--tag-id", 3, "--tag-squares", 4, "-o", self.path("printed"))
        printed = re.search("  - {id.*", read(self.path("printed/pattern.yaml")).decode())[0]
        for text, is_same in ((self.FILE, True), (self.FILE.replace("tag_x: 6", "tag_x: 7"), False)):
            self.succeed("import", write(self.path("p.yaml"), text), "-o",
                         self.path("pattern.yaml"))
            own = re.search("  - {id.*", read(self.path("pattern.yaml")).decode())[0]
            self.assertEqual(own == printed, is_same, own)

    def test_what_cannot_be(self):
        for old, new, *words in (
                ("squares_x: 17", "squares_x: 2", "squares_x: must be 3 to 1001"),
                ("squares_x: 17", "squares: 17", "squares_x"),
                ("segments: 16", "segments: 15", "segments"),
                ("0.011", ".nan", "square_length_in_meters"),
                ("0.011", "-1", "square_m is -1"),
                ("width: 4", "width: 5", "apriltags[0]", "must be equal"),
                ("tag_y: 10", "tag_y: 22", "outside the board"),
                ("index: 3", "index: 587", "apriltags[0]: index: must be 0 to 586"),
                ("apriltags:", "tags:", "apriltags: must list")):
            with self.subTest(new):
                file = write(self.path("t.yaml"), self.FILE.replace(old, new))
                self.assert_refused(run("import", file, "-o", self.path("never/p.yaml")), 2,
                                    "t.yaml", *words)
        self.assert_nothing_in(self.path("never"))


class PuzzlepaintDatasets(CornersTest):
    """The authors' dataset.bin, packed and unpacked here as their program has it: integers are
    big-endian, floats little-endian, and pixels begin at the image's corner."""

    # A tag stands on features 1 and 2 of rows 1 and 2.
    STAR = """raygrid_pattern: 1
boards:
  - {id: 0, kind: star, columns: 5, rows: 4, square_m: 0.0125, segments: 16, tags: [{id: 0, column: 1, row: 1, squares: 1}]}
  - {id: 1, kind: chessboard, columns: 3, rows: 2, square_m: 0.03125}
"""
    PLACES = [(0, column, row) for row in range(4) for column in range(5)
              if not (1 <= column <= 2 and 1 <= row <= 2)] + [
                  (1, column, row) for row in range(2) for column in range(3)]

    @staticmethod
    def packed(sizes, imagesets, geometries):
        """imagesets: names, and lists of (x, y, id) for each camera; geometries: cells, and lists
        of (id, column, row)."""
        data = b"calib_data" + struct.pack(">II", 0, len(sizes))
        data += b"".join(struct.pack(">II", *size) for size in sizes)
        data += struct.pack(">I", len(imagesets))
        for name, cameras in imagesets:
            data += struct.pack(">I", len(name)) + name.encode()
            for features in cameras:
                data += struct.pack(">I", len(features))
                for x, y, number in features:
                    data += struct.pack("<ff", x, y) + struct.pack(">i", number)
        data += struct.pack(">I", len(geometries))
        for cell, places in geometries:
            data += struct.pack("<f", cell) + struct.pack(">I", len(places))
            data += b"".join(struct.pack(">iii", *place) for place in places)
        return data

    @staticmethod
    def unpacked(data):
        """The arguments of packed()."""
        at = 0

        def take(layout):
            nonlocal at
            values = struct.unpack_from(layout, data, at)
            at += struct.calcsize(layout)
            return values if len(values) > 1 else values[0]
        assert (take("10s"), take(">I")) == (b"calib_data", 0)
        sizes = [take(">II") for _ in range(take(">I"))]
        imagesets = []
        for _ in range(take(">I")):
            name = take(f"{take('>I')}s").decode()
            imagesets.append((name, [[(*take("<ff"), take(">i")) for _ in range(take(">I"))]
                                     for _ in sizes]))
        geometries = [(take("<f"), [take(">iii") for _ in range(take(">I"))])
                      for _ in range(take(">I"))]
        assert at == len(data)
        return sizes, imagesets, geometries

    def dataset(self, shift=0.0):
        """Two cameras, three images, of which the second camera misses one, and two boards."""
        geometries = [(cell, [(number, column, row) for number, (own, column, row) in
                              enumerate(self.PLACES) if own == board])
                      for board, cell in enumerate((0.0125, 0.03125))]
        seen = lambda k: [(5.25 * (number + k) + 0.125 + shift, 3.5 * number + k, number)
                          for number in range(k, len(self.PLACES), 2)]
        return ([(320, 240), (640, 480)],
                [("a.png", [seen(0), seen(1)]), ('b "2".png', [seen(1), []]),
                 ("c.png", [seen(2), seen(3)])], geometries)

    def written(self, dataset, name="dataset.bin"):
        return write(self.path(name), self.packed(*dataset))

    def imported(self, file, out):
        result = self.succeed("import", file, "-o", self.path(out))
        return result.stdout

    def rows_of_rig(self, name):
        """Camera, image, board, column and row, and the pixel."""
        with open(self.path(name), encoding="utf-8", newline="") as file:
            return {(row[0], row[1], *map(int, row[2:5])): tuple(map(float, row[5:]))
                    for row in list(csv.reader(file))[1:]}

    def expected(self):
        return {(f"intrinsics{camera}", name, *self.PLACES[number]): (x - 0.5, y - 0.5)
                for name, cameras in self.dataset()[1] for camera, features in enumerate(cameras)
                for x, y, number in features}

    def test_features_are_those_that_were_packed(self):
        """Half a pixel is seen."""
        told = self.imported(self.written(self.dataset()), "features.csv")
        self.assertIn("2 boards; intrinsics0: 32 features in 3 images of 320x240 px; "
                      "intrinsics1: 21 features in 2 images of 640x480 px", told)
        self.assertEqual(self.rows_of_rig("features.csv"), self.expected())
        self.imported(self.written(self.dataset(shift=0.5)), "shifted.csv")
        self.assertNotEqual(self.rows_of_rig("shifted.csv"), self.expected())

    def test_export_after_import_is_the_file(self):
        """To the bit, with the boards that were detected with; and nearly, with those of the
        file."""
        dataset = self.written(self.dataset())
        self.imported(dataset, "rig_features.csv")
        self.imported(dataset, "pattern.yaml")
        sizes = ("--image-size", "320x240", "--image-size", "intrinsics1=640x480")
        for pattern in (write(self.path("star.yaml"), self.STAR), self.path("pattern.yaml")):
            result = self.succeed("export", self.path("rig_features.csv"), "--to", "puzzlepaint-dataset",
                                  "--pattern", pattern, *sizes, "-o", self.path("again.bin"))
            self.assertIn("53 features in 3 imagesets; cameras in this order: intrinsics0, "
                          "intrinsics1", result.stdout)
            if pattern.endswith("star.yaml"):
                self.assertEqual(read(self.path("again.bin")), read(dataset))
            self.imported(self.path("again.bin"), "again_features.csv")
            self.assertEqual(self.rows_of_rig("again_features.csv"), self.expected())

    def test_what_was_simulated_goes_out_and_in(self):
        """The boards of the file calibrate as well as that which was simulated."""
        board = f"chessboard:{COLUMNS}x{ROWS}:{SQUARE_M * 1000:g}mm"
        self.succeed("export", self.features, "--to", "puzzlepaint-dataset", "--pattern",
                     board, "--image-size", "640x480", "-o", self.path("one.bin"))
        sizes, imagesets, ((cell, places),) = self.unpacked(read(self.path("one.bin")))
        self.assertEqual((sizes, [name for name, _ in imagesets]),
                         ([(640, 480)], list(self.images)))
        self.assertAlmostEqual(cell, SQUARE_M, 8)
        self.assertEqual(places, [(k, k % COLUMNS, k // COLUMNS) for k in range(COLUMNS * ROWS)])
        for name, (features,) in imagesets:
            seen = {(number % COLUMNS, number // COLUMNS): (x, y) for x, y, number in features}
            self.assertEqual(seen.keys(), self.images[name].keys())
            for place, (x, y) in self.images[name].items():
                self.assertLess(math.dist(seen[place], (x + 0.5, y + 0.5)), 4e-5)
        self.imported(self.path("one.bin"), "one_features.csv")
        rows = self.rows("one_features.csv")
        self.assertEqual(rows.keys(), self.seen().keys())
        self.assertLess(max(math.dist(rows[key], pixel) for key, pixel in self.seen().items()),
                        5e-5)
        self.imported(self.path("one.bin"), "one.yaml")
        figures = []
        for pattern in (board, self.path("one.yaml")):
            result = run("calibrate", "--features", self.features, "--pattern", pattern,
                         "--image-size", "640x480", "--model", "opencv", "--skip-comparison",
                         "--json", "-o", self.path("result"))
            self.assertIn(result.returncode, (0, 6), result.stderr)
            figures.append(json.loads(read(self.path("result/result.json")))["training"])
        self.assertEqual(*figures)

    def test_what_cannot_be(self):
        never = self.path("never/features.csv")
        good = self.packed(*self.dataset())

        def refused(data, *words, out=never, code=2, more=()):
            with self.subTest(words):
                self.assert_refused(run("import", write(self.path("bad.bin"), data), *more, "-o",
                                        out), code, "bad.bin", *words)

        def changed(change):
            sizes, imagesets, geometries = self.dataset()
            change(sizes, imagesets, geometries)
            return self.packed(sizes, imagesets, geometries)
        first = lambda x, y, number: changed(
            lambda _, imagesets, __: imagesets[0][1][0].__setitem__(0, (x, y, number)))
        place = lambda *values: changed(
            lambda _, __, geometries: geometries[1][1].__setitem__(0, values))
        refused(good[:-1], "truncated after")
        refused(good[:200], "truncated after 200 bytes")
        refused(good[:12], "truncated after 12 bytes")
        refused(good + b"x", "1 byte after its end")
        refused(good[:10] + b"\0\0\0\3" + good[14:], "version 3")
        refused(good[:14] + b"\xff" * 4 + good[18:], "truncated after")
        refused(good[:34] + b"\xff" * 4 + good[38:], "truncated after")
        refused(good[:38] + b"\x7f" + good[39:], "truncated after")
        refused(changed(lambda sizes, _, __: sizes.__setitem__(0, (0, 240))), "0 x 240")
        refused(changed(lambda _, imagesets, geometries: geometries.clear()), "feature 0",
                "known_geometries")
        refused(first(math.nan, 3, 0), "expected a finite number")
        refused(first(320.5, 3, 0), "feature 0 at (320.5, 3)", "320 x 240")
        refused(first(-1, 3, 0), "outside")
        refused(first(5, 3, 99), "imageset 0, camera 0: feature 99", "known_geometries")
        refused(first(5, 3, -1), "feature -1")
        refused(first(5, 3, 2), "feature 2 is a duplicate")
        refused(place(16, -1, 0), "feature 16: column -1")
        refused(place(16, 0, 1000), "0 to 999")
        refused(place(-16, 0, 0), "feature -16")
        refused(place(0, 0, 0), "feature 0 is on two boards")
        refused(place(16, 1, 0), "board 1: duplicate feature at column 1, row 0")
        refused(changed(lambda _, __, geometries: geometries[0][1].append((99, 999, 999))),
                "100000")
        refused(changed(lambda _, __, geometries: geometries.__setitem__(
            0, (math.inf, geometries[0][1]))), "expected a finite number")
        refused(changed(lambda _, __, geometries: geometries.__setitem__(
            0, (0, geometries[0][1]))), "cell size 0 m")
        refused(good, "features.csv (pattern.yaml", out=self.path("never/poses.csv"), code=1)
        refused(good, "--image-size", code=1, more=("--image-size", "3x2"))
        self.assert_refused(run("inspect", self.path("bad.bin")), 2, "raygrid import")
        board = ("--pattern", "chessboard:9x6:30mm")
        size = ("--image-size", "640x480")
        to = ("--to", "puzzlepaint-dataset", "-o", self.path("never/d.bin"))
        for arguments, code, words in (
                ((*to, *size), 1, ("--pattern is required",)),
                ((*to, *board), 1, ("--image-size",)),
                ((*to, *board, "--image-size", "x=3x2"), 1, ("no camera 'x'",)),
                ((*to, *board, *size, "--model", "opencv"), 1, ("--model",)),
                ((*to, *board, "--image-size", "64x48"), 2, ("outside the 64 x 48",)),
                ((*to, "--pattern", "chessboard:5x5:30mm", *size), 2, ("5 x 5",)),
                ((*to, "--pattern", "aprilgrid:6x6:24mm", *size), 2, ("board 0", "AprilGrid")),
                (("--to", "puzzlepaint", "-o", self.path("never/c.yaml")), 2,
                 ("contains features", "puzzlepaint-dataset"))):
            with self.subTest(words):
                self.assert_refused(run("export", self.features, *arguments), code, *words)
        self.assert_nothing_in(self.path("never"))


if __name__ == "__main__":
    main(__name__)
