#!/usr/bin/env python3
"""The paper's experiments, on very few images."""
import csv
import json
import math
import os
import random

from command_test import CommandTest, SIMULATED_PATTERN, long_test, main, read, run, write

ERRORS = ["median_x_px", "median_y_px", "rms_x_px", "rms_y_px"]
COUNTS = ["visible", "found", "compared"]


class Experiment(CommandTest):
    done = {}

    def run_experiment(self, name, threads, *options):
        """The rows of an experiment's CSV, and the contents of all its files."""
        folder = self.path(f"{name}-{threads}")
        result = self.succeed("experiment", name, "-o", folder, "--images", 1, "--threads", threads,
                              *options)
        self.assertEqual(result.stderr, "")
        for words in ("640 x 480 px", "blur", "noise", "window", "seed"):
            self.assertIn(words, result.stdout)
        files = {end: read(os.path.join(folder, f"{name}.{end}")) for end in ("csv", "json", "svg")}
        self.assertEqual(len(os.listdir(folder)), 3)
        lines = [line for line in files["csv"].decode().splitlines() if line[0] != "#"]
        return list(csv.DictReader(lines)), files

    def experiment(self, name, threads=2, *options):
        """The rows and files of run_experiment(), which runs only once."""
        arguments = (name, threads, *options)
        if arguments not in self.done:
            self.done[arguments] = self.run_experiment(*arguments)
        return self.done[arguments]

    def check(self, name, own_column, rows, files):
        for row in rows:
            self.assertEqual(list(row), ["pattern", own_column, *COUNTS, *ERRORS, "largest_px"])
            visible, found, compared = (int(row[key]) for key in COUNTS)
            self.assertGreaterEqual(visible, 83)
            self.assertLessEqual(found, visible)
            self.assertLessEqual(compared, found)
            self.assertGreater(compared, 40)
        as_json = json.loads(files["json"])
        self.assertEqual(as_json["experiment"], name)
        self.assertEqual(len(as_json["rows"]), len(rows))
        for row, same in zip(rows, as_json["rows"]):
            self.assertEqual(list(row), list(same))
            for key in ERRORS:
                self.assertAlmostEqual(float(row[key]), same[key], delta=1e-6)
        self.assertEqual(files["svg"].count(b"<svg"), 1)
        self.assertIn(b"px</text>", files["svg"])

    def test_pattern_segments(self):
        rows, files = self.experiment("pattern-segments")
        self.check("pattern-segments", "segments", rows, files)
        self.assertEqual([(row["pattern"], int(row["segments"])) for row in rows],
                         [("deltille-like" if n == 6 else "star", n)
                          for n in (4, 6, 8, 12, 16, 20, 24, 28, 32)] +
                         [("chessboard", 4)])
        rms = {row["segments"]: float(row["rms_x_px"]) for row in rows[:-1]}
        for error in rms.values():
            self.assertGreater(error, 0.001)
            self.assertLess(error, 0.01)
        # First better with more segments, then worse.
        self.assertLess(rms["16"], rms["4"])
        self.assertLess(rms["16"], rms["32"])

    def test_feature_refinement(self):
        rows, files = self.experiment("feature-refinement")
        self.check("feature-refinement", "refinement", rows, files)
        self.assertEqual([row["refinement"] for row in rows], 2 * [
            "intensities", "gradients-xy", "gradient-magnitude", "corner-subpix", "none"])
        for board in (rows[:5], rows[5:]):
            medians = [float(row["median_x_px"]) for row in board]
            self.assertLess(medians[0], 0.01)
            self.assertGreater(medians[4], 3 * medians[0])
            self.assertLess(medians[4], 0.2)

    def small(self, name, *options, images=8):
        """Rows of an experiment on simulated features, its pictures named."""
        folder = self.path(name + "-small")
        self.succeed("experiment", name, "-o", folder, "--images", images, *options)
        text = read(os.path.join(folder, name + ".csv")).decode()
        rows = list(csv.DictReader(line for line in text.splitlines() if line[0] != "#"))
        self.assertIn(b"</svg>", read(os.path.join(folder, name + ".svg")))
        pictures = sorted(file for file in os.listdir(folder) if file.endswith(".png"))
        return rows, pictures

    def test_model_validation(self):
        rows, pictures = self.small("model-validation", images=5)
        self.assertEqual(pictures, ["model-validation-directions.png"])
        for key in ("training_median_px", "test_median_px", "ray_error_px"):
            parametric = [float(row[key]) for row in rows if row["cells"] == "0"]
            generic = [float(row[key]) for row in rows if row["cells"] != "0"]
            self.assertEqual((len(parametric), len(generic)), (3, 4))
            self.assertLess(2 * max(generic), min(parametric))

    @long_test
    def test_capture_guidance(self):
        rows, pictures = self.small("capture-guidance", "--size", "320x240", images=1)
        self.assertEqual(pictures, [])
        images = {row["operator_follows"]: int(row["images"]) for row in rows}
        self.assertEqual(list(images), ["next view", "ROS's bars", "nothing"])
        self.assertEqual(rows[0]["is_known"], "yes")
        # One lens tells little of the number of images, by luck.
        self.assertGreater(images["next view"], 4)
        self.assertLess(images["next view"], 0.5 * images["ROS's bars"])
        predicted = {row["operator_follows"]: float(row["predicted_px"]) for row in rows}
        self.assertLess(0.005, predicted["next view"])
        # With many more images the bars' camera is predicted to be known less.
        self.assertLess(predicted["next view"], predicted["ROS's bars"])

    def fine(self, name, *options):
        """The rows of model-validation --fine-distortion, small, and its pictures."""
        folder = self.path(name)
        self.succeed("experiment", "model-validation", "--fine-distortion", "-o", folder, *options)
        text = read(os.path.join(folder, "model-validation.csv")).decode()
        rows = list(csv.DictReader(line for line in text.splitlines() if line[0] != "#"))
        return rows, sorted(file for file in os.listdir(folder) if file.endswith(".png"))

    def test_fine_model_validation(self):
        rows, pictures = self.fine("fine", "--images", 12, "--size", "160x100", "--bump-px", 20)
        self.assertEqual(pictures, ["model-validation-directions-20px.png"])
        self.assertEqual({row["bump_px"] for row in rows}, {"20"})

        def column(key, model=""):
            return {int(row["cell_px"]): float(row[key]) for row in rows
                    if row["model"].startswith(model) and (model or row["cell_px"] == "0")}
        parameters = column("parameters", "central-generic")
        self.assertEqual(list(parameters), [30, 20, 10])
        self.assertEqual(len(column("test_median_px", "noncentral-generic")), 3)
        parametric = min(float(row["test_median_px"]) for row in rows if row["cell_px"] == "0")
        for model in ("central-generic", "noncentral-generic"):
            # Cells of 30 px cannot follow bumps of 20 px, those of 10 px can.
            errors, rays = column("test_median_px", model), column("ray_rms_px", model)
            self.assertLess(1.2 * errors[10], parametric)
            self.assertLess(1.5 * rays[10], rays[30])
            self.assertLess(errors[10], errors[30])

    def test_fine_is_refused_where_it_has_no_use(self):
        for name, *options in (["noncentrality"], ["model-validation", "--features", "no.csv"]):
            result = run("experiment", name, "--fine-distortion", "-o", self.path("none"), *options)
            self.assertEqual(result.returncode, 1)
            self.assertIn("--fine-distortion", result.stderr)
            self.assertEqual(result.stderr.count("\n"), 1)

    def test_model_comparison(self):
        rows, pictures = self.small("model-comparison")
        self.assertEqual(pictures, ["model-comparison-direction.png",
                                    "model-comparison-magnitude.png"])
        self.assertEqual(len(rows), 3)
        for row in rows:  # the lens has bumps of up to 1.5 px
            self.assertGreater(float(row["rms_px"]), 0.1)
            self.assertLess(float(row["rms_px"]), 0.7)

    def test_noncentrality(self):
        rows, pictures = self.small("noncentrality")
        self.assertEqual(pictures, ["noncentrality-offsets.png"])
        errors = [float(row["right_far_rms_px"]) for row in rows]
        self.assertEqual(errors, sorted(errors, reverse=True))
        self.assertGreater(errors[0], 0.5)

    def test_localization(self):
        rows, _ = self.small("localization", images=5)
        by_name = {row.pop("camera"): [float(value) for value in row.values()] for row in rows}
        # Noise averages out, a wrong camera does not.
        self.assertLess(by_name["truth"][3], 0.3 * by_name["truth"][0])
        self.assertGreater(by_name["opencv"][3], 0.8 * by_name["opencv"][0])
        # The true place is not off, but what noise leaves.
        self.assertLess(by_name["truth"][4], 0.5 * by_name["truth"][3])
        for generic in ("central-generic", "noncentral-generic"):
            self.assertLess(by_name[generic][3], 0.5 * by_name["opencv"][3])

    def test_curvature_bias(self):
        rows, _ = self.small("curvature-bias", images=6)
        error = {(row["mapping"], row["window_px"]): float(row["feature_error_rms_px"])
                 for row in rows}
        self.assertLess(2 * error["curved", "21"], error["homography", "21"])
        self.assertLess(error["homography", "11"], error["homography", "31"])

    @long_test
    def test_stereo_depth(self):
        rows, pictures = self.small("stereo-depth", images=8)
        self.assertEqual(pictures, ["stereo-depth-bias.png"])
        bias = {row["cameras"]: float(row["blocks_rms_mm"]) for row in rows}
        self.assertEqual(list(bias), ["opencv", "thin-prism-fisheye", "noncentral-generic",
                                      "central-generic", "truth"])
        self.assertLess(2 * bias["central-generic"], bias["opencv"])
        self.assertLess(bias["central-generic"], 3 * bias["truth"])

    def own_camera(self):
        """A result's folder with the true camera of a lens that no parametric model follows."""
        folder = self.path("lens")
        self.succeed("simulate", "--images", 1, "-o", folder)
        os.replace(os.path.join(folder, "true_camera.yaml"), os.path.join(folder, "camera.yaml"))
        return folder

    def test_trajectory_drift(self):
        camera = self.own_camera()
        rows, _ = self.small("trajectory-drift", "--camera", camera, "--trajectories", 1)
        rows = {row.pop("camera"): {key: float(value) for key, value in row.items()}
                for row in rows}
        truth = camera + " (reference)"
        self.assertEqual(list(rows), ["opencv", "thin-prism-fisheye", "central-radial", truth])
        for row in rows.values():
            # Both starts are far off, and both end in one place.
            self.assertGreater(row["start_error_percent"], 1)
            self.assertAlmostEqual(row["end_error_percent"], row["from_other_start_percent"],
                                   delta=0.005)
        self.assertLess(5 * rows[truth]["end_error_percent"], rows["opencv"]["end_error_percent"])

    def test_own_camera(self):
        camera = self.own_camera()
        rows, _ = self.small("localization", "--camera", camera)
        text = read(self.path("localization-small/localization.csv")).decode()
        self.assertIn(f"# truth: not available; {camera} serves as reference, the others are fitted", text)
        rows = {row.pop("camera"): [float(value) for value in row.values()] for row in rows}
        truth = rows.pop(camera + " (reference)")
        self.assertEqual(list(rows), ["opencv", "thin-prism-fisheye", "central-radial"])
        for fitted in rows.values():  # wrong, which no mean of images mends
            self.assertGreater(fitted[3], 10 * truth[3])
            self.assertGreater(fitted[3], 0.9 * fitted[0])

        # Of two, the last is the truth: the other one's errors are the same either way.
        fit = self.path("opencv.yaml")
        self.succeed("fit", os.path.join(camera, "camera.yaml"), "--model", "opencv", "-o",
                     fit)
        rows, _ = self.small("localization", "--camera", camera, "--camera", fit)
        self.assertEqual([row["camera"] for row in rows], [camera, fit + " (reference)"])
        self.assertGreater(float(rows[0]["mean_of_64_mm"]), 10 * float(rows[1]["mean_of_64_mm"]))

        def refused(code, words, *options):
            self.assert_refused(run("experiment", "localization", "-o", self.path("refused"),
                                    *options), code, words)
        self.succeed("simulate", "--images", 1, "--size", "320x240", "--lens", "fisheye",
                     "-o", self.path("smaller"))
        refused(2, "image size differs", "--camera", camera, "--camera",
                self.path("smaller/true_camera.yaml"))
        refused(1, "7 cameras", *7 * ("--camera", fit))
        os.makedirs(self.path("empty"))
        refused(2, "camera.yaml", "--camera", self.path("empty"))

    def test_residual_budget(self):
        rows, pictures = self.small("residual-budget", images=100)
        self.assertEqual(pictures, [])
        self.assertEqual([row["limited_by"] for row in rows],
                         ["noise"] + [row["fault"] for row in rows[1:]])
        self.assertEqual(len(rows), 7)
        self.assertAlmostEqual(float(rows[0]["noise_px"]), 0.05, delta=0.0025)

    def test_residual_budget_of_a_calibration(self):
        self.succeed("simulate", "--images", 12, "--pattern", "chessboard:14x10:30mm",
                     "--noise-px", 0.02, "--per-view-deformation-mm", 0.5, "-o", self.path("bent"))
        pattern = self.path("bent/pattern.yaml")
        features = self.path("bent/features.csv")
        size = ("--image-size", "640x480")
        done = self.succeed("calibrate", "--features", features, "--pattern", pattern, *size,
                            "--knot-spacing-px", 160, "--rigid-target", "--skip-comparison",
                            "-o", self.path("result"))
        result = json.loads(read(self.path("result/result.json")))
        budget = result["residual_budget"]
        self.assertEqual(budget["limited_by"], "per-view deformation")
        self.assertIn("--rigid-target", budget["recommendation"])
        report = read(self.path("result/report.html")).decode()
        self.assertIn("What limits this calibration", report)
        # Terminal, verdict and report say one thing.
        self.assertIn(f"  limited by per-view deformation: {budget['summary']}; remedy: {budget['recommendation']}\n",
                      done.stdout)
        said = f"{budget['summary']}; {budget['recommendation']}"
        self.assertTrue(any(said in reason for reason in result["reasons"]), result["reasons"])
        self.assertFalse([reason for reason in result["reasons"] if "--knot-spacing-px" in reason])
        self.assertEqual(report.count(budget["recommendation"]), 2)
        rows, _ = self.small("residual-budget", "--result", self.path("result"))
        parts = {row["cause"]: float(row["part_percent"]) for row in rows}
        self.assertGreater(parts["per-view deformation"], 40)
        self.assertAlmostEqual(sum(parts.values()), 100, delta=0.1)
        bends = [cause for cause in budget["causes"] if cause["cause"] == "per-view deformation"][0]
        self.assertAlmostEqual(100 * bends["fraction"], parts["per-view deformation"], delta=0.5)
        # The true camera, which localises the images.
        rows, _ = self.small("residual-budget", "--features", features, "--pattern", pattern,
                             *size, "--camera", self.path("bent/true_camera.yaml"))
        parts = {row["cause"]: float(row["part_percent"]) for row in rows}
        self.assertGreater(parts["per-view deformation"], 40)

    def test_residual_budget_says_what_it_needs(self):
        def fails(code, words, *options):
            result = run("experiment", "residual-budget", "-o", self.path("none"), *options)
            self.assert_refused(result, code, words)
        fails(2, "result.json: missing", "--result", self.path("nothing"))
        self.succeed("simulate", "--images", 2, "-o", self.path("few"))
        few = ("--features", self.path("few/features.csv"), "--image-size", "640x480",
               "--pattern", self.path("few/pattern.yaml"))
        fails(1, "one --camera", *few)
        # Two views do not tell what features of one place share.
        camera = ("--camera", self.path("few/true_camera.yaml"))
        rows, _ = self.small("residual-budget", *few, *camera)
        remarks = {row["cause"]: row["remark"] for row in rows}
        self.assertEqual(remarks["lens model"], "not observable: 2 views, at least 8 required")

    def colmap_model(self, folder, camera, size=(640, 480)):
        """A walk past points on both sides, as structure from motion would have it."""
        rng = random.Random(5)
        points = [(rng.choice((-1, 1)) * rng.uniform(0.5, 1.5), rng.uniform(-0.8, 0.8),
                   rng.uniform(0, 9)) for _ in range(500)]
        # All images' points in one list, since each run of the program takes its time.
        walk, seen_by = [], []
        for i in range(40):
            yaw, place = 0.3 * math.sin(i / 5), (0.1 * math.sin(i / 4), 0, 0.1 * i)
            c, s = math.cos(yaw), math.sin(yaw)
            seen = {}
            for k, p in enumerate(points):
                x, y, z = (a - b for a, b in zip(p, place))
                x, z = c * x - s * z, s * x + c * z
                if 0.7 < z < 6:
                    seen[k] = (x, y, z)
            walk.append((yaw, place))
            seen_by.append(seen)
        csv_path = write(self.path("walk.csv"), "x,y,z\n" + "\n".join(
            ",".join(map(str, p)) for seen in seen_by for p in seen.values()) + "\n")
        pixels = iter(json.loads(run("project", camera, "--points", csv_path, "--json").stdout))
        images, tracks = [], 0
        for i, ((yaw, place), seen) in enumerate(zip(walk, seen_by)):
            c, s = math.cos(yaw), math.sin(yaw)
            # The middle of COLMAP's first pixel is (0.5, 0.5).
            line = [f"{p['u'] + 0.5} {p['v'] + 0.5} {k + 7}"
                    for k, p in zip(seen, pixels) if p["valid"]] + ["3.5 4.5 -1"]
            tracks += len(line)
            x, y, z = place
            move = (-(c * x - s * z), -y, -(s * x + c * z))
            images.append(" ".join(map(str, (i + 1, math.cos(yaw / 2), 0, -math.sin(yaw / 2), 0,
                                             *move, 1, f"walk/{i:03}.jpg"))))
            images.append(" ".join(line))
        write(os.path.join(folder, "cameras.txt"),
              f"# Camera list\n1 PINHOLE {size[0]} {size[1]} 510 510 320 240\n")
        write(os.path.join(folder, "images.txt"), "# Image list\n" + "\n".join(images) + "\n")
        write(os.path.join(folder, "points3D.txt"), "# 3D point list\n" + "\n".join(
            f"{k + 7} {x} {y} {z} 0 0 0 1" for k, (x, y, z) in enumerate(points)) + "\n")
        self.assertGreater(tracks, 4000)
        return folder

    def test_own_walk(self):
        self.succeed("simulate", "--images", 1, "-o", self.path("lens"))
        truth = self.path("lens/true_camera.yaml")
        self.succeed("fit", truth, "--model", "opencv", "-o", self.path("opencv.yaml"))
        folder = self.colmap_model(self.path("colmap"), truth)
        cameras = ("--camera", self.path("opencv.yaml"), "--camera", truth)
        rows, _ = self.small("trajectory-drift", "--colmap-model", folder, *cameras)
        self.assertEqual([row["camera"] for row in rows], [self.path("opencv.yaml"), truth])
        # The pixels are those of the true camera, and the other is wrong by 0.3 px.
        self.assertLess(float(rows[1]["residual_median_px"]), 1e-4)
        self.assertGreater(float(rows[0]["residual_median_px"]), 0.02)
        self.assertEqual(float(rows[1]["end_error_percent"]), 0)
        self.assertGreater(float(rows[0]["end_error_percent"]), 0.01)
        self.assertLess(float(rows[0]["end_error_percent"]), 5)

        def refused(code, *words, options=cameras):
            self.assert_refused(run("experiment", "trajectory-drift", "-o", self.path("refused"),
                                    "--colmap-model", folder, *options), code, *words)
        refused(1, "--camera", options=cameras[:2])
        points = read(os.path.join(folder, "points3D.txt"))
        write(os.path.join(folder, "points3D.txt"), points.replace(b"\n7 ", b"\n7 x", 1))
        refused(2, "points3D.txt, line 2", "number")
        write(os.path.join(folder, "points3D.txt"), points.replace(b"\n7 ", b"\n6 ", 1))
        refused(2, "images.txt, line", "point 7")
        write(os.path.join(folder, "points3D.txt"), points)
        sizes = read(os.path.join(folder, "cameras.txt"))
        write(os.path.join(folder, "cameras.txt"), sizes.replace(b"640", b"641"))
        refused(2, "641 x 480", "640 x 480")
        os.remove(os.path.join(folder, "images.txt"))
        write(os.path.join(folder, "cameras.txt"), sizes)
        refused(2, "images.txt")

    def photograph_wall(self, camera, x_m, path):
        """A PGM of a painted wall 1 m away, from a camera x_m to the right."""
        pixels = write(self.path("all.csv"), "x,y\n" + "\n".join(
            f"{x},{y}" for y in range(240) for x in range(320)) + "\n")
        grey = bytearray()
        for row in csv.DictReader(run("unproject", camera, "--pixels", pixels).stdout.split()):
            level = 0
            if row["dz"]:
                z = float(row["dz"])
                x, y = x_m + float(row["dx"]) / z, float(row["dy"]) / z
                level = 128 + sum(20 * math.sin(k * (c * x + d * y) + k) for k, c, d in (
                    (61, 1, .3), (97, .2, 1), (143, .8, -.6), (179, -.5, .9), (211, 1, .1)))
            grey.append(round(level))
        return write(path, b"P5\n320 240\n255\n" + bytes(grey))

    def test_own_stereo_pair(self):
        self.succeed("simulate", "--images", 1, "--size", "320x240", "--lens", "fisheye",
                     "-o",
                     self.path("narrow"))
        truth = self.path("narrow/true_camera.yaml")
        fitted = self.path("narrow/fitted.yaml")
        self.succeed("fit", truth, "--model", "opencv", "-o", fitted)
        rig = """raygrid_rig: 1
cameras:
  "left":
    file: "FILE"
    camera_from_rig:
      rotation: {w: 1, x: 0, y: 0, z: 0}
      translation: {x: 0, y: 0, z: 0}
  "right":
    file: "FILE"
    camera_from_rig:
      rotation: {w: 1, x: 0, y: 0, z: 0}
      translation: {x: -0.1, y: 0, z: 0}
"""
        rigs = [write(self.path(f"narrow/{name}_rig.yaml"), rig.replace("FILE", name + ".yaml"))
                for name in ("fitted", "true_camera")]
        data = ("--image", self.photograph_wall(truth, 0, self.path("left.pgm")),
                "--image", self.photograph_wall(truth, 0.1, self.path("right.pgm")))
        both = ("--rig", rigs[0], "--rig", rigs[1])
        rows, pictures = self.small("stereo-depth", *both, *data, "--min-depth-m", 0.7)
        self.assertEqual(pictures, ["stereo-depth-bias.png"])
        self.assertEqual([row["cameras"] for row in rows], rigs)
        self.assertAlmostEqual(float(rows[0]["baseline_m"]), 0.1)
        for row in rows:
            self.assertGreater(int(row["matches"]), 1000)
        # The lens has bumps that OpenCV's model does not follow: 1 px is 39 mm.
        self.assertGreater(float(rows[0]["blocks_rms_mm"]), 1)
        self.assertLess(float(rows[0]["blocks_rms_mm"]), 30)
        self.assertLess(float(rows[1]["blocks_rms_mm"]), 1e-3)
        # Rendered instead, through the true rig, to whose cameras models are fitted.
        os.mkdir(self.path("rig"))
        os.rename(rigs[1], self.path("rig/rig.yaml"))
        os.rename(truth, self.path("rig/true_camera.yaml"))
        rows, _ = self.small("stereo-depth", "--rig", self.path("rig"))
        bias = {row["cameras"]: float(row["blocks_rms_disparity_px"]) for row in rows}
        self.assertEqual(list(bias), ["opencv", "thin-prism-fisheye", "central-radial",
                                      self.path("rig")])
        own = bias.pop(self.path("rig"))
        self.assertLess(own, 0.05)  # of single windows
        for fitted in bias.values():  # turned as the cameras are, and wrong by bumps only
            self.assertGreater(fitted, 1.1 * own)
            self.assertLess(fitted, 4 * own)
        both = ("--rig", rigs[0], "--rig", self.path("rig"))
        self.assert_refused(run("experiment", "stereo-depth", "-o", self.path("refused"), *both,
                                *data[:2]), 1, "--image")
        self.assert_refused(run("experiment", "stereo-depth", "-o", self.path("refused"),
                                "--camera", self.path("rig/true_camera.yaml")), 1, "--camera")

    def test_own_images_of_a_curved_lens(self):
        self.succeed("pattern", "star", "--columns", 14, "--rows", 10, "--square-mm", 20,
                     "--page", "A3", "-o", self.path("stars"))
        self.succeed("simulate", "--render", "--images", 4, "--lens", "fisheye",
                     "--pattern", self.path("stars/pattern.yaml"), "--min-square-px", 24,
                     "--max-square-px", 34, "--read-noise", 2, "-o",
                     self.path("fisheye"))
        data = ("--features", self.path("fisheye/features.csv"), "--pattern",
                self.path("fisheye/true_pattern.yaml"), "--image-size", "640x480", "--image",
                self.path("fisheye"))
        rows, _ = self.small("curvature-bias", *data, "--camera",
                             self.path("fisheye/true_camera.yaml"))
        self.assertEqual([row["window_px"] for row in rows], ["11", "15", "21", "31"])
        shifts = [float(row["shift_rms_px"]) for row in rows]
        self.assertEqual(shifts, sorted(shifts))
        self.assertGreater(shifts[2], 0.02)
        for row in rows:  # of the true camera
            self.assertLess(float(row["residual_rms_curved_px"]), 0.05)
        self.assert_refused(run("experiment", "curvature-bias", "-o", self.path("refused"), *data),
                            1, "--camera")

    def test_own_features(self):
        self.succeed("simulate", "--images", 8, "--features-per-image", 100, "--pattern",
                     write(self.path("board.yaml"), SIMULATED_PATTERN), "-o",
                     self.path("own"))
        data = ("--features", self.path("own/features.csv"), "--pattern",
                self.path("own/pattern.yaml"), "--image-size", "640x480")
        rows, _ = self.small("localization", *data)
        self.assertIn("central-generic (reference)", [row["camera"] for row in rows])
        text = read(self.path("localization-small/localization.csv")).decode()
        self.assertIn("# truth: not available; central-generic serves as reference", text)
        self.assertIn("target geometry estimated", text)
        self.assert_refused(run("experiment", "stereo-depth", "-o", self.path("refused"), *data), 2,
                            "two", "column 'camera'")
        folder = self.path("refused")
        self.assert_refused(run("experiment", "pattern-segments", "-o", folder, *data), 1,
                            "--features")
        self.assert_refused(run("experiment", "localization", "-o", folder, *data[:2]), 1,
                            "--pattern")

    @long_test
    def test_repeatability(self):
        def simulate(folder, images):
            self.succeed("simulate", "--images", images, "--features-per-image", 100,
                         "--lens", "wide", "--size", "320x240",
                         "--pattern", write(self.path("board.yaml"), SIMULATED_PATTERN),
                         "--correlated-noise-px", 0.05, "-o", self.path(folder))
            return ("--features", self.path(folder + "/features.csv"), "--pattern",
                    self.path(folder + "/pattern.yaml"), "--image-size", "320x240")
        rows, _ = self.small("repeatability", *simulate("many", 16))
        self.assertEqual([row["pair"] for row in rows],
                         [str(k + 1) for k in range(10)] + ["all"])
        self.assertGreater(int(rows[-1]["known_places"]), 1000)
        # White noise alone would make the ratio about 2.
        self.assertGreater(float(rows[-1]["known_ratio"]), 0.2)
        self.assertLess(float(rows[-1]["known_ratio"]), 1.4)
        # Ten pairs of many numbers each scatter little, but they do.
        least, most = (float(rows[-1][name]) for name in ("chance_least", "chance_most"))
        self.assertTrue(0.5 < least < 0.97 and 1.03 < most < 1.4, (least, most))
        self.assertEqual(rows[0]["chance_least"], "none")
        # Noise alone scatters cameras by less than is stated of their errors.
        self.assertGreater(float(rows[-1]["known_scatter_ratio"]), float(rows[-1]["known_ratio"]))
        self.assert_refused(run("experiment", "repeatability", "-o", self.path("few"),
                                *simulate("five", 5)), 3, "use more images")

    def test_number_of_threads_changes_nothing(self):
        name = "feature-refinement"
        self.assertEqual(self.experiment(name, 1), self.experiment(name, 2))

    def test_seed_and_noise_change_the_result(self):
        rows, _ = self.experiment("feature-refinement")
        for options in (("--seed", 1), ("--read-noise", 4)):
            others, _ = self.experiment("feature-refinement", 2, *options)
            self.assertNotEqual(rows, others)

    def test_list(self):
        result = self.succeed("experiment", "--list")
        for name in ("pattern-segments", "feature-refinement", "model-validation",
                     "model-comparison", "curvature-bias", "noncentrality", "localization",
                     "stereo-depth", "trajectory-drift"):
            self.assertIn(name, result.stdout)

    def test_help_has_an_example(self):
        result = self.succeed("experiment", "--help")
        self.assertIn("raygrid experiment pattern-segments -o", result.stdout)

    def test_inputs_stay(self):
        folder = self.path("own")
        features = write(os.path.join(folder, "model-comparison.csv"), "image,board,column\n")
        result = run("experiment", "model-comparison", "--features", features, "--pattern",
                     "chessboard:9x6:25mm", "--image-size", "640x480", "-o", folder)
        self.assert_refused(result, 7, "model-comparison.csv", "would overwrite the input")
        image = write(os.path.join(folder, "x.pgm"), b"P5 64 48 255\n" + bytes(64 * 48))
        result = run("experiment", "curvature-bias", "--image", image, "-o", folder)
        self.assert_refused(result, 7, "x.pgm", "use another output folder")
        self.assertEqual(sorted(os.listdir(folder)), ["model-comparison.csv", "x.pgm"])

    def test_wrong_usage(self):
        folder = self.path("refused")
        for arguments, word in ((("magic", "-o", folder), "--list"),
                                (("pattern-segments",), "-o"),
                                (("feature-refinement", "-o", folder, "--size", "300x200"), "--size"),
                                (("feature-refinement", "-o", folder, "--images", 0), "--images")):
            with self.subTest(arguments):
                self.assert_refused(run("experiment", *arguments), 1, word)
        self.assert_nothing_in(folder)


if __name__ == "__main__":
    main(__name__)
