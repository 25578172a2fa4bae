#!/usr/bin/env python3
"""The simulate command: images and observations agree with the truth beside them."""
import csv
import json
import math
import os
import re

from command_test import CommandTest, long_test, main, read, run, specifications, write

OPENCV_CAMERA = """raygrid_camera: 1
model: opencv
image_size: [320, 240]
area: [0, 0, 319, 239]
parameters: {fx: 260, fy: 261, cx: 161, cy: 118, k1: -0.1, k2: 0.02, k3: 0, k4: 0, k5: 0,
             k6: 0, p1: 0.001, p2: -0.001}
"""

THREE_BOARDS = "raygrid_pattern: 1\nboards:\n" + "".join(
    "  - {id: %d, kind: chessboard, columns: 8, rows: 6, square_m: 0.025}\n" % i for i in range(3))


def table(path):
    lines = [line for line in read(path).decode().splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


def rotated(pose, point):
    """A point of a board in the camera's coordinates, by its row of poses.csv."""
    w, *v = (float(pose[key]) for key in ("qw", "qx", "qy", "qz"))
    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    t = [2 * c for c in cross(v, point)]
    u = cross(v, t)
    return [point[k] + w * t[k] + u[k] + float(pose["t" + "xyz"[k]]) for k in range(3)]


class Simulate(CommandTest):
    def simulate(self, *options, images=2):
        folder = self.path(self.id())
        result = self.succeed("simulate", "--images", images, *options, "-o", folder)
        self.assertEqual(result.stderr, "")
        return folder

    def render(self, *options):
        return self.simulate("--render", "--min-square-px", 14, "--max-square-px", 18,
                             "--max-tilt-deg", 20, *options)

    def board(self, kind, *size):
        folder = self.path(kind)
        self.succeed("pattern", kind, *size, "--dpi", 50, "-o", folder)
        return os.path.join(folder, "pattern.yaml")

    def chessboard(self):
        return self.board("chessboard", "--columns", 8, "--rows", 5, "--square-mm", 20)

    def assert_projections(self, folder, square_m, height=lambda x, y: 0, tolerance=5e-5):
        """features.csv is what true_camera.yaml makes of the poses and the board."""
        poses = {(row["image"], row["board"]): row
                 for row in table(os.path.join(folder, "true_poses.csv"))}
        features = table(os.path.join(folder, "features.csv"))
        self.assertGreater(len(features), 10)
        points = []
        for feature in features:
            x, y = int(feature["column"]) * square_m, int(feature["row"]) * square_m
            points.append(rotated(poses[feature["image"], feature["board"]], [x, y, height(x, y)]))
        path = write(self.path("points.csv"), "x,y,z\n" + "\n".join(
            ",".join(f"{c:.12f}" for c in point) for point in points))
        out = self.path("pixels.csv")
        self.succeed("project", os.path.join(folder, "true_camera.yaml"), "--points", path,
                     "-o", out)
        for feature, pixel in zip(features, table(out)):
            self.assertEqual(pixel["valid"], "1")
            self.assertAlmostEqual(float(feature["x"]), float(pixel["u"]), delta=tolerance)
            self.assertAlmostEqual(float(feature["y"]), float(pixel["v"]), delta=tolerance)

    def assert_detected(self, folder):
        """Features are seen in the images where features.csv says."""
        found = self.path("found.csv")
        self.succeed("detect", folder, "--pattern", os.path.join(folder, "pattern.yaml"),
                     "--no-cache", "-o", found)
        def places(path):
            return {tuple(row[key] for key in ("image", "board", "column", "row")):
                    (float(row["x"]), float(row["y"])) for row in table(path)}
        truth = places(os.path.join(folder, "features.csv"))
        seen = places(found)
        self.assertGreater(len(seen), 20)
        for key, place in seen.items():
            self.assertLess(math.dist(place, truth[key]), 0.1, key)

    def test_every_lens(self):
        for lens in ("pinhole", "wide", "fisheye", "fisheye190", "anamorphic", "off-axis",
                     "halves", "decentred", "mirror"):
            with self.subTest(lens):
                folder = self.render("--size", "320x240", "--lens", lens, "--pattern",
                                     self.chessboard())
                self.assert_projections(folder, 0.02)
                self.assertNotIn("true_lines.csv", os.listdir(folder))

    def test_parametric_camera_from_a_file(self):
        camera = write(self.path("opencv.yaml"), OPENCV_CAMERA)
        folder = self.render("--camera", camera, "--pattern", self.chessboard())
        self.assert_projections(folder, 0.02, tolerance=1e-5)
        self.assertIn(b"model: opencv", read(os.path.join(folder, "true_camera.yaml")))

    def test_simulated_camera_from_a_file(self):
        first = self.simulate("--size", "320x240", "--lens", "wide")
        camera = write(self.path("generic.yaml"), read(os.path.join(first, "true_camera.yaml")))
        folder = self.render("--camera", camera, "--pattern", self.chessboard())
        self.assert_projections(folder, 0.02, tolerance=1e-5)

    def test_every_kind_of_board(self):
        sizes = {"star": ("--columns", 8, "--rows", 7, "--square-mm", 15, "--tag-squares", 3),
                 "chessboard": ("--columns", 8, "--rows", 5, "--square-mm", 20),
                 "charuco": ("--columns", 6, "--rows", 4, "--square-mm", 20, "--marker-mm", 15, "--boards", 2),
                 "aprilgrid": ("--tag-columns", 3, "--tag-rows", 3, "--tag-mm", 20)}
        for word in specifications():
            kind = word.split(":")[0]
            with self.subTest(kind):
                folder = self.simulate(
                    "--render", "--lens", "pinhole", "--min-square-px", 30, "--max-square-px", 34,
                    "--max-tilt-deg", 20, "--pattern", self.board(kind, *sizes[kind]) if kind in sizes else word,
                    "--read-noise", 1, "--shot-noise", 0.02, "--vignetting", 0.3, "--gamma", 2.2, images=4)
                self.assert_detected(folder)

    def test_shots_of_a_view_differ_by_noise(self):
        for options in (("--noise-px", 0.01), ("--cameras", 2, "--noise-px", 0.01),
                        ("--render", "--size", "320x240", "--lens", "pinhole", "--read-noise", 2,
                         "--pattern", self.chessboard())):
            with self.subTest(options):
                folder = self.simulate("--repeats", 3, *options)
                poses = table(os.path.join(folder, "true_poses.csv"))
                names = sorted({pose["image"] for pose in poses})
                self.assertEqual(names, [f"sim000{k}.png" for k in range(6)])
                key = lambda row: (row.get("camera"), row["board"], row["qw"])
                seen = {name: {key(pose) for pose in poses if pose["image"] == name}
                        for name in names}
                self.assertEqual(seen[names[0]], seen[names[2]])
                self.assertNotEqual(seen[names[2]], seen[names[3]])
                places = {name: {(row.get("camera"), row["column"], row["row"]):
                                 (float(row["x"]), float(row["y"]))
                                 for row in table(os.path.join(folder, "features.csv"))
                                 if row["image"] == name} for name in names}
                self.assertEqual(set(places[names[0]]), set(places[names[1]]))
                moves = [math.dist(place, places[names[1]][which])
                         for which, place in places[names[0]].items()]
                self.assertLess(max(moves), 0.1)
                if "--render" in options:
                    first, second = (read(os.path.join(folder, name)) for name in names[:2])
                    self.assertNotEqual(first, second)
                else:
                    self.assertGreater(max(moves), 0)

    def test_bent_board(self):
        folder = self.render("--size", "320x240", "--lens", "pinhole", "--pattern",
                             self.chessboard(), "--target-deformation-mm", 3)
        self.assert_projections(folder, 0.02, lambda x, y: 0.003 * (
            ((x - 0.07) / 0.07) ** 2 + ((y - 0.04) / 0.04) ** 2 / 2))
        true_pattern = read(os.path.join(folder, "true_pattern.yaml")).decode()
        self.assertIn("0.004500000", true_pattern)  # at the corners
        self.assertNotIn("points", read(os.path.join(folder, "pattern.yaml")).decode())

    @long_test
    def test_calibrate_finds_a_board_that_is_hardly_bent(self):
        """Points that scatter independently would leave 0.05 to 0.12 px."""
        for bend_mm, seed in ((0.1, 11), (0.07, 23), (0.15, 27)):
            folder = self.simulate("--target-deformation-mm", bend_mm, "--seed", seed, images=20)
            out = self.path("calibrated")
            result = self.succeed("calibrate", "--features", os.path.join(folder, "features.csv"),
                                  "--pattern", os.path.join(folder, "pattern.yaml"),
                                  "--image-size", "640x480", "--skip-comparison",
                                  "--knot-spacing-px", 60, "-o", out)
            # Such a board is 0.357 bends from the nearest plane (RMS).
            told = re.search(r"board 0: out-of-plane deformation ([\d.]+) mm RMS", result.stdout)
            self.assertAlmostEqual(float(told[1]) / bend_mm, 0.357, delta=0.05)
            result = self.succeed("compare", os.path.join(folder, "true_camera.yaml"),
                                  os.path.join(out, "camera.yaml"), "--json")
            self.assertLess(json.loads(result.stdout)["median_px"], 0.02)

    def test_non_central_lens_has_its_exact_lines_beside_it(self):
        for options in ((), ("--render", "--pattern", self.chessboard())):
            folder = self.simulate("--lens", "noncentral", "--size", "320x240", *options)
            camera = read(os.path.join(folder, "true_camera.yaml")).decode()
            self.assertIn("model: noncentral-generic", camera)
            lines = table(os.path.join(folder, "true_lines.csv"))
            self.assertEqual(len(lines), 33 * 25)
            self.assertEqual((float(lines[-1]["x"]), float(lines[-1]["y"])), (319, 239))
            for line in lines:
                dx, dy, dz = (float(line["d" + k]) for k in "xyz")
                self.assertAlmostEqual(math.hypot(dx, dy, dz), 1, delta=1e-12)
                theta = math.atan2(math.hypot(dx, dy), dz)
                self.assertAlmostEqual(float(line["oz"]), 0.002 * theta ** 2, delta=1e-12)
                self.assertEqual((float(line["ox"]), float(line["oy"])), (0, 0))
            pixels = write(self.path("px.csv"), "x,y\n" + "\n".join(
                f"{line['x']},{line['y']}" for line in lines))
            rays = self.path("rays.csv")
            self.succeed("unproject", os.path.join(folder, "true_camera.yaml"), "--pixels",
                         pixels, "-o", rays)
            for line, ray in zip(lines, table(rays)):
                for key in ("dx", "dy", "dz", "ox", "oy", "oz"):
                    self.assertAlmostEqual(float(line[key]), float(ray[key]), delta=1e-6)

    def test_cameras_that_are_not_central_are_read_but_not_packed(self):
        folder = self.simulate("--lens", "glass", "--size", "320x240", "--noise-px", 0, images=4)
        camera = os.path.join(folder, "true_camera.yaml")
        lines = table(os.path.join(folder, "true_lines.csv"))
        points = write(self.path("xyz.csv"), "x,y,z\n" + "\n".join(
            ",".join(str(float(line["o" + k]) + 0.4 * float(line["d" + k])) for k in "xyz")
            for line in lines[33 + 1:33 + 32]))
        pixels = self.path("px.csv")
        self.succeed("project", camera, "--points", points, "-o", pixels)
        for line, pixel in zip(lines[33 + 1:33 + 32], table(pixels)):
            self.assertEqual(pixel["valid"], "1")
            self.assertAlmostEqual(float(line["x"]), float(pixel["u"]), delta=1e-3)
            self.assertAlmostEqual(float(line["y"]), float(pixel["v"]), delta=1e-3)
        outside = write(self.path("outside.csv"), "x,y\n-3,5\n")
        rays = self.path("rays.csv")
        self.succeed("unproject", camera, "--pixels", outside, "-o", rays)
        self.assertEqual(read(rays), b"x,y,dx,dy,dz,ox,oy,oz\n-3,5,,,,,,\n")
        evaluated = self.succeed("evaluate", camera, "--features", os.path.join(folder, "features.csv"),
                                 "--pattern", os.path.join(folder, "true_pattern.yaml"), "--json")
        self.assertLess(json.loads(evaluated.stdout)["max_px"], 1e-3)
        self.assert_refused(run("fit", camera, "--model", "opencv", "-o", self.path("fit.yaml")),
                            1, "noncentral")
        itself = self.succeed("compare", camera, camera, "--distance", 0.4, "--json")
        self.assertLess(json.loads(itself.stdout)["max_px"], 1e-6)
        self.assertEqual(len(json.loads(itself.stdout)["translation_m"]), 3)
        blob = self.path("lines.raygrid")
        self.succeed("pack", camera, "-o", blob)
        packed = run("unproject", blob, "--pixels", outside)
        self.assertEqual(packed.stdout, "x,y,dx,dy,dz,ox,oy,oz\n-3,5,,,,,,\n")

    def test_fewer_features_than_usual(self):
        star = self.board("star", "--columns", 16, "--rows", 15, "--square-mm", 10)
        folder = self.simulate("--pattern", star)  # 240 places, 25 of them at the tag
        self.assertEqual(len(table(os.path.join(folder, "features.csv"))), 2 * 215)

    def test_json(self):
        result = self.succeed("simulate", "--images", 2, "--json", "-o", self.path("json"))
        self.assertEqual(json.loads(result.stdout),
                         {"schema_version": 2, "images": 2, "image_size": [640, 480], "features": 480})

    def test_number_of_threads_changes_nothing(self):
        outputs = []
        for threads in (1, 3):
            folder = self.render("--size", "320x240", "--lens", "wide", "--read-noise", 2,
                                 "--threads", threads)
            outputs.append({name: read(os.path.join(folder, name)) for name in os.listdir(folder)})
        self.assertEqual(outputs[0], outputs[1])
        self.assertEqual(len(outputs[0]), 7)

    def test_views_bend_the_board_each_in_its_own_way(self):
        names = ("true_pattern.yaml", "true_camera.yaml", "features.csv")
        files = []
        for options in ((), ("--per-view-deformation-mm", 1)):
            folder = self.simulate("--noise-px", 0, *options)
            files.append([read(os.path.join(folder, name)) for name in names])
        flat, flexed = files
        self.assertEqual(flat[:2], flexed[:2])
        self.assertNotEqual(flat[2], flexed[2])

    def boards_seen(self, folder):
        seen = {}
        for row in table(os.path.join(folder, "features.csv")):
            seen.setdefault((row["image"], row["board"]), set()).add(row["camera"])
        return seen

    def test_cameras_before_fixed_boards_share_them_or_not(self):
        boards = write(self.path("three.yaml"), THREE_BOARDS)
        options = ("--pattern", boards, "--cameras", 2, "--baseline-m", 1, "--fixed-boards",
                   "--board-gap-m", 0.25)
        shared = self.boards_seen(self.simulate(*options, images=30))
        self.assertGreater(sum(len(cameras) > 1 for cameras in shared.values()), 0)
        hidden = self.boards_seen(self.simulate(*options, "--no-common-boards", images=30))
        self.assertEqual({len(cameras) for cameras in hidden.values()}, {1})
        self.assertEqual(set(hidden), set(shared))

    def test_wrong_usage(self):
        folder = self.path("refused")
        for options, code, word in ((("--target-deformation-mm", "abc"), 1, "--target-deformation-mm"),
                                    (("--features-per-image", 721), 1, "720"),
                                    (("--min-square-px", 40), 1, "--max-square-px"),
                                    (("--per-view-deformation-mm", 1, "--render"), 1, "--target-deformation-mm"),
                                    (("--per-view-deformation-mm", -1), 1, "--per-view-deformation-mm"),
                                    (("--fixed-boards",), 1, "at least two boards"),
                                    (("--fixed-boards", "--render"), 1, "--render"),
                                    (("--move-board-mm", 1), 1, "--fixed-boards"),
                                    (("--lens", "zoom"), 2, "zoom")):
            with self.subTest(options):
                self.assert_refused(run("simulate", *options, "-o", folder), code, word)
        self.assert_nothing_in(folder)


if __name__ == "__main__":
    main(__name__)
