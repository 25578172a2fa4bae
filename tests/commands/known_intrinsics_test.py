#!/usr/bin/env python3
"""calibrate --intrinsics: known cameras are copied, the relative pose has a covariance, and what is refused."""
import json
import math
import os

from command_test import CommandTest, SIMULATED_PATTERN, main, read, run, write

SIZE = ("--image-size", "160x120")


class KnownIntrinsics(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        result = run("simulate", "--lens", "pinhole", "--size", "160x120", "--cameras", 2, "--baseline-m", 0.08, "--images", 8,
                     "--pattern", write(cls.path("board.yaml"), SIMULATED_PATTERN), "-o", cls.path("sim"))
        assert result.returncode == 0, result.stderr
        cls.truth = cls.path("sim/true_camera.yaml")
        result = cls.calibrate(*cls.known("cam0", "cam1"), out="out")
        assert result.returncode == 0, result.stdout + result.stderr

    @classmethod
    def known(cls, *names):
        return [word for name in names for word in ("--intrinsics", f"{name}={cls.truth}")]

    @classmethod
    def calibrate(cls, *arguments, out="refused"):
        return run("calibrate", "--features", cls.path("sim/features.csv"), *SIZE, "--pattern",
                   cls.path("sim/pattern.yaml"), "--skip-comparison", *arguments, "-o", cls.path(out))

    def test_cameras_are_copied(self):
        result = json.loads(read(self.path("out/result.json")))
        for camera in result["cameras"]:
            folder = self.path("out/" + camera["name"])
            self.assertEqual(read(folder + "/camera.yaml"), read(self.truth))
            self.assertTrue({"camera.raygrid", "report.html"} < set(os.listdir(folder)))
            self.assertTrue(camera["known_intrinsics"])
            self.assertEqual(camera["parameters"], 0)
        self.assertLess(abs(result["training"]["rms_px"] - 0.05 * math.sqrt(2)), 0.01)
        self.assertLess(abs(result["held_out"]["rms_px"] - 0.05 * math.sqrt(2)), 0.02)
        self.assertIn("known", read(self.path("out/report.html")).decode())
        self.assert_done(run("report", self.path("out")))

    def test_the_relative_pose_has_a_covariance(self):
        pair = json.loads(read(self.path("out/result.json")))["baselines"][0]
        self.assertLess(abs(pair["distance_m"] - 0.08), 4 * pair["distance_sd_m"])
        self.assertLess(pair["distance_sd_m"], 1e-3)
        variance = sum(pair["covariance"][k][k] for k in range(3))
        self.assertAlmostEqual(pair["rotation_sd_rad"], math.sqrt(variance), delta=1e-9)
        rig = read(self.path("out/rig.yaml")).decode()
        self.assertIn('  - cameras: ["cam0", "cam1"]\n    covariance:\n      - [', rig)
        inspected = json.loads(run("inspect", self.path("out/rig.yaml"), "--json").stdout)["relative_poses"][0]
        result = run("rectify", self.path("out/rig.yaml"), "--left", "cam0", "--right", "cam1", "--max-error-px", 0.25,
                     "--json", "-o", self.path("pair"))
        self.assert_done(result)
        rectified = json.loads(result.stdout)
        for name, baseline in (("distance_sd_m", "baseline_sd_m"), ("rotation_sd_rad", "rotation_sd_rad")):
            for found in (inspected[name], rectified[baseline]):
                self.assertAlmostEqual(found / pair[name], 1, delta=1e-6)
        self.assertIn("baseline_sd: ", read(self.path("pair/rectified.yaml")).decode())
        broken = write(self.path("broken.yaml"), rig.replace("      - [", "      - [-1, ", 1))
        self.assert_refused(run("inspect", broken), 2, "broken.yaml", "6 rows of 6 numbers")

    def test_another_programs_camera_beside_one_that_is_calibrated(self):
        foreign = self.path("opencv.yaml")
        self.assert_done(run("export", self.truth, "--to", "opencv", "--max-fit-error-px", 1, "-o", foreign))
        result = self.calibrate("--intrinsics", f"cam1={foreign}", "--model", "opencv", out="mixed")
        self.assert_done(result)
        self.assertIn("cam1: opencv, known intrinsics", result.stdout)
        cameras = json.loads(read(self.path("mixed/result.json")))["cameras"]
        self.assertNotIn("known_intrinsics", cameras[0])
        self.assertGreater(cameras[0]["parameters"], 0)
        self.assertTrue(cameras[1]["known_intrinsics"])
        kept = [json.loads(run("inspect", path, "--json").stdout)["intrinsics"]
                for path in (foreign, self.path("mixed/cam1/camera.yaml"))]
        self.assertEqual(set(kept[0]), set(kept[1]))
        for name, value in kept[0].items():
            self.assertAlmostEqual(value, kept[1][name], delta=1e-9 * max(1, abs(value)))

    def test_cameras_back_to_back(self):
        """Each sees a board of its own, while the rig moves; a rig that only turns on the spot is refused."""
        pattern = write(self.path("boards.yaml"), "raygrid_pattern: 1\nboards:\n" + "".join(
            f"  - {{id: {i}, kind: chessboard, columns: 8, rows: 6, square_m: 0.03}}\n" for i in range(2)))

        def calibrate(features, out):
            return run("calibrate", "--features", features, *SIZE, "--pattern", pattern, *self.known("cam0", "cam1"),
                       "--hold-out", "sim0000.png", "--skip-comparison", "-o", self.path(out))

        self.assert_done(run("simulate", "--camera", self.truth, "--cameras", 2, "--baseline-m", 0.2, "--camera-turn-deg", 180,
                             "--fixed-boards", "--boards-around", "--images", 20, "--pattern", pattern, "-o", self.path("moving")))
        features = self.path("moving/features.csv")
        result = calibrate(features, "moving_out")
        self.assert_done(result)
        self.assertIn("boards that no camera observes together are assumed to be fixed", result.stdout)
        result = json.loads(read(self.path("moving_out/result.json")))
        pair = result["baselines"][0]
        self.assertLess(abs(pair["distance_m"] - 0.2), 4 * pair["distance_sd_m"])
        self.assertLess(abs(pair["angle_rad"] - math.pi), 4 * pair["rotation_sd_rad"])
        self.assertLess(pair["rotation_sd_rad"], 3e-3)
        self.assertEqual([body["boards"] for body in result["rigid_targets"]], [[0, 1]])
        # Each camera sees its board in the same place in all frames.
        header, *lines = read(features).decode().splitlines()
        seen = {camera: [line.split(",", 2)[2] for line in lines if line.startswith(camera + ",sim0001.png")]
                for camera in ("cam0", "cam1")}
        still = "\n".join([header] + [f"{camera},sim{k:04d}.png,{rest[:-1]}{k % 10}" for k in range(9) for camera in seen
                                      for rest in seen[camera]])
        self.assert_refused(calibrate(write(self.path("still.csv"), still), "refused"), 4, "{cam0}, {cam1}", "does not rotate")
        self.assert_nothing_in(self.path("refused"))

    def test_what_is_refused(self):
        both = self.known("cam0", "cam1")
        self.assert_done(run("pack", self.truth, "-o", self.path("blob.raygrid")))
        for arguments, code, words in (
                (self.known("left"), 1, ("left", "cam0, cam1")),
                (["--intrinsics", self.truth], 1, ("expected NAME=FILE",)),
                (self.known("cam0", "cam0"), 1, ("duplicate",)),
                (["--intrinsics", "cam0=" + self.path("none.yaml")], 2, ("none.yaml",)),
                (["--intrinsics", "cam0=" + self.path("blob.raygrid")], 1, ("is a blob",)),
                (["--intrinsics", "cam0=" + self.path("sim/features.csv")], 2, ("features.csv",)),
                (["--intrinsics", "cam0=" + self.simulated_camera("pinhole", "128x96")], 1, ("cam0", "128 x 96", "160 x 120")),
                (both + ["--model", "opencv"], 1, ("--model", "no effect")),
                (both + ["--knot-spacing-px", 40], 1, ("--knot-spacing-px", "no effect"))):
            self.assert_refused(self.calibrate(*arguments), code, *words)
            self.assert_nothing_in(self.path("refused"))
        self.assert_refused(run("calibrate", self.path("sim"), "--pattern", self.path("sim/pattern.yaml"),
                                "--intrinsics", "cam0=" + self.truth, "-o", self.path("refused")), 1,
                            "localize --refine-target")
        known = self.path("out/cam0/camera.yaml")
        before = read(known)
        self.assert_refused(self.calibrate("--intrinsics", "cam0=" + known, out="out"), 7, "camera.yaml")
        self.assertEqual(read(known), before)


if __name__ == "__main__":
    main(__name__)
