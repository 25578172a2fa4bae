#!/usr/bin/env python3
"""hand-eye: the camera's pose on a robot, from files of several kinds, and what is refused."""
import csv
import json
import math
import os
import random
import shutil

from command_test import CommandTest, SIMULATED_PATTERN, main, read, run, write

FILES = {"hand_eye.yaml", "hand_eye_residuals.csv"}
SIGMA_M, SIGMA_RAD = 2e-4, 5e-4
# Quaternions are w, x, y, z; poses are pairs of a quaternion and a translation.
MOUNT = ((0.5, 0.5, -0.5, 0.5), (0.02, -0.05, 0.08))
ANCHOR = ((0.6, 0, 0.8, 0), (0.5, 0.3, -0.2))


def product(a, b):
    return (a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0])


def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def rotated(q, v):
    return product(product(q, (0, *v)), conjugate(q))[1:]


def chain(a, b):
    return product(a[0], b[0]), tuple(x + y for x, y in zip(rotated(a[0], b[1]), a[1]))


def inverse(a):
    back = conjugate(a[0])
    return back, tuple(-x for x in rotated(back, a[1]))


def rows(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def tum(poses, unit=1.0):
    return "".join(f"{name} " + " ".join(f"{x / unit:.9f}" for x in t) + f" {q[1]:.9f} {q[2]:.9f} {q[3]:.9f} {q[0]:.9f}\n"
                   for name, (q, t) in poses.items())


class HandEye(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.pattern = write(cls.path("board.yaml"), SIMULATED_PATTERN)
        result = run("simulate", "--lens", "pinhole", "--size", "320x240", "--images", 15, "--noise-px", 0.05, "--pattern",
                     cls.pattern, "-o", cls.path("sim"))
        assert result.returncode == 0, result.stderr
        cls.features = cls.path("sim/features.csv")
        result = run("localize", cls.path("sim/true_camera.yaml"), "--features", cls.features, "--pattern", cls.pattern,
                     "-o", cls.path("poses"))
        assert result.returncode == 0, result.stderr
        generator = random.Random(1)
        cls.robot = {}
        for row in rows(cls.path("sim/true_poses.csv")):
            target = (tuple(float(row[k]) for k in ("qw", "qx", "qy", "qz")),
                      tuple(float(row[k]) for k in ("tx", "ty", "tz")))
            q, t = inverse(chain(chain(inverse(MOUNT), target), inverse(ANCHOR)))
            turn = (1, *(generator.gauss(0, SIGMA_RAD / 2) for _ in range(3)))
            q = product(tuple(x / math.hypot(*turn) for x in turn), q)
            cls.robot[row["image"]] = (q, tuple(x + generator.gauss(0, SIGMA_M) for x in t))
        cls.tum = write(cls.path("robot.txt"), tum(cls.robot))

    def hand_eye(self, *arguments, result="poses", robot=None, out="out"):
        return run("hand-eye", self.path(result), "--robot", robot or self.tum, "-o", self.path(out), *arguments)

    def assert_truth(self, result, truth=(MOUNT, inverse(MOUNT), ANCHOR)):
        """Within 5 standard deviations, which are small."""
        self.assert_done(result)
        found = json.loads(result.stdout)
        for transform, true in zip(found["transforms"], truth):
            t = [transform["translation"][k] for k in "xyz"]
            q = [transform["rotation"][k] for k in "wxyz"]
            self.assertLess(math.dist(t, true[1]), 5 * transform["translation_sd_m"])
            self.assertLess(transform["translation_sd_m"], 2e-3)
            turn = 2 * math.acos(min(1, abs(sum(a * b for a, b in zip(q, true[0])))))
            self.assertLess(turn, 5 * transform["rotation_sd_rad"])
        return found

    def test_the_camera_s_pose_is_that_of_the_simulation(self):
        found = self.assert_truth(self.hand_eye("--json"))
        self.assertEqual([t["name"] for t in found["transforms"]],
                         ["camera_from_gripper", "gripper_from_camera", "base_from_target"])
        self.assertEqual((found["num_poses"], found["num_used"], found["rejected_images"]), (15, 15, []))
        self.assertEqual(set(os.listdir(self.path("out"))), FILES)
        self.assertEqual(found["held_out"]["count"], 15)
        self.assertGreater(found["held_out"]["translation_m"], found["residual"]["translation_m"])
        self.assertLess(found["robot_sigma_m"], 3 * SIGMA_M)
        self.assertEqual(len(rows(self.path("out/hand_eye_residuals.csv"))), 15)
        text = read(self.path("out/hand_eye.yaml")).decode()
        self.assertIn("camera_from_gripper:\n  rotation: {w: ", text)
        self.assertTrue(text.endswith("raygrid_hand_eye: 1\n"))
        printed = self.hand_eye("--robot-sigma-mm", 0.2, "--robot-sigma-deg", 0.03)
        self.assert_done(printed)
        self.assertIn("best additional pose", printed.stdout)
        first = read(self.path("out/hand_eye.yaml"))
        self.assert_done(self.hand_eye("--robot-sigma-mm", 0.2, "--robot-sigma-deg", 0.03, "--threads", 1))
        self.assertEqual(read(self.path("out/hand_eye.yaml")), first)

    def test_results_of_calibrate_are_localized(self):
        for name, copy in (("sim/true_camera.yaml", "camera.yaml"), ("sim/features.csv", "features.csv"),
                           ("board.yaml", "pattern.yaml")):
            shutil.copy(self.path(name), os.path.dirname(write(self.path("result/" + copy), "")) + "/" + copy)
        of_poses, of_features = (self.assert_truth(self.hand_eye("--json", result=result)) for result in ("poses", "result"))
        for a, b in zip(of_poses["transforms"], of_features["transforms"]):  # poses.csv is rounded
            for axis in "xyz":
                self.assertAlmostEqual(a["translation"][axis], b["translation"][axis], places=7)

    def test_the_rig_frame_may_differ_from_the_first_camera_s(self):
        self.folder_of_rig("rig", ((0.6, 0, 0.8, 0), (0.2, -0.1, 0.3)))
        self.assert_truth(self.hand_eye("--json", result="rig"))

    def folder_of_rig(self, folder, camera_from_rig):
        """A result of calibrate for a rig of one camera."""
        (w, x, y, z), t = camera_from_rig
        write(self.path(folder + "/rig.yaml"),
              'raygrid_rig: 1\ncameras:\n  "front":\n    file: "camera.yaml"\n    camera_from_rig:\n'
              f"      rotation: {{w: {w}, x: {x}, y: {y}, z: {z}}}\n      translation: {{x: {t[0]}, y: {t[1]}, z: {t[2]}}}\n")
        shutil.copy(self.path("sim/true_camera.yaml"), self.path(folder + "/camera.yaml"))
        shutil.copy(self.pattern, self.path(folder + "/pattern.yaml"))
        header, *lines = read(self.features).decode().splitlines()
        write(self.path(folder + "/features.csv"), "\n".join(["camera," + header] + ["front," + line for line in lines]) + "\n")

    def test_other_conventions(self):
        inverted = {name: inverse(pose) for name, pose in self.robot.items()}
        path = write(self.path("inverted.txt"), tum(inverted, 1e-3))
        self.assert_truth(self.hand_eye("--json", "--robot-convention", "gripper_from_base", "--robot-unit", "mm", robot=path))
        found = self.assert_truth(self.hand_eye("--json", "--robot-unit", "mm", "--eye-to-hand", robot=path))
        self.assertEqual([t["name"] for t in found["transforms"]],
                         ["camera_from_base", "base_from_camera", "gripper_from_target"])
        # Pairs of images and times, and of ROS's columns.
        table = "header.stamp.sec,header.stamp.nanosec,pose.position.x,pose.position.y,pose.position.z,pose.orientation.x," \
                "pose.orientation.y,pose.orientation.z,pose.orientation.w\n"
        times = "image,time_s\n"
        for k, (name, (q, t)) in enumerate(self.robot.items()):
            table += ",".join(map(str, (1700000000 + k, 5000000, *t, *q[1:], q[0]))) + "\n"
            times += f"{name},{1700000000 + k}.01\n"
        self.assert_truth(self.hand_eye("--json", "--image-times", write(self.path("times.csv"), times),
                                        robot=write(self.path("ros.csv"), table)))

    def test_swapped_rows_are_named(self):
        names = list(self.robot)
        swapped = dict(self.robot)
        swapped[names[3]], swapped[names[8]] = self.robot[names[8]], self.robot[names[3]]
        del swapped[names[0]]
        found = self.assert_truth(self.hand_eye("--json", robot=write(self.path("swapped.txt"), tum(swapped))))
        rejected = {row["image"]: row["reason"] for row in found["rejected_images"]}
        self.assertEqual(set(rejected), {names[0], names[3], names[8]})
        self.assertIn(f"swapped with that of {names[8]}", rejected[names[3]])
        self.assertIn("no robot pose", rejected[names[0]])
        self.assertIn("1 of 15 images", found["warnings"][0])

    def test_bad_input(self):
        lines = read(self.tum).decode().splitlines()

        def refused(code, *words, text=None, arguments=(), result="poses"):
            path = write(self.path("bad.txt"), text) if text is not None else self.tum
            self.assert_refused(self.hand_eye(*arguments, robot=path, result=result, out="refused"), code, *words)
            self.assertFalse(os.path.exists(self.path("refused")))

        refused(2, "missing", result="missing")
        os.makedirs(self.path("empty"))
        refused(2, "neither poses.csv", result="empty")
        refused(2, "with covariances", result="sim/true_poses.csv")
        refused(2, "--robot-unit mm", text=tum(self.robot, 1e-3))
        refused(2, "--robot-unit m,", arguments=("--robot-unit", "mm"))
        refused(4, "inverted", text=tum({name: inverse(pose) for name, pose in self.robot.items()}))
        refused(4, "inverted", "--eye-in-hand", arguments=("--eye-to-hand",))
        refused(2, "line 1", "quaternion", text=" ".join([*lines[0].split()[:7], "3"]))
        refused(2, "neither the name of an image", text="\n".join("x" + line for line in lines))
        refused(2, "14 poses without names", "15 images", text="\n".join(line.split(" ", 1)[1] for line in lines[1:]))
        refused(3, "2 of at least 3", text="\n".join(lines[:2]))
        refused(2, "bad.txt", text="\0")
        refused(1, "--board 7", arguments=("--board", 7))
        refused(1, "--robot-unit", arguments=("--robot-unit", "inch"))
        refused(1, "--eye-in-hand", arguments=("--eye-in-hand", "--eye-to-hand"))
        for axes, words in (((), "does not rotate"), ((1,), "about one axis only")):
            poses = {name: ((math.cos(k / 9 * len(axes)), math.sin(k / 9 * len(axes)), 0, 0), t)
                     for k, (name, (_, t)) in enumerate(self.robot.items())}
            refused(4, words, text=tum(poses))
        path = write(self.path("own/hand_eye.yaml"), tum(self.robot))
        self.assert_refused(self.hand_eye(robot=path, out="own"), 7, "hand_eye.yaml")
        self.assertEqual(read(path).decode(), tum(self.robot))


if __name__ == "__main__":
    main(__name__)
