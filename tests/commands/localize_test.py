#!/usr/bin/env python3
"""localize: poses, their covariances, and what is refused."""
import csv
import json
import math
import os
import re

from command_test import CommandTest, SIMULATED_PATTERN, main, read, run, write

FILES = {"poses.csv", "residuals.csv"}
AXES = ("rx", "ry", "rz", "tx", "ty", "tz")


def rows(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def position(row):
    return [float(row[key]) for key in ("tx", "ty", "tz")]


class Localize(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.pattern = write(cls.path("board.yaml"), SIMULATED_PATTERN)
        for name, options in (("one", ["--lens", "wide", "--size", "320x240", "--images", 12]),
                              ("two", ["--lens", "pinhole", "--cameras", 2, "--baseline-m", 0.1, "--images", 8])):
            result = run("simulate", *options, "--pattern", cls.pattern, "-o", cls.path(name))
            assert result.returncode == 0, result.stderr
        cls.camera, cls.features = cls.path("one/true_camera.yaml"), cls.path("one/features.csv")

    def localize(self, camera, *arguments, out):
        return run("localize", camera, *arguments, "--pattern", self.pattern, "-o", self.path(out))

    def assert_near_truth(self, poses, truth):
        """Within 5 standard deviations."""
        true = {row["image"]: row for row in truth}
        for row in poses:
            self.assertEqual(row["board"], "0")
            for axis in AXES[3:]:
                error = abs(float(row[axis]) - float(true[row["image"]][axis]))
                self.assertLess(error, 5 * math.sqrt(float(row[f"cov_{axis}_{axis}"])))

    def test_poses_are_those_of_the_simulation(self):
        result = self.localize(self.camera, "--features", self.features, "--json", out="poses")
        self.assert_done(result)
        summary = json.loads(result.stdout)
        self.assertEqual(set(os.listdir(self.path("poses"))), FILES)
        poses = rows(self.path("poses/poses.csv"))
        self.assertEqual((summary["num_poses"], summary["num_frames"], len(poses)), (12, 12, 12))
        self.assertEqual([key for key in poses[0] if key.startswith("cov_")],
                         [f"cov_{a}_{b}" for k, a in enumerate(AXES) for b in AXES[k:]])
        self.assert_near_truth(poses, rows(self.path("one/true_poses.csv")))
        self.assertNotIn("intrinsics", result.stderr)
        self.assertLess(summary["translation_sd_m"], 0.002)
        evaluated = json.loads(run("evaluate", self.camera, "--features", self.features, "--pattern", self.pattern,
                                   "--json").stdout)
        for key in ("median_px", "rms_px", "max_px", "count"):
            self.assertEqual(summary[key], evaluated[key])
        self.assertEqual(len(rows(self.path("poses/residuals.csv"))), summary["count"])

    def test_wrong_intrinsics_are_reported(self):
        fitted = self.path("fitted.yaml")
        self.assert_done(run("fit", self.camera, "--model", "opencv", "-o", fitted))
        text = re.sub(r"\bk1: (\S+)", lambda found: f"k1: {float(found[1]) + 0.01}", read(fitted).decode())
        wrong = write(self.path("wrong.yaml"), text)
        result = self.localize(wrong, "--features", self.features, out="wrong")
        self.assert_done(result)
        self.assertRegex(result.stderr, r"the intrinsics do not fit these images")

    def test_poses_are_exported_as_a_trajectory(self):
        self.assert_done(self.localize(self.camera, "--features", self.features, out="walk"))
        self.assert_done(run("export", self.path("walk/poses.csv"), "--to", "tum", "-o", self.path("walk.txt")))
        lines = [line for line in read(self.path("walk.txt")).decode().splitlines() if line[0] != "#"]
        self.assertEqual(len(lines), 12)

    def test_a_blob_has_the_poses_of_its_camera(self):
        blob = self.path("one.raygrid")
        self.assert_done(run("pack", self.camera, "-o", blob))
        for camera, out in ((self.camera, "of_camera"), (blob, "of_blob")):
            self.assert_done(self.localize(camera, "--features", self.features, out=out))
        for a, b in zip(rows(self.path("of_camera/poses.csv")), rows(self.path("of_blob/poses.csv"))):
            self.assertLess(math.dist(position(a), position(b)), 1e-4)

    def test_a_rig_has_one_pose_per_frame(self):
        result = self.localize(self.path("two/true_rig.yaml"), "--features", self.path("two/features.csv"), "--json",
                               out="rig")
        self.assert_done(result)
        poses = rows(self.path("rig/poses.csv"))
        self.assertEqual({row["camera"] for row in poses}, {"cam0"})
        self.assertEqual(len({row["image"] for row in poses}), len(poses))
        truth = [row for row in rows(self.path("two/true_poses.csv")) if row["camera"] == "cam0"]
        shown = {row["image"] for row in truth}
        self.assert_near_truth([row for row in poses if row["image"] in shown], truth)
        self.assertEqual([camera["name"] for camera in json.loads(result.stdout)["cameras"]], ["cam0", "cam1"])
        self.assert_done(run("export", self.path("rig/poses.csv"), "--to", "tum", "-o", self.path("rig.txt")))

    def test_the_target_is_refined(self):
        folder = self.path("bent")
        self.assert_done(run("simulate", "--lens", "pinhole", "--images", 12, "--target-deformation-mm", 4, "--pattern",
                             self.pattern, "-o", folder))
        errors = []
        for options in ([], ["--refine-target"]):
            result = self.localize(folder + "/true_camera.yaml", "--features", folder + "/features.csv", "--json",
                                   *options, out="refined")
            self.assert_done(result)
            errors.append(json.loads(result.stdout)["rms_px"])
        self.assertLess(errors[1], 0.5 * errors[0])
        result = self.localize(folder + "/true_camera.yaml", "--features", folder + "/features.csv", out="refined")
        self.assertEqual(set(os.listdir(self.path("refined"))), FILES)  # nothing of the earlier one
        self.assertIn("median", result.stdout)

    def test_images(self):
        folder, pattern = self.path("photos"), "chessboard:13x10:30mm"  # without symmetry
        self.assert_done(run("simulate", "--render", "--lens", "pinhole", "--size", "320x240", "--images", 2,
                             "--samples-per-pixel", 2, "--pattern", pattern, "-o", folder))

        def localize(camera, out):
            return run("localize", camera, folder, "--pattern", pattern, "--json", "-o", out)

        result = localize(folder + "/true_camera.yaml", self.path("of_photos"))
        self.assert_done(result)
        self.assertEqual(set(os.listdir(self.path("of_photos"))), FILES | {"poses.png"})
        for row, true in zip(rows(self.path("of_photos/poses.csv")), rows(folder + "/true_poses.csv")):
            self.assertLess(math.dist(position(row), position(true)), 0.002)
        # Another sensor mode, and pictures among the images.
        self.assert_refused(localize(self.simulated_camera("pinhole"), self.path("size")), 2, "320 x 240", "160 x 120")
        self.assert_nothing_in(self.path("size"))
        self.assert_refused(localize(folder + "/true_camera.yaml", folder), 7, "use another output folder")

    def test_files_of_others_are_kept(self):
        features = ("--features", self.features)
        path = write(self.path("own/pattern.yaml"), "mine")
        self.assert_done(self.localize(self.camera, *features, out="own"))
        self.assertEqual(read(path), b"mine")
        write(self.path("result/result.json"), "{}")
        write(self.path("result/poses.csv"), "mine")
        self.assert_refused(self.localize(self.camera, *features, out="result"), 7, "contains a calibration")
        self.assertEqual(set(os.listdir(self.path("result"))), {"result.json", "poses.csv"})

    def test_bad_input(self):
        features = ("--features", self.features)

        def refused(code, *words, camera=self.camera, arguments=features, pattern=self.pattern):
            result = run("localize", camera, *arguments, "--pattern", pattern, "-o", self.path("refused"))
            self.assert_refused(result, code, *words)
            self.assertFalse(os.path.exists(self.path("refused")))

        refused(1, "exactly one", arguments=())
        refused(1, "exactly one", arguments=(*features, self.folder))
        refused(1, "is for a rig", arguments=("--camera", "a=" + self.folder))
        refused(1, "is a rig", camera=self.path("two/true_rig.yaml"), arguments=(self.folder,))
        refused(1, "no camera 'left'", camera=self.path("two/true_rig.yaml"),
                arguments=("--camera", "left=" + self.folder))
        refused(1, "--at", camera=self.path("two/true_rig.yaml"),
                arguments=("--features", self.path("two/features.csv"), "--at", "temperature=20"))
        refused(2, "missing.yaml", camera=self.path("missing.yaml"))
        refused(2, "missing.csv", arguments=("--features", self.path("missing.csv")))
        refused(2, "pattern", pattern="chessboard:6x5:30mm")
        refused(2, "outside the 160 x 120 image", camera=self.simulated_camera("pinhole"))
        refused(2, "several cameras", arguments=("--features", self.path("two/features.csv")))
        header, *lines = read(self.features).decode().splitlines()
        few = write(self.path("few.csv"), "\n".join([header] + lines[:5]) + "\n")
        refused(3, "no pose", arguments=("--features", few))
        refused(3, "at least 3 poses", arguments=("--features", few, "--refine-target"))
        self.assert_refused(run("localize", self.camera, *features, "--pattern", self.pattern, "-o", self.path("one/x"),
                                "--sync-by", "time"), 1, "--sync-by")


if __name__ == "__main__":
    main(__name__)
