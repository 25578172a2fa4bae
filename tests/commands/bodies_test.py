#!/usr/bin/env python3
"""Boards that are fixed to each other: what calibrate makes of them, and what it tells."""
import json

from command_test import CommandTest, main, read, run, write

BOARDS = "raygrid_pattern: 1\nboards:\n" + "".join(
    "  - {id: %d, kind: chessboard, columns: 8, rows: 6, square_m: 0.025}\n" % i for i in range(3))
FAR_APART = ("--fixed-boards", "--board-gap-m", 0.25, "--no-common-boards", "--cameras", 2,
             "--baseline-m", 1, "--images", 60)


class Bodies(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.pattern = write(cls.path("boards.yaml"), BOARDS)
        cls.simulate("rig", *FAR_APART)
        result = cls.calibrate("rig", out="out")
        assert result.returncode == 0, result.stderr
        cls.said = result.stdout

    @classmethod
    def simulate(cls, folder, *options):
        result = run("simulate", "--lens", "pinhole", "--pattern", cls.pattern, *options,
                     "-o", cls.path(folder))
        assert result.returncode == 0, result.stderr

    @classmethod
    def calibrate(cls, folder, *options, out="refused"):
        return run("calibrate", "--features", cls.path(folder + "/features.csv"),
                   "--image-size", "640x480", "--pattern", cls.pattern, "--model", "opencv",
                   "--skip-comparison", "--hold-out", "sim0000.png", *options, "-o",
                   cls.path(out))

    def told(self, out):
        return json.loads(read(self.path(out + "/result.json")))

    def test_cameras_that_share_no_board_are_a_rig(self):
        result = self.told("out")
        self.assertEqual([body["boards"] for body in result["rigid_targets"]], [[0, 1, 2]])
        self.assertEqual({pair["rigid"] for pair in result["board_pairs"]}, {True})
        baseline = result["baselines"][0]
        self.assertLess(abs(baseline["distance_m"] - 1), 3 * baseline["distance_sd_m"])
        self.assertLess(baseline["distance_sd_m"], 0.001)

    def test_output_and_report_say_so(self):
        sentence = self.told("out")["rigid_target_summary"][0]
        self.assertTrue(sentence.startswith("boards 0, 1 and 2 are a rigid multi-board target"))
        self.assertIn(sentence, self.said)
        self.assertIn("--independent-boards", self.said)
        self.assertIn(sentence, read(self.path("out/report.html")).decode())

    def evaluated(self, *options):
        result = run("evaluate", *options)
        self.assert_done(result)
        return result.stdout

    def test_evaluate_localises_bodies(self):
        options = (self.path("out/rig.yaml"), "--features", self.path("out/features.csv"),
                   "--pattern", self.path("out/pattern.yaml"))
        said = self.evaluated(*options)
        self.assertTrue(said.startswith("poses estimated for boards 0, 1 and 2 as a rigid body ("), said)
        told = json.loads(self.evaluated(*options, "--json"))
        self.assertEqual(told["rigid_targets"], [[0, 1, 2]])
        self.assertAlmostEqual(told["rms_px"], self.told("out")["training"]["rms_px"], delta=0.001)
        # Each board has a pose of its own then, which takes up some of the noise.
        alone = self.evaluated(*options, "--independent-boards")
        self.assertTrue(alone.startswith("one pose estimated per board\n"), alone)
        alone = json.loads(self.evaluated(*options, "--independent-boards", "--json"))
        self.assertEqual(alone["rigid_targets"], [])
        self.assertLess(alone["rms_px"], 0.99 * told["rms_px"])
        # The poses are those of the first board.
        located = run("localize", *options, "-o", self.path("located"))
        self.assert_done(located)
        self.assertTrue(located.stdout.startswith("poses estimated for boards 0, 1 and 2 as a rigid body ("))
        header, *rows = read(self.path("located/poses.csv")).decode().splitlines()
        self.assertTrue(header.startswith("camera,image,board,"))
        self.assertEqual({tuple(row.split(",")[::2][:2]) for row in rows}, {("cam0", "0")})
        # A pattern that tells of no body.
        self.assertIn("one pose estimated per board\n",
                      self.evaluated(*options[:-1], self.pattern))
        self.assertIn("rigid_targets",
                      run("inspect", self.path("out/pattern.yaml"), "--json").stdout)

    def test_evaluate_a_camera_with_bodies(self):
        self.simulate("one", "--fixed-boards", "--board-gap-m", 0.05, "--images", 30)
        self.assert_done(self.calibrate("one", out="one_out"))
        options = (self.path("one_out/camera.yaml"), "--features",
                   self.path("one_out/features.csv"), "--pattern",
                   self.path("one_out/pattern.yaml"))
        alone, body = [line for line in self.evaluated(*options).splitlines()
                       if "deformation" not in line]
        self.assertTrue(alone.startswith("one pose per board: median "), alone)
        self.assertTrue(body.startswith("boards 0, 1 and 2 as a rigid body: median "), body)
        told = json.loads(self.evaluated(*options, "--json"))
        self.assertAlmostEqual(told["with_rigid_targets"]["rms_px"],
                               self.told("one_out")["training"]["rms_px"], delta=0.001)
        self.assertLess(told["rms_px"], told["with_rigid_targets"]["rms_px"])
        # Bodies that a pattern tells of are not those of another calibration.
        self.assertIn(b"board_bodies", read(options[-1]))
        self.assert_done(run("calibrate", *options[1:], "--image-size", "640x480", "--model",
                             "opencv", "--skip-comparison", "--hold-out", "sim0001.png",
                             "--independent-boards", "-o", self.path("moving")))
        self.assertNotIn(b"board_bodies", read(self.path("moving/pattern.yaml")))

    def test_option_forbids_it(self):
        result = self.calibrate("rig", "--independent-boards")
        self.assert_refused(result, 4, "not connected")
        self.assert_nothing_in(self.path("refused"))

    def test_same_output_with_any_number_of_threads(self):
        for threads in (1, 2):
            self.assert_done(self.calibrate("rig", "--threads", threads, out="again"))
            for name in ("rig.yaml", "poses.csv", "cam1/camera.yaml"):
                self.assertEqual(read(self.path("again/" + name)), read(self.path("out/" + name)),
                                 name)

    def test_a_board_that_was_moved_is_named(self):
        self.simulate("moved", "--fixed-boards", "--board-gap-m", 0.05, "--images", 40,
                      "--move-board-mm", 10)
        self.assert_done(self.calibrate("moved", out="moved_out"))
        result = self.told("moved_out")
        self.assertEqual([body["boards"] for body in result["rigid_targets"]], [[0, 1]])
        self.assertEqual({tuple(pair["boards"]) for pair in result["board_pairs"]
                          if not pair["rigid"]}, {(0, 2), (1, 2)})
        self.assertIn("move relative to each other", result["rigid_target_summary"][1])

    def test_the_cause_is_told_where_a_moved_board_leaves_cameras_apart(self):
        self.simulate("apart", *FAR_APART, "--move-board-mm", 50)
        text = read(self.path("apart/features.csv")).decode().splitlines()
        kept = [line for line in text if not (line.startswith("cam1") and
                                              line.split(",")[2] != "2")]
        write(self.path("apart/features.csv"), "\n".join(kept) + "\n")
        result = self.calibrate("apart")
        self.assert_refused(result, 4, "move")
        self.assert_nothing_in(self.path("refused"))


if __name__ == "__main__":
    main(__name__)
