#!/usr/bin/env python3
"""batch calibrates many units: one that fails stops no other, and a run that was killed goes on."""
import csv
import io
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import xml.dom.minidom

from batch_results import record_files, result_files, waits_for_a_lock
from command_test import HANG_S, CommandTest, SIMULATED_PATTERN, main, programs, read, run, wait_until, write

PLAN = """raygrid_batch: 1
pattern: board.yaml
model: opencv
skip_comparison: true
fix_target_geometry: true
image_size: [160, 120]
limits: {%s}
units:
"""
GOOD = ("A1", "A2", "A3")


class Batch(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        board = write(cls.path("board.yaml"), SIMULATED_PATTERN)
        for seed, serial in enumerate(GOOD):
            cls.succeed("simulate", "--images", 10, "--features-per-image", 60, "--pattern", board, "--seed", seed,
                        "--lens", "wide", "--size", "160x120", "-o", cls.path(serial))
        lines = read(cls.path("A1/features.csv")).decode().splitlines(keepends=True)
        few = [line for line in lines if line.startswith(("image,", "sim0000"))]
        write(cls.path("few/features.csv"), "".join(few))

    def plan(self, serials=GOOD, limits="", more=()):
        units = [f"  - {{serial: {serial}, features: {serial}/features.csv}}\n" for serial in serials]
        name = self.id().split(".")[-1] + ".yaml"
        return write(self.path(name), PLAN % limits + "".join([*units, *more]))

    def batch(self, plan, *more, output="", **options):
        self.out = self.path("out-" + self.id().split(".")[-1] + output)
        return run("batch", plan, "-o", self.out, *more, **options)

    def table(self):
        rows = csv.DictReader(io.StringIO(read(self.out + "/fleet.csv").decode()))
        return {row["serial"]: row for row in rows}

    def files(self):
        return result_files(self.out)

    def assert_same_files(self, files, expected):
        self.assertEqual(sorted(files), sorted(expected))
        for name, contents in expected.items():
            self.assertEqual(files[name], contents, name)

    def test_units_have_results_and_lines(self):
        result = self.batch(self.plan(), "--json")
        self.assert_done(result)
        told = json.loads(result.stdout)["units"]
        self.assertEqual([unit["serial"] for unit in told], list(GOOD))
        table = self.table()
        self.assertEqual(list(table), list(GOOD))
        for serial in GOOD:
            facts = json.loads(run("inspect", f"{self.out}/{serial}/camera.yaml", "--json").stdout)
            self.assertEqual(facts["camera"]["serial"], serial)
            row, lens = table[serial], facts["intrinsics"]
            self.assertAlmostEqual(float(row["focal_px"]), (lens["fx"] * lens["fy"]) ** 0.5, delta=1e-3)
            self.assertAlmostEqual(float(row["center_x_px"]), lens["cx"], delta=1e-6)
            self.assertAlmostEqual(float(row["held_out_median_px"]), facts["held_out_error"]["median_px"], delta=1e-6)
            self.assertGreater(float(row["elapsed_s"]), 0)

    def test_units_of_older_versions_are_not_calibrated_again(self):
        plan = self.plan(("A1",))
        self.assert_done(self.batch(plan))
        path = self.out + "/A1/unit.json"
        record = json.loads(read(path))
        record["inputs"] = record.pop("inputs_hash")
        del record["schema_version"]
        old = json.dumps(record).encode()
        write(path, old)
        os.utime(path, (0, 0))
        self.assert_done(self.batch(plan))
        self.assertEqual(read(path), old)

    def test_one_that_fails_is_named_and_stops_no_other(self):
        more = ["  - {serial: A0, features: few/features.csv}\n", "  - {serial: B0, images: gone/}\n"]
        result = self.batch(self.plan(("A3", "A1"), more=more))
        self.assertEqual(result.returncode, 3, result.stderr)
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 2, result.stderr)
        self.assertIn("A0: error: only 1 image with", lines[0])
        self.assertIn("B0: error", lines[1])
        self.assertIn("gone", lines[1])
        table = self.table()
        self.assertEqual([table[serial]["status"] for serial in ("A0", "A1", "A3", "B0")],
                         ["error", "warn", "warn", "error"])
        self.assertEqual(sorted(os.listdir(self.out)), [".batch.lock", "A0.failed.json", "A1", "A3", "B0.failed.json", "fleet.csv",
                                                         "fleet.html"])

    def test_conditions_and_rolling_shutters_are_passed_on(self):
        features, values, board = [], ["image,value"], self.path("board.yaml")
        for position in (0, 5, 10):
            folder = self.path("at%d" % position)
            self.succeed("simulate", "--lens", "focusing", "--at", position, "--pattern", board, "--images", 5,
                         "--size", "160x120", "--features-per-image", 40, "--noise-px", 0.03, "--seed", position + 1, "-o", folder)
            lines = read(folder + "/features.csv").decode().splitlines()
            features = features or lines[:1]
            features += ["%d_%s" % (position, line) for line in lines[1:]]
            values += ["%d_sim%04d.png,%d" % (position, i, position) for i in range(5)]
        write(self.path("focusing.csv"), "\n".join(features) + "\n")
        write(self.path("values.csv"), "\n".join(values) + "\n")
        plan = write(self.path("conditions.yaml"), f"""raygrid_batch: 1
pattern: {board}
skip_comparison: true
fix_target_geometry: true
image_size: [160, 120]
knot_spacing_px: 40
units:
  - {{serial: F1, features: focusing.csv, vary_with: lens_position, operating_points: values.csv}}
  - {{serial: R1, features: at0/features.csv, rolling_shutter: true, timestamps: gone.csv}}
""")
        result = self.batch(plan)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertRegex(result.stderr, "R1: error: .*gone.csv")
        self.assertIn("condition: lens_position", read(self.out + "/F1/camera.yaml").decode())
        done = read(self.out + "/F1/unit.json")
        self.batch(plan)
        self.assertEqual(read(self.out + "/F1/unit.json"), done)
        write(self.path("values.csv"), "\n".join(values).replace("10_sim0004.png,10", "10_sim0004.png,9.9") + "\n")
        self.batch(plan)
        self.assertNotEqual(read(self.out + "/F1/unit.json"), done)

    def test_bad_conditions_are_refused_in_one_line(self):
        for unit, told in (("vary_with: focus", "vary_with: unknown quantity 'focus'; expected lens_position, temperature"),
                           ("vary_with: [temperature, 3]", "vary_with: unknown quantity '3'"),
                           ("operating_points: v.csv", "unit C1: operating_points requires vary_with"),
                           ("vary_with: temperature", "unit C1: vary_with requires the operating point of each image"),
                           ("rolling_shutter: true", "unit C1: rolling_shutter requires the timestamp of each image"),
                           ("timestamps: t.csv", "unit C1: timestamps requires rolling_shutter: true"),
                           ("rolling_shutter: maybe", "key 'rolling_shutter': expected true or false"),
                           ("rolling_shutter: true, vary_with: temperature",
                            "unit C1: rolling_shutter and vary_with cannot be combined"),
                           ("like: a.yaml, prior: b.yaml", "duplicate key 'prior' (its former name counts as the same key)")):
            plan = self.plan((), more=[f"  - {{serial: C1, features: A1/features.csv, {unit}}}\n"])
            self.assert_refused(self.batch(plan), 2, told)
        for at, told in (("{a: far, 1: near}, vary_with: temperature", "unit C1: images_at: 'a' is not a number"),
                         ("{0: far, 1: near}, vary_with: [lens_position, temperature]",
                          "unit C1: images_at takes values of one quantity"),
                         ("{0: far, 1: near}", "unit C1: images_at requires vary_with"),
                         ("far", "key 'images_at': expected a mapping of folders")):
            plan = self.plan((), more=[f"  - {{serial: C1, images_at: {at}}}\n"])
            self.assert_refused(self.batch(plan), 2, told)

    def make_fleet(self):
        """A plan of units made of one: 24 of a family with a tilted sensor and a jump, a golden one again."""
        self.assert_done(self.batch(self.plan(("A1",))))
        lens = read(self.out + "/A1/camera.yaml").decode()
        random.seed(3)
        units = []

        def add(serial, changes, more):
            shutil.copytree(self.out + "/A1", f"{self.out}/{serial}")
            text = lens
            for name, change in changes.items():
                text = re.sub(rf"\b{name}: (\S+)",
                              lambda found, f=change: f"{found[0].split()[0]} {f(float(found[1])):.9f}", text)
            write(f"{self.out}/{serial}/camera.yaml", text)
            record_files(f"{self.out}/{serial}")
            units.append(f"  - {{serial: {serial}, features: A1/features.csv, {more}}}\n")
        for k in range(24):
            scale, (x, y) = 1 + 0.002 * random.gauss(0, 1) + (0.02 if k >= 14 else 0), random.choices(range(-9, 9), k=2)
            add(f"U{k:02d}", {"fx": lambda fx, by=scale: fx * by, "fy": lambda fy, by=scale: fy * by,
                              "cx": lambda cx, by=x: cx + by / 15, "cy": lambda cy, by=y: cy + by / 15,
                              "p1": lambda p1, by=0.01 if k == 8 else 0: p1 + by},
                "lens_batch: " + ("<old>" if k < 14 else "new") + (", operator: bob, station: s0" if k == 23 else ""))
        # The last one again.
        for k in range(1, 8):
            add(f"Z{k}", {"fx": lambda fx: fx * scale, "fy": lambda fy: fy * scale, "cy": lambda cy: cy + y / 15,
                          "cx": lambda cx, by=k % 2 + k // 4: cx + x / 15 + 0.1 * by},
                f"repeats: U23, operator: {'ann' if k % 2 else 'bob'}, station: s{k // 4}")
        return write(self.path("fleet.yaml"), PLAN % "focal_px: [80, 90]" + "".join(units))

    def test_unusual_units_jumps_batches_and_the_gauge_are_told(self):
        plan = self.make_fleet()
        result = self.succeed("batch", plan, "-o", self.out, "--gather")
        unusual = [line for line in result.stdout.splitlines() if "outlier in" in line]
        self.assertEqual(len(unusual), 1, result.stdout)
        self.assertRegex(unusual[0], "^U08: outlier in .*shape")
        self.assertEqual([serial for serial, row in self.table().items() if row["outlying_metrics"]], ["U08"])
        self.assertEqual(self.table()["U23"]["lens_batch"], "new")
        self.assertRegex(result.stdout, r"from U14 \(first lens of batch new\), the mean of focal "
                                        r"length \(focal_px\) changes from \d+\.?\d* px to \d")
        self.assertRegex(result.stdout, r"lens batches differ in focal length \(focal_px\): .* in <old>, ")
        told = json.loads(run("batch", plan, "-o", self.out, "--gather", "--json").stdout)
        self.assertEqual({jump["serial"] for jump in told["jumps"]}, {"U14"})
        self.assertEqual({jump["metric"] for jump in told["jumps"]}, {"lens", "focal_px"})
        self.assertEqual(told["lens_batches"]["units"], {"<old>": 13, "new": 10})
        differing = [name for name, figure in told["lens_batches"]["metrics"].items() if figure["differs"]]
        self.assertEqual(differing, ["lens", "focal_px"])
        gauge = told["gauge_study"]
        self.assertEqual((gauge["repeats"], gauge["golden_units"], gauge["degrees_of_freedom"]), (8, 1, 5))
        center = gauge["metrics"]["center_x_px"]
        # Operators are 0.1 px apart, and so are stations; nothing else differs.
        self.assertAlmostEqual(center["repeatability_sd"], 0, delta=1e-6)
        for factor in ("operator", "station"):
            self.assertAlmostEqual(center[factor]["sd"], 0.1 / 2 ** 0.5, delta=1e-4)
        self.assertGreater(center["gauge_rr_ratio"], 0.05)

    def test_words_that_a_spreadsheet_would_run_are_text(self):
        more = ["  - {serial: B1, features: few/features.csv, lens_batch: '=cmd|x!A1'}\n",
                "  - {serial: B2, features: '-gone.csv', lens_batch: '+1'}\n",
                "  - {serial: B3, features: few/features.csv, lens_batch: '@A1, \"2\"'}\n",
                "  - {serial: B4, features: few/features.csv, lens_batch: ' =A1'}\n"]
        self.assertEqual(self.batch(self.plan(("A1",), more=more)).returncode, 3)
        table = self.table()
        self.assertEqual([table[f"B{k}"]["lens_batch"] for k in (1, 2, 3, 4)],
                         ["'=cmd|x!A1", "'+1", "'@A1, \"2\"", "' =A1"])
        for row in table.values():
            for text in (row["reason"], row["lens_batch"], row["outlying_metrics"]):
                self.assertNotIn(text[:1], tuple("=+-@"))

    def test_the_page_shows_the_fleet(self):
        plan = self.make_fleet()
        self.succeed("batch", plan, "-o", self.out, "--gather")
        page = read(self.out + "/fleet.html").decode()
        for heading in ("31 units", "Outliers", "Changes over time", "Control charts", "Lens batches",
                        "Gauge repeatability", "All units"):
            self.assertIn(heading, page)
        self.assertNotIn("<old>", page)  # names are text, not tags
        self.assertIn("&lt;old&gt;", page)
        self.assertNotRegex(page, r"(src|href)=.(https?:)?//")
        charts = dict(re.findall(r'aria-label="control chart of (\w+)">(.*?)</svg>', page, re.DOTALL))
        self.assertEqual(list(charts)[:5], ["lens", "shape", "focal_px", "center_x_px", "center_y_px"])
        self.assertEqual(re.findall(r"<title>(\w+):", charts["shape"]), ["U08"])
        # A point for each other unit, an upper limit; limits on both sides about two middles.
        points = re.search(r'class="units" d="([^"]*)"', charts["shape"])[1]
        self.assertEqual(points.count("M"), 23)
        self.assertEqual(charts["shape"].count('class="limit"'), 1)
        self.assertEqual([d.count("M") for d in re.findall(r'class="limit" d="([^"]*)"', charts["focal_px"])], [2, 2])
        limits = re.search(r"\(focal_px\). Limits: ([\d.]+) to ([\d.]+) px, from U14 ([\d.]+) to", page)
        self.assertLess(float(limits[1]), float(limits[2]))
        self.assertGreater(float(limits[3]), float(limits[1]))
        xml.dom.minidom.parseString(f"<svg>{charts['focal_px']}</svg>")
        self.succeed("batch", plan, "-o", self.out, "--gather")
        self.assertEqual(read(self.out + "/fleet.html").decode(), page)

    def test_the_fleets_middle_camera_serves_units_with_few_images(self):
        plan = self.make_fleet()
        self.succeed("batch", plan, "-o", self.out, "--gather")
        middle = self.out + "/fleet_camera.yaml"
        facts = json.loads(run("compare", middle, self.out + "/U03/camera.yaml", "--json").stdout)
        self.assertLess(facts["median_px"], 2)  # of lenses that are some pixels apart
        self.assertGreater(facts["median_px"], 0.01)
        # A unit of five images: its corners are those of the fleet, where its own images tell nothing.
        lines = read(self.path("A1/features.csv")).decode().splitlines(keepends=True)
        few = write(self.path("five.csv"), "".join(line for line in lines if not re.match("sim000[5-9]", line)))
        words = ["calibrate", "--features", few, "--image-size", "160x120", "--fix-target-geometry", "--skip-comparison",
                 "--knot-spacing-px", 40, "--pattern", self.path("board.yaml"), "--quiet"]
        worst = {}
        for name, more in (("alone", []), ("like", ["--prior", middle])):
            run(*words, "-o", self.path("five-" + name), *more)
            facts = run("compare", self.path("A1/true_camera.yaml"), self.path(f"five-{name}/camera.yaml"), "--json")
            worst[name] = json.loads(facts.stdout)["max_px"]
        self.assertLess(worst["like"], worst["alone"])
        # The plan's key is the same, and the mean cannot be its own.
        text = read(plan).decode().replace("model: opencv", "knot_spacing_px: 40\nprior: " + middle)
        text = text.split("units:")[0] + f"units:\n  - {{serial: N1, features: {few}}}\n"
        again = write(self.path("again.yaml"), text.replace("limits: {focal_px: [80, 90]}\n", ""))
        run("batch", again, "-o", self.path("few-units"))
        self.assertEqual(read(self.path("few-units/N1/camera.yaml")).decode().replace('serial: "N1"\n', ""),
                         read(self.path("five-like/camera.yaml")).decode())
        facts = json.loads(read(self.path("few-units/N1/result.json")))
        self.assertLess(facts["population_distance"]["rms_px"], 5 * facts["population_distance"]["population_rms_px"])
        self.assertNotIn("warning", facts["population_distance"])
        self.assert_refused(run("batch", again, "-o", self.out), 7, "fleet_camera.yaml")
        self.assert_refused(run(*words, "--model", "opencv", "--prior", middle, "-o", self.path("no")), 1, "--prior")
        words[4] = "320x240"
        self.assert_refused(run(*words, "--prior", middle, "-o", self.path("no")), 1, "160x120", "320x240")

    def test_a_stranger_to_the_fleet_is_told(self):
        plan = self.make_fleet()
        self.succeed("batch", plan, "-o", self.out, "--gather")
        self.succeed("simulate", "--images", 5, "--features-per-image", 60, "--pattern", self.path("board.yaml"),
                     "--lens", "pinhole", "--size", "160x120", "-o", self.path("stranger"))
        # Former names of keys stay valid.
        text = PLAN.replace("model: opencv", "cell_px: 40\nlike: " + self.out + "/fleet_camera.yaml") % ""
        strange = write(self.path("strange.yaml"), text + "  - {serial: S1, features: stranger/features.csv}\n")
        self.out = self.path("strange")
        result = self.succeed("batch", strange, "-o", self.out)
        told = "S1: warn, .*: this camera is an outlier of its fleet .* px RMS from the population mean .* calibrate it without"
        self.assertRegex(result.stdout, told)
        facts = json.loads(read(self.out + "/S1/result.json"))
        self.assertIn(facts["population_distance"]["warning"], facts["reasons"])
        self.assertEqual(self.table()["S1"]["reason"], facts["population_distance"]["warning"])
        self.assertIn("this camera is an outlier", read(self.out + "/S1/report.html").decode())

    def test_limits_end_in_6_and_cost_no_calibration(self):
        self.assert_done(self.batch(self.plan()))
        before = self.files()
        result = self.batch(self.plan(limits="focal_px: [10, 20], held_out_median_px: 0.5"))
        self.assertEqual(result.returncode, 6)
        self.assertIn("A1: fail: focal_px is 83", result.stderr)
        self.assertEqual({row["status"] for row in self.table().values()}, {"fail"})
        after = self.files()
        for name in ("fleet.csv", "fleet.html"):
            del before[name], after[name]
        self.assert_same_files(after, before)

    def test_neither_order_nor_threads_change_a_byte(self):
        self.assert_done(self.batch(self.plan(), "--threads", 1))
        expected = self.files()
        self.assert_done(self.batch(self.plan(GOOD[::-1]), "--threads", 2, output="-turned"))
        self.assert_same_files(self.files(), expected)

    def test_single_units_gathered_are_the_same(self):
        plan = self.plan(GOOD[::-1])
        self.assert_done(self.batch(plan))
        expected = self.files()
        for units in ("2", "0-0"):
            self.assert_done(self.batch(plan, "--unit", units, output="-single"))
        self.assertEqual(sorted(os.listdir(self.out)), [".batch.lock", "A1", "A3"])
        result = self.batch(plan, "--gather", output="-single")
        self.assert_refused(result, 2, "A2: missing")
        self.assert_done(self.batch(plan, "--unit", 1, output="-single"))
        self.assert_done(self.batch(plan, "--gather", output="-single"))
        self.assert_same_files(self.files(), expected)
        for units, words in (("3", "numbered from 0"), ("1-3", "numbered from 0"), ("2-1", "expected a unit"), ("-1", "expected a unit"),
                             ("1-", "expected a unit"), ("x", "expected a unit"), ("1234567890123", "expected a unit")):
            self.assert_refused(self.batch(plan, "--unit=" + units, output="-single"), 1, words)
        self.assert_done(self.batch(plan, "--unit", "0-2", output="-three"))
        self.assert_done(self.batch(plan, "--gather", output="-three"))
        self.assert_same_files(self.files(), expected)

    def kill_after_first(self, plan, number):
        """Ends a run by a signal while it works on the second unit; how that ended."""
        self.out = self.path("killed")
        shutil.rmtree(self.out, ignore_errors=True)
        with subprocess.Popen([programs.raygrid, "batch", plan, "-o", self.out]) as process:
            wait_until(lambda: os.path.exists(self.out + "/A1/unit.json"))
            process.send_signal(number)
            return process.wait(timeout=HANG_S)

    def test_a_run_that_was_killed_goes_on_to_the_same_bytes(self):
        plan = self.plan()
        self.assert_done(self.batch(plan))
        expected = self.files()
        for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGINT):
            self.assertEqual(self.kill_after_first(plan, number), -number)
            self.assertFalse(os.path.exists(self.out + "/A3/unit.json"))
            first = os.stat(self.out + "/A1/camera.yaml")
            self.succeed("batch", plan, "-o", self.out)
            self.assert_same_files(self.files(), expected)
            # Finished units were not done again.
            self.assertEqual(os.stat(self.out + "/A1/camera.yaml").st_mtime_ns, first.st_mtime_ns)

    def test_a_unit_whose_process_is_killed_is_named_and_the_others_go_on(self):
        self.out = self.path("crashed")
        with subprocess.Popen([programs.raygrid, "batch", self.plan(), "-o", self.out], stderr=subprocess.PIPE,
                              text=True) as process:
            wait_until(lambda: os.path.isdir(self.out + "/A1"))
            children = wait_until(
                lambda: read(f"/proc/{process.pid}/task/{process.pid}/children").split())
            os.kill(int(children[0]), signal.SIGKILL)
            errors = process.communicate(timeout=HANG_S)[1]
        self.assertEqual(process.returncode, 2)
        self.assertEqual([line for line in errors.splitlines() if "signal 9" not in line], [])
        self.assertIn("unit A1: error", errors)
        self.assertEqual([row["status"] for row in self.table().values()], ["error", "pass", "warn"])

    def test_a_second_process_waits_for_the_first_and_does_nothing_again(self):
        """As when a machine was given up, but still works on a unit that another one gets."""
        plan, self.out = self.plan(("A1",)), self.path("shared")
        command = [programs.raygrid, "batch", plan, "-o", self.out, "--unit", "0"]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as first:
            wait_until(lambda: read(f"/proc/{first.pid}/task/{first.pid}/children"))
            child = int(read(f"/proc/{first.pid}/task/{first.pid}/children").split()[0])
            os.kill(child, signal.SIGSTOP)
            with subprocess.Popen(command, stdout=subprocess.DEVNULL) as second:
                wait_until(lambda: waits_for_a_lock(self.out))
                os.kill(child, signal.SIGCONT)
                self.assertEqual(first.wait(timeout=HANG_S), 0)
                made = os.stat(self.out + "/A1/camera.yaml")
                self.assertEqual(second.wait(timeout=HANG_S), 0)
        self.assertEqual(os.stat(self.out + "/A1/camera.yaml").st_ino, made.st_ino)
        self.assertEqual(sorted(os.listdir(self.out)), [".batch.lock", "A1"])

    def test_results_do_not_lie_among_images(self):
        os.makedirs(self.path("among/X1"))
        plan = write(self.path("among/plan.yaml"), "raygrid_batch: 1\npattern: ../board.yaml\n"
                     "units: [{serial: X1, images: X1/}]\n")
        self.assert_refused(run("batch", plan, "-o", self.path("among")), 7, "X1", "into its image folder")
        self.assertEqual(os.listdir(self.path("among/X1")), [])

    def test_changed_inputs_are_calibrated_anew_and_no_others(self):
        shutil.copytree(self.path("A1"), self.path("C1"))
        plan = self.plan(("A2", "C1"))
        self.assert_done(self.batch(plan))
        times = {serial: os.stat(f"{self.out}/{serial}/camera.yaml").st_mtime_ns for serial in ("A2", "C1")}
        shutil.copy(self.path("A3/features.csv"), self.path("C1/features.csv"))
        self.assert_done(self.batch(plan))
        self.assertEqual(os.stat(self.out + "/A2/camera.yaml").st_mtime_ns, times["A2"])
        self.assertNotEqual(os.stat(self.out + "/C1/camera.yaml").st_mtime_ns, times["C1"])
        # One that vanishes leaves its result.
        os.remove(self.path("C1/features.csv"))
        camera = read(self.out + "/C1/camera.yaml")
        self.assert_refused(self.batch(plan), 2, "C1: error", "features.csv")
        self.assertEqual(read(self.out + "/C1/camera.yaml"), camera)
        shutil.copy(self.path("A3/features.csv"), self.path("C1/features.csv"))
        self.assert_done(self.batch(plan))
        self.assertEqual(self.table()["C1"]["status"], "warn")
        self.assertNotIn("C1.failed.json", os.listdir(self.out))

    def test_a_full_disk_ends_the_run_and_loses_nothing(self):
        plan = self.plan()
        self.assert_done(self.batch(plan, "--unit", 0))
        before = self.files()

        def limit_size():
            resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000))
        result = subprocess.run([programs.raygrid, "batch", plan, "-o", self.out], preexec_fn=limit_size,
                                capture_output=True, text=True, check=False)
        self.assert_refused(result, 7, "A2", "cannot be written")
        files = self.files()
        self.assert_same_files({name: files[name] for name in before}, before)
        self.assert_done(self.batch(plan))

    def test_a_rig_is_a_unit(self):
        self.succeed("simulate", "--images", 8, "--features-per-image", 60, "--cameras", 2, "--lens", "wide",
                     "--size", "160x120", "--pattern", self.path("board.yaml"), "-o", self.path("rig"))
        os.makedirs(self.path("rig/l"))
        folders = "  - {serial: R2, cameras: {left: rig/l, right: rig/r}}\n"
        result = self.batch(self.plan(("rig",), more=[folders]))
        self.assertEqual(self.table()["rig"]["status"], "warn")
        self.assertLess(float(self.table()["rig"]["held_out_median_px"]), 0.2)
        self.assertIn("rig.yaml", os.listdir(self.out + "/rig"))
        self.assert_refused(result, 2, "R2: error", "rig/r")

    def test_damaged_results_are_named_and_made_again(self):
        plan = self.plan()
        self.assert_done(self.batch(plan))
        expected = self.files()
        for name in ("result.json", "camera.yaml", "camera.raygrid"):
            os.remove(f"{self.out}/A2/{name}")
            self.assert_refused(self.batch(plan, "--gather"), 2, "A2: error", name, "run the batch again")
            self.assertEqual([row["status"] for row in self.table().values()], ["warn", "error", "warn"])
            self.assert_done(self.batch(plan))
            self.assert_same_files(self.files(), expected)

    def test_every_file_of_a_result_that_was_cut_is_made_again(self):
        """Empty, halved, without its last byte, or full of zeros as after a power cut."""
        self.succeed("simulate", "--images", 8, "--features-per-image", 60, "--cameras", 2, "--lens", "wide",
                     "--size", "160x120", "--pattern", self.path("board.yaml"), "-o", self.path("pair"))
        plan = self.plan(("A1", "pair"))
        self.assert_done(self.batch(plan))
        names = [name for name in self.files() if name.startswith(("A1/", "pair/")) and "unit.json" not in name]
        self.assertIn("pair/cam1/camera.raygrid", names)
        damages = (lambda data: b"", lambda data: data[:len(data) // 2], lambda data: data[:-1],
                   lambda data: bytes(len(data)))
        for number, name in enumerate(sorted(names)):
            path = f"{self.out}/{name}"
            whole = read(path)
            for damage in (damages if "camera.raygrid" in name else damages[number % 4:number % 4 + 1]):
                write(path, damage(whole))
                self.assert_refused(self.batch(plan, "--gather"), 2, name, "run the batch again")
            write(path, whole)
        self.assert_done(self.batch(plan, "--gather"))
        expected = self.files()
        for name in ("A1/poses.csv", "pair/cam0/camera.raygrid"):
            write(f"{self.out}/{name}", read(f"{self.out}/{name}")[:-1])
        self.assert_done(self.batch(plan))
        self.assert_same_files(self.files(), expected)

    def test_a_unit_whose_folder_cannot_be_written_stops_no_other(self):
        plan = self.plan()
        self.out = self.path("out-" + self.id().split(".")[-1])
        in_the_way = write(self.out + "/A1", b"a file")
        os.makedirs(self.out + "/A2/camera.yaml")
        result = self.batch(plan)
        self.assertEqual(result.returncode, 7, result.stderr)
        self.assertIn("unit A1: error", result.stderr)
        self.assertIn("unit A2: error", result.stderr)
        self.assertEqual([row["status"] for row in self.table().values()], ["error", "error", "warn"])
        self.assertEqual(read(in_the_way), b"a file")
        os.remove(in_the_way)
        os.rmdir(self.out + "/A2/camera.yaml")
        self.assert_done(self.batch(plan))
        self.assertEqual([row["status"] for row in self.table().values()], ["warn", "pass", "warn"])

    def test_a_plan_tells_the_seed(self):
        self.assert_done(self.batch(self.plan(GOOD[:1], more=["seed: 7\n"])))
        self.assert_done(self.batch(self.plan(GOOD[:1]), "--seed", 7, output="-same"))

    def test_bad_plans_are_refused_before_the_work(self):
        for words, change in (
                (("duplicate serial", "A1"), lambda text: text.replace("serial: A2", "serial: A1")),
                (("must have 1 to",), lambda text: text.replace("serial: A2", "serial: ../A2")),
                (("must have 1 to",), lambda text: text.replace("serial: A2", "serial: ''")),
                (("unknown key 'colour'",), lambda text: text + "colour: red\n"),
                (("unknown 'sharpness'",), lambda text: text.replace("{}", "{sharpness: 1}", 1)),
                (("exactly one of images",), lambda text: text.replace("features: A2/features.csv", "model: opencv")),
                (("A2: a golden unit", "repeat another unit, A1"), lambda text: text.replace(
                    "serial: A2,", "serial: A2, repeats: A1,").replace("serial: A3,", "serial: A3, repeats: A2,")),
                (("A2: repeats B7", "not in the plan"), lambda text: text.replace(
                    "serial: A2,", "serial: A2, repeats: B7,")),
                (("A2", "no operator"), lambda text: text.replace(
                    "serial: A2,", "serial: A2, repeats: A1, operator: ann,")),
                (("must have 1 to",), lambda text: text.replace("serial: A2,", "serial: A2, repeats: ../A1,")),
                (("'lens_batch': expected a single value",), lambda text: text.replace(
                    "serial: A2,", "serial: A2, lens_batch: [1],")),
                (("reserved for a file of the batch",), lambda text: text.replace("serial: A2", "serial: fleet.html")),
                (("missing pattern",), lambda text: text.replace("pattern: board.yaml\n", "")),
                (("units: expected a list",), lambda text: text.split("units:")[0]),
                (("not a batch",), lambda text: text.replace("raygrid_batch: 1\n", "")),
                (("line",), lambda text: text + "\t- ["),
                (("line 4",), lambda text: text.replace("comparison: true", "comparison: perhaps"))):
            with self.subTest(words):
                plan = self.plan()
                write(plan, change(read(plan).decode()))
                self.assert_refused(self.batch(plan), 2, os.path.basename(plan), *words)
                self.assertFalse(os.path.exists(self.out))


if __name__ == "__main__":
    main(__name__)
