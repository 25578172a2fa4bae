#!/usr/bin/env python3
"""Rigs: from features or photographs to rig.yaml, and what is refused."""
import json
import math
import os

from command_test import (CommandTest, PATTERN, SIMULATED_PATTERN, main, programs, read, run,
                          write)

SHARED = ("rig.yaml", "pattern.yaml", "features.csv", "poses.csv", "residuals.csv", "result.json",
          "report.html")
OWN = ("camera.yaml", "camera.raygrid", "report.html", "uncertainty.png",
       "view.camera.yaml")


class Rig(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        result = run("simulate", "--lens", "pinhole", "--cameras", 2, "--baseline-m", 0.08,
                     "--images", 9, "--pattern",
                     write(cls.path("board.yaml"), SIMULATED_PATTERN), "-o", cls.path("sim"))
        assert result.returncode == 0, result.stderr
        cls.pattern = cls.path("sim/pattern.yaml")
        result = cls.calibrate(cls.path("sim/features.csv"), "--image-size", "640x480",
                               out="out")
        assert result.returncode == 0, result.stderr

    @classmethod
    def calibrate(cls, features, *arguments, out="refused"):
        return run("calibrate", "--features", features, *arguments, "--pattern", cls.pattern,
                   "--model", "opencv", "--skip-comparison", "-o", cls.path(out))

    def test_writes_each_cameras_files_and_the_shared_ones(self):
        self.assertEqual(set(os.listdir(self.path("out"))), {*SHARED, "cam0", "cam1"})
        for name in ("cam0", "cam1"):
            self.assertEqual(set(os.listdir(self.path("out/" + name))), set(OWN))
        result = json.loads(read(self.path("out/result.json")))
        self.assertEqual([camera["name"] for camera in result["cameras"]], ["cam0", "cam1"])
        self.assertLess(abs(result["training"]["rms_px"] - 0.05 * math.sqrt(2)), 0.02)
        baseline = result["baselines"][0]
        self.assertLess(abs(baseline["distance_m"] - 0.08), 4 * baseline["distance_sd_m"] + 1e-5)
        self.assertLess(baseline["distance_sd_m"], 0.001)

    def test_same_output_with_any_number_of_threads(self):
        for threads in (1, 2):
            self.assert_done(self.calibrate(self.path("sim/features.csv"), "--image-size",
                                            "640x480", "--threads", threads, out="again"))
            for name in [n for n in SHARED if n != "result.json"] + [
                    f"cam{c}/{n}" for c in (0, 1) for n in OWN]:
                self.assertEqual(read(self.path("again/" + name)), read(self.path("out/" + name)),
                                 name)

    def test_features_that_were_written_calibrate_again(self):
        result = self.calibrate(self.path("out/features.csv"), "--image-size", "100x100",
                                "--image-size", "cam0=640x480", "--image-size", "cam1=640x480",
                                out="second")
        self.assert_done(result)

    def test_evaluate_finds_the_rigs_error(self):
        result = run("evaluate", self.path("out/rig.yaml"), "--features",
                     self.path("out/features.csv"), "--pattern", self.path("out/pattern.yaml"),
                     "--json")
        self.assert_done(result)
        evaluated = json.loads(result.stdout)
        trained = json.loads(read(self.path("out/result.json")))["training"]
        self.assertAlmostEqual(evaluated["rms_px"], trained["rms_px"], delta=0.002)
        self.assertEqual(len(evaluated["cameras"]), 2)

    def test_inspect_says_what_a_rig_holds(self):
        result = run("inspect", self.path("out/rig.yaml"))
        self.assert_done(result)
        self.assertIn("cam1", result.stdout)

    def test_truth_is_a_rig(self):
        self.assert_done(run("evaluate", self.path("sim/true_rig.yaml"), "--features",
                             self.path("sim/features.csv"), "--pattern", self.pattern))

    def edited(self, edit):
        lines = read(self.path("sim/features.csv")).decode().splitlines()
        return write(self.path("edited.csv"), "\n".join(
            [lines[0]] + [edited for line in lines[1:] if (edited := edit(line))]) + "\n")

    def test_cameras_without_a_common_instant(self):
        features = self.edited(lambda line: line.replace("cam1,sim", "cam1,other"))
        self.assert_refused(self.calibrate(features, "--image-size", "640x480"), 4,
                            "{cam0}, {cam1}", "--sync-by")
        # Their numbers are still alike.
        self.assert_done(self.calibrate(features, "--image-size", "640x480", "--sync-by",
                                        "number", out="numbered"))
        self.assertIn(b"cam1,3,", read(self.path("numbered/features.csv")))

    def test_camera_with_too_few_images(self):
        features = self.edited(
            lambda line: line if "cam0" in line or "sim0000" in line or "sim0002" in line else "")
        self.assert_refused(self.calibrate(features, "--image-size", "640x480"), 3, "cam1")

    def test_image_size_that_is_missing_or_of_no_camera(self):
        features = self.path("sim/features.csv")
        self.assert_refused(self.calibrate(features), 1, "--image-size", "cam0")
        self.assert_refused(self.calibrate(features, "--image-size", "cam0=640x480"), 1, "cam1")
        self.assert_refused(self.calibrate(features, "--image-size", "cam7=640x480",
                                           "--image-size", "640x480"), 1, "cam7")

    def test_wrong_cameras(self):
        def refused(*arguments):
            return run("calibrate", *arguments, "--pattern", self.pattern, "-o",
                       self.path("refused"))
        folder = self.folder
        self.assert_refused(refused("--camera", f"a={folder}", "--camera", f"a={folder}"), 1,
                            "duplicate camera name")
        self.assert_refused(refused("--camera", f"a={folder}"), 1, "two cameras")
        self.assert_refused(refused("--camera", folder, "--camera", f"b={folder}"), 1, "NAME=")
        self.assert_refused(refused("--camera", f"../x={folder}", "--camera", f"b={folder}"), 1,
                            "'../x'")
        self.assert_refused(refused("--camera", f"a={folder}", "--camera", f"b={folder}",
                                    folder), 1, "--camera")
        self.assert_refused(refused("--camera", f"a={self.path('nowhere')}", "--camera",
                                    f"b={self.path('nowhere')}"), 2, "nowhere")

    def test_images_of_one_camera_as_two(self):
        lines = read(self.path("sim/features.csv")).decode().splitlines()
        first = [line for line in lines if line.startswith("cam0,")]
        for twice in (first, [line for line in first if ",sim0003.png," in line.replace("cam0", "", 1)]):
            own = [line for line in lines if line.startswith("cam1,") and len(twice) < len(first)]
            copies = [line.replace("cam0,", "cam1,").replace("sim0003", "copied") for line in twice]
            text = "\n".join(lines[:1] + first + own + copies) + "\n"
            features = write(self.path(f"twice{len(twice)}.csv"), text.encode())
            self.assert_refused(self.calibrate(features, "--image-size", "640x480"), 2, "'cam0'", "'cam1'",
                                "share an image")

    def test_features_of_a_camera_that_is_not_in_the_rig(self):
        features = self.edited(lambda line: line.replace("cam1,", "front,"))
        self.assert_refused(run("evaluate", self.path("out/rig.yaml"), "--features", features,
                                "--pattern", self.pattern), 2, "front")

    def test_photographs(self):
        folders = [os.path.join(programs.photographs, side) for side in ("left", "right")]
        if not all(map(os.path.isdir, folders)):
            self.skipTest("no photographs; tools/fetch_photographs fetches them")
        pattern = write(self.path("photo_pattern.yaml"), PATTERN)
        arguments = ("calibrate", "--camera", "left=" + folders[0], "--camera",
                     "right=" + folders[1], "--pattern", pattern)
        self.assert_refused(run(*arguments, "-o", self.path("photo")), 4, "--sync-by number")
        self.assert_done(run(*arguments, "--sync-by", "number", "--model", "opencv",
                             "--hold-out", "4,8,13", "-o", self.path("photo")))
        result = json.loads(read(self.path("photo/result.json")))
        self.assertEqual(result["baselines"][0]["common_views"], 10)
        self.assertLess(result["held_out"]["median_px"], 0.25)
        # A pair of them is rectified.
        pair = result["rectified_pair"]
        self.assertEqual((pair["left"], pair["right"], pair["count"]), ("left", "right", 540))
        self.assertLess(pair["rms_px"], 0.3)
        report = read(self.path("photo/report.html")).decode()
        self.assertIn("Rectified pair: left and right", report)
        for name in ("rectified_rows.png", "rectified_disparity.png"):
            self.assertGreater(len(read(self.path("photo/" + name))), 10000)
        self.assert_done(run("report", self.path("photo")))
        self.assertEqual(read(self.path("photo/report.html")).decode(), report)


if __name__ == "__main__":
    main(__name__)
