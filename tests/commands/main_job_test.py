#!/usr/bin/env python3
"""The commands together, on simulated truth and on real photographs."""
import csv
import dataclasses
import io
import json
import math
import os
import re
import stat
import subprocess
import sys

from command_test import CalibratedTest, CommandTest, PATTERN, main, programs, read, run, write
from images_test import png, read_png

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "formats"))
import blob_reference as reference  # noqa: E402


def rows(text):
    return list(csv.DictReader(io.StringIO(text)))


class MainJob(CalibratedTest):
    options = ("--serial", "42")

    def test_calibrate_writes_all_files(self):
        expected = {"camera.yaml", "camera.raygrid", "pattern.yaml", "features.csv", "poses.csv",
                    "residuals.csv", "result.json", "report.html", "uncertainty.png",
                    "view.camera.yaml"}
        self.assertEqual(set(os.listdir(self.path("out"))), expected)
        result = json.loads(read(self.path("out/result.json")))
        view = result["packing"]["view"]
        table = json.loads(run("inspect", self.path("out/camera.raygrid"), "--json").stdout)[
            "remap_tables"][0]
        self.assertEqual(view["size"], table["size"])
        for told, held in zip(sum(view["K"], []), sum(table["K"], [])):
            self.assertAlmostEqual(told, held, 4)
        self.assertIn("fx: ", read(self.path("out/view.camera.yaml")).decode())
        self.assertEqual(result["status"], "converged")
        self.assertEqual(result["features"]["used"], 1440)
        self.assertLess(abs(result["training"]["rms_px"] - 0.05 * math.sqrt(2)), 0.02)

    def test_images_that_are_not_used_are_named(self):
        more = write(self.path("more.csv"), read(self.path("sim/features.csv")) +
                     b"few.png,0,0,0,100,100\nfew.png,0,1,0,130,100\none.png,0,3,3,99,9\n")
        result = self.succeed("calibrate", "--features", more, "--image-size", "640x480", "--pattern",
                              self.path("sim/pattern.yaml"), "--model", "opencv", "--skip-comparison",
                              "--hold-out", "sim0003.png", "-o", self.path("more"))
        self.assertIn("rejected: few.png (only 2 features)", result.stdout)
        self.assertIn("rejected: one.png (only 1 features)", result.stdout)

    def test_same_output_with_any_number_of_threads(self):
        # The others ran with as many as there are processors.
        threads = 1 if os.cpu_count() > 1 else 3
        self.succeed("calibrate", "--features", self.path("sim/features.csv"), "--image-size",
                     "640x480", "--pattern", self.path("sim/pattern.yaml"), "--knot-spacing-px", 80,
                     "--name", "front", "--serial", "42", "--threads", threads, "-o",
                     self.path("again"))
        for name in ("camera.yaml", "camera.raygrid", "pattern.yaml", "features.csv",
                     "poses.csv", "report.html", "uncertainty.png"):
            self.assertEqual(read(self.path("again/" + name)), read(self.path("out/" + name)),
                             name)

    def test_frames_of_a_video_are_as_many_images_as_they_show_views(self):
        self.succeed("simulate", "--images", 13, "--repeats", 39, "--features-per-image",
                     120, "--pattern", self.path("board.yaml"), "-o", self.path("video"))
        result = self.succeed("calibrate", "--features", self.path("video/features.csv"), "--image-size",
                              "640x480", "--pattern", self.path("video/pattern.yaml"), "--knot-spacing-px", 160,
                              "--skip-comparison", "-o", self.path("video_out"))
        self.assertIn("507 images show 13 different views", result.stdout)
        images = json.loads(read(self.path("video_out/result.json")))["images"]
        self.assertEqual((images["used"], images["rejected"]), (13, []))
        groups = images["near_duplicates"]
        named = [name for group in groups for name in [group["image"], *group["duplicates"]]]
        self.assertEqual(sorted(named), [f"sim{k:04}.png" for k in range(507)])
        poses = rows(read(self.path("video_out/poses.csv")).decode())
        self.assertEqual(sorted(pose["image"] for pose in poses), sorted(named))
        self.assertIn(b"sim0000.png represents 38 more: sim0001.png, sim0002.png",
                      read(self.path("video_out/report.html")))

    def test_compare_finds_little_between_camera_and_truth(self):
        result = self.succeed("compare", self.path("sim/true_camera.yaml"), self.path("out/camera.raygrid"),
                              "-o", self.path("difference"), "--json")
        figures = json.loads(result.stdout)
        self.assertLess(figures["median_px"], 0.05)
        self.assertLess(0, figures["median_px"])
        # The extrapolated rest of the image is told apart.
        valid = figures["valid_region"]
        self.assertTrue(0 < valid["points"] <= figures["points"], valid)
        self.assertLessEqual(valid["max_px"], figures["max_px"])
        self.assertEqual(set(os.listdir(self.path("difference"))),
                         {"difference.json", "difference.csv", "magnitude.png", "direction.png"})
        places = rows(read(self.path("difference/difference.csv")).decode())
        self.assertEqual(len(places), figures["points"])

    def test_compare_tells_which_camera_predicts_features_better(self):
        self.succeed("fit", self.path("out/camera.yaml"), "--model", "opencv", "-o",
                     self.path("opencv.yaml"))
        self.succeed("simulate", "--images", 10, "--features-per-image", 120, "--seed", 9,
                     "--pattern", self.path("board.yaml"), "-o", self.path("new"))
        data = ("--features", self.path("new/features.csv"), "--pattern",
                self.path("sim/pattern.yaml"))
        for first, second, better in (("out/camera.yaml", "opencv.yaml", "first"),
                                      ("opencv.yaml", "out/camera.yaml", "second"),
                                      ("opencv.yaml", "opencv.yaml", "neither")):
            result = self.succeed("compare", self.path(first), self.path(second), *data, "--json", "-o",
                                  self.path("prediction"))
            prediction = json.loads(result.stdout)["prediction"]
            self.assertEqual(prediction["better"], better)
            images = rows(read(self.path("prediction/predictions.csv")).decode())
            self.assertEqual(len(images), 10)
            if better == "first":
                self.assertLess(2 * prediction["first"]["rms_px"], prediction["second"]["rms_px"])
        result = run("compare", self.path("out/camera.yaml"), self.path("opencv.yaml"), *data)
        self.assertIn("out/camera.yaml predicts better", result.stdout)
        self.assert_refused(run("compare", self.path("out/camera.yaml"),
                                self.path("opencv.yaml"), *data[:2]), 1, "--pattern")

    def test_rays_and_pixels_as_json(self):
        pixels = write(self.path("few.csv"), "x,y\n320,240\n-50,3\n")
        for camera in ("out/camera.yaml", "out/camera.raygrid"):
            rays = json.loads(run("unproject", self.path(camera), "--pixels", pixels,
                                  "--json").stdout)
            self.assertEqual(list(rays[0]), ["x", "y", "dx", "dy", "dz"])
            self.assertAlmostEqual(sum(rays[0][key] ** 2 for key in ("dx", "dy", "dz")), 1)
            self.assertIsNone(rays[1]["dz"])
        points = write(self.path("few_points.csv"), "x,y,z\n0.1,0,1\n0,0,-1\n")
        seen = json.loads(run("project", self.path("out/camera.yaml"), "--points", points,
                              "--json").stdout)
        self.assertEqual([row["valid"] for row in seen], [1, 0])
        self.assertGreater(seen[0]["u"], 320)
        self.assertIsNone(seen[1]["u"])

    def test_fit_says_what_a_parametric_model_leaves(self):
        result = self.succeed("fit", self.path("out/camera.yaml"), "--model", "thin-prism-fisheye", "-o",
                              self.path("fitted.yaml"), "--json")
        figures = json.loads(result.stdout)
        self.assertEqual(figures["model"], "thin-prism-fisheye")
        self.assertEqual(figures["num_unrepresentable_points"], 0)
        # The lens has bumps of up to 1.5 px.
        self.assertLess(0.1, figures["rms_px"])
        self.assertLess(figures["rms_px"], 0.7)
        self.assertLess(figures["rms_px"], figures["max_px"])
        compared = self.succeed("compare", self.path("out/camera.yaml"), self.path("fitted.yaml"), "--json")
        # compare takes the best rotation out, fit only one that is worth it.
        compared_px = json.loads(compared.stdout)["rms_px"]
        self.assertLessEqual(compared_px, figures["rms_px"])
        self.assertGreater(compared_px, 0.98 * figures["rms_px"])

    def test_fit_follows_every_bump_with_a_spline(self):
        def fit(*words, code=0):
            result = run("fit", self.path("out/camera.yaml"), "--model", *words, "-o",
                         self.path("spline.yaml"))
            self.assertEqual(result.returncode, code, result.stderr)
            return result
        result = fit("splined-stereographic")
        self.assertIn("control points over", result.stdout)
        self.assertIn("in the valid region: RMS 0.00", result.stdout)
        figures = json.loads(fit("splined-stereographic", "--json").stdout)
        self.assertLess(figures["valid_region"]["rms_px"], 0.005)
        self.assertEqual(figures["num_unrepresentable_points"], 0)
        fit("splined-stereographic", "--spline", "20x16,fov=100")
        self.assertIn(b"fov_x_deg: 100", read(self.path("spline.yaml")))
        for words in ("20", "3x20", "20x999", "20x16,fov=0", "20x16,fov=360", "20x16,90"):
            self.assertIn(words, fit("splined-stereographic", "--spline", words, code=1).stderr)
        self.assertIn("--spline", fit("opencv", "--spline", "20x16", code=1).stderr)

    def test_fit_names_the_models_that_there_are(self):
        result = run("fit", self.path("out/camera.yaml"), "--model", "pinhole", "-o",
                     self.path("none.yaml"))
        self.assertEqual(result.returncode, 1)
        self.assertIn("central-radial", result.stderr)
        self.assertFalse(os.path.exists(self.path("none.yaml")))

    def test_compare_needs_cameras_of_one_size(self):
        other = read(self.path("out/camera.yaml")).replace(b"[640, 480]", b"[1280, 960]")
        # Keys about places in the image, which would lie outside, are left out.
        other = re.sub(rb"(?ms)^(uncertainty|trusted):.*?(?=^\S|\Z)", b"", other)
        write(self.path("other.yaml"), other)
        result = run("compare", self.path("out/camera.yaml"), self.path("other.yaml"))
        self.assertEqual(result.returncode, 2)
        self.assertIn("640 x 480", result.stderr)

    def test_evaluate_agrees_with_training(self):
        result = self.succeed("evaluate", self.path("out/camera.yaml"), "--features",
                              self.path("sim/features.csv"), "--pattern", self.path("out/pattern.yaml"),
                              "--json")
        evaluated = json.loads(result.stdout)
        trained = json.loads(read(self.path("out/result.json")))["training"]
        self.assertAlmostEqual(evaluated["rms_px"], trained["rms_px"], delta=0.002)

    def test_blob_and_camera_unproject_alike_and_project_back(self):
        pixels = [(x, y) for x in range(0, 640, 53) for y in range(0, 480, 47)]
        path = write(self.path("px.csv"), "x,y\n" + "\n".join(f"{x},{y}" for x, y in pixels))
        exact = rows(run("unproject", self.path("out/camera.yaml"), "--pixels", path).stdout)
        fixed = rows(run("unproject", self.path("out/camera.raygrid"), "--pixels", path).stdout)
        self.assertEqual(len(exact), len(pixels))
        inside = [(a, b) for a, b in zip(exact, fixed) if a["dx"]]
        self.assertGreater(len(inside), 100)
        for a, b in inside:
            for key in ("dx", "dy", "dz"):
                self.assertAlmostEqual(float(a[key]), float(b[key]), delta=1e-6)
        points = write(self.path("xyz.csv"), "x,y,z\n" + "\n".join(
            ",".join(str(2.5 * float(a[k])) for k in ("dx", "dy", "dz")) for a, _ in inside))
        back = rows(run("project", self.path("out/camera.yaml"), "--points", points).stdout)
        for (a, _), pixel in zip(inside, back):
            if pixel["valid"] == "1":
                self.assertAlmostEqual(float(pixel["u"]), float(a["x"]), delta=1e-5)
                self.assertAlmostEqual(float(pixel["v"]), float(a["y"]), delta=1e-5)

    def test_blobs_project_what_they_unproject_by_the_runtime(self):
        pixels = [(x, y) for x in range(0, 640, 53) for y in range(0, 480, 47)]
        path = write(self.path("px.csv"), "x,y\n" + "\n".join(f"{x},{y}" for x, y in pixels))
        blob = self.path("out/camera.raygrid")
        inside = [ray for ray in rows(run("unproject", blob, "--pixels", path).stdout) if ray["dx"]]
        points = write(self.path("xyz.csv"), "x,y,z\n0,0,-1\n" + "\n".join(
            ",".join(str(2.5 * float(ray[k])) for k in ("dx", "dy", "dz")) for ray in inside))
        back = rows(run("project", blob, "--points", points).stdout)
        self.assertEqual(back[0]["valid"], "0")
        for ray, pixel in zip(inside, back[1:]):
            self.assertEqual(pixel["valid"], "1")
            self.assertAlmostEqual(float(pixel["u"]), float(ray["x"]), delta=0.002)
            self.assertAlmostEqual(float(pixel["v"]), float(ray["y"]), delta=0.002)
            q16 = 65536 * float(pixel["u"])  # the runtime's own format
            self.assertAlmostEqual(q16, round(q16), delta=0.001)

    def test_blobs_with_several_remap_tables(self):
        blob = self.path("several.raygrid")
        packed = self.succeed("pack", self.path("out/camera.yaml"), "-o", blob, "--remap", "640x480",
                              "--remap", "320x200,hfov=30", "--json")
        tables = json.loads(packed.stdout)["remaps"]
        self.assertEqual([table["size"] for table in tables], [[640, 480], [320, 200]])
        for table in tables:
            self.assertLessEqual(table["error_px"], 0.05)
            self.assertGreater(table["chroma_error_px"], 0)
        facts = json.loads(run("inspect", blob, "--json").stdout)
        self.assertEqual([table["size"] for table in facts["remap_tables"]],
                         [[640, 480], [320, 200]])

    def test_independent_reader_agrees_with_the_runtime(self):
        blob = self.path("out/camera.raygrid")
        frame = write(self.path("frame.raw"), bytes(
            (3 * x + 5 * y + ((x // 7) ^ (y // 9)) * 11) & 255
            for y in range(480) for x in range(640)))
        self.succeed(blob, frame, self.path("c.raw"), program=programs.undistort)
        self.succeed(programs.reference, "remap", blob, frame, self.path("python.raw"),
                     program="python3")
        self.assertEqual(read(self.path("c.raw")), read(self.path("python.raw")))

    def test_frames_may_be_any_pgm_and_go_into_pipes(self):
        blob, pixels = self.path("out/camera.raygrid"), bytes(range(256)) * 1200
        raw = write(self.path("any.raw"), pixels)
        pgm = write(self.path("any.pgm"), b"P5 # grey\n640\t480 255\n" + pixels)
        expected = self.succeed(blob, raw, self.path("flat.raw"), program=programs.undistort)
        os.mkfifo(self.path("pipe"))
        with open(self.path("piped.raw"), "wb") as piped, \
                subprocess.Popen(["cat", self.path("pipe")], stdout=piped):
            result = run(blob, pgm, self.path("pipe"), program=programs.undistort)
        self.assert_done(result)
        self.assertEqual(read(self.path("piped.raw")), read(self.path("flat.raw")))
        self.assertEqual(result.stdout, expected.stdout)
        self.assertTrue(stat.S_ISFIFO(os.stat(self.path("pipe")).st_mode))
        os.symlink("flat.raw", self.path("link"))
        self.succeed(blob, pgm, self.path("link"), program=programs.undistort)
        self.assertTrue(os.path.islink(self.path("link")))
        for damaged in (b"P5 640 480 254\n" + pixels, b"P5 640 480 255\n" + pixels[:-1],
                        b"P5 640" + pixels):
            result = run(blob, write(self.path("bad.pgm"), damaged), self.path("none.raw"),
                         program=programs.undistort)
            self.assert_refused(result, 2)
            self.assertFalse(os.path.exists(self.path("none.raw")))

    def test_inspect_says_what_a_blob_holds(self):
        result = self.succeed("inspect", self.path("out/camera.raygrid"))
        for words in ("'front'", "'42'", "640 x 480", "packing error: max", "held out error"):
            self.assertIn(words, result.stdout)
        result = self.succeed("inspect", self.path("out/camera.raygrid"), "--json")
        facts = json.loads(result.stdout)
        self.assertEqual(facts["camera"], {"name": "front", "serial": "42",
                                           "image_size": [640, 480]})
        self.assertIn(facts["grid"]["bits"], (16, 32))
        self.assertRegex(facts["format_version"], r"^1\.\d$")
        self.assertTrue(facts["can_project"])
        self.assertEqual(facts["remap_tables"][0]["size"], [640, 480])
        result = run("inspect", self.path("out/camera.yaml"), "--json")
        self.assertEqual(json.loads(result.stdout)["model"], "central-generic")

    def test_inspect_leaves_out_what_a_blob_does_not_know(self):
        example = read(os.path.join(ROOT, "formats/vectors/example.raygrid"))
        unknown = 0xFFFFFFFF
        blob = dataclasses.replace(
            reference.parse(example), quality=reference.Quality(*[unknown] * 10),
            uncertainty=reference.Uncertainty(2, 3, (0xFFFF, 0xFFFF, 4096, 0xFFFF, 0xFFFF, 0xFFFF)))
        nothing_known = reference.serialize(blob)
        for name, data in (("example", example), ("unknown", nothing_known)):
            path = write(self.path(name + ".raygrid"), data)
            for options in ((), ("--json",)):
                result = self.succeed("inspect", path, *options)
                for sentinel in ("4294967295", "4294.96", "4.29", "65535", "15.9998", "nan", "null"):
                    self.assertNotIn(sentinel, result.stdout, name)
        facts = json.loads(run("inspect", self.path("unknown.raygrid"), "--json").stdout)
        self.assertEqual(facts["uncertainty"]["median_px"], 1)
        self.assertFalse({"training_error", "held_out_error", "packing_error"} & set(facts))

    def test_opencv_model_goes_the_same_way(self):
        self.succeed("calibrate", "--features", self.path("sim/features.csv"), "--image-size",
                     "640x480", "--pattern", self.path("sim/pattern.yaml"), "--model", "opencv",
                     "--skip-comparison", "-o", self.path("opencv"))
        self.succeed("inspect", self.path("opencv/camera.raygrid"))

    def test_calibrate_takes_images_of_several_modes(self):
        """Half of the images binned or cropped; the camera is as if none were."""
        board = "chessboard:9x6:45mm"
        self.succeed("simulate", "--render", "--images", 8, "--size", "320x240", "--lens",
                     "wide", "--pattern", board, "-o", self.path("seen"))
        for k in range(8):
            pixels = read_png(self.path(f"seen/sim{k:04d}.png"))[2]
            folder, shown, size = ("whole", pixels, (320, 240)) if k < 4 else (
                ("binned two by two: all of the sensor", self.binned(pixels), (160, 120))
                if k < 6 else
                ("part", [pixels[320 * y + x] for y in range(200) for x in range(20, 300)],
                 (280, 200)))
            write(self.path(f"{folder}/sim{k:04d}.png"), png(shown, size=size))
        folders = [self.path(folder) for folder in (
            "whole", "binned two by two: all of the sensor", "part")]
        common = ("--pattern", board, "--skip-comparison", "--model", "opencv", "--fix-target-geometry",
                  "--quiet", "-o", self.path("calibrated"))
        self.succeed("calibrate", *folders, "--mode", f"{folders[1]}/:bin=2", "--mode",
                     f"{folders[2]}:crop=20,0,280,200", *common)
        result = json.loads(read(self.path("calibrated/result.json")))
        self.assertEqual(result["image_size"], [320, 240])
        used = read(self.path("calibrated/poses.csv")).decode()
        for image in ("sim0001.png", "sim0005.png", "sim0007.png"):  # one of each mode
            self.assertIn(image, used)
        # What the report draws over images lies in calibrated pixels.
        shown = json.loads(read(self.path("calibrated/thumbnails.json")))["images"]
        self.assertEqual(sorted(shown), [f"sim{k:04d}.png" for k in range(4)])
        self.assertLess(result["training"]["median_px"], 0.1)
        # A mode that is told wrong does not fit.
        for mode, words in ((f"{folders[1]}:bin=3", ("160 x 120", "106 x 80")),
                            ("other:bin=2", ("other", "FOLDER:SETTINGS"))):
            result = run("calibrate", *folders[:2], "--mode", mode, *common)
            self.assertNotEqual(result.returncode, 0)
            for word in words:
                self.assertIn(word, result.stderr)

    @staticmethod
    def binned(pixels):
        return [sum(pixels[320 * (2 * y + j) + 2 * x + i] for j in (0, 1) for i in (0, 1)) // 4
                for y in range(120) for x in range(160)]

    def test_pattern_chessboard(self):
        self.succeed("pattern", "chessboard", "--columns", 9, "--rows", 6, "--square-mm", 25, "-o",
                     self.path("board"))
        self.assertEqual(read(self.path("board/pattern.pdf"))[:5], b"%PDF-")
        self.succeed("inspect", self.path("board/pattern.yaml"))

    def test_photographs(self):
        left = os.path.join(programs.photographs, "left")
        if not os.path.isdir(left):
            self.skipTest("no photographs; tools/fetch_photographs fetches them")
        pattern = write(self.path("photo_pattern.yaml"), PATTERN)
        self.succeed("detect", left, "--pattern", pattern, "-o", self.path("photo.csv"),
                     "--overlay", self.path("overlay"))
        self.assertEqual(len(rows(read(self.path("photo.csv")).decode())), 13 * 54)
        self.succeed("calibrate", left, "--pattern", pattern, "--hold-out",
                     "left04.jpg,left08.jpg,left13.jpg", "-o", self.path("photo"))
        figures = json.loads(read(self.path("photo/result.json")))
        self.assertLess(figures["held_out"]["median_px"], 0.15)
        result = self.succeed("undistort", self.path("photo/camera.raygrid"), left, "--json", "-o",
                              self.path("flat"))
        files = [one["file"] for one in json.loads(result.stdout)["images"]]
        self.assertEqual(sorted(files),
                         sorted(self.path("flat/" + name) for name in os.listdir(self.path("flat"))
                                if name != "view.camera.yaml"))
        self.assertEqual(len(files), 13)


class Claims(CommandTest):
    def test_check_claims_the_false_alarms_that_were_measured(self):
        root = os.path.join(os.path.dirname(programs.reference), "..")
        with open(os.path.join(root, "benchmarks/calibrator.csv"), encoding="utf-8", newline="") as file:
            alarms = {row["case"]: int(row["value"]) for row in csv.DictReader(file)
                      if row["quantity"] == "cameras of 1,000 that raise a false alarm"}
        measured = [alarms[f"{count} features an image"] for count in (240, 600)]
        page = os.path.join(os.path.dirname(programs.reference), "../tools/README.md")
        words = " ".join(read(page).decode().split())
        self.assertIn("{} to {} % in simulation".format(*(count / 10 for count in measured)), words)
        percent = float(re.search(r"false-alarm rate of `check` is below ([\d.]+) %", words).group(1))
        self.assertLess(max(measured), 10 * percent)


if __name__ == "__main__":
    main(__name__)
