#!/usr/bin/env python3
"""batch --slurm: every unit has one result, also if a node is lost while it works on one."""
import csv
import io
import json
import os
import signal
import subprocess
import unittest
from unittest import mock

from batch_results import result_files, waits_for_a_lock
from command_test import (CommandTest, SIMULATED_PATTERN, cpu_seconds_of_children, main, programs, read, run, wait_until,
                          write)
from slurm_cluster import Cluster, what_is_missing

PLAN = """raygrid_batch: 1
pattern: board.yaml
model: opencv
skip_comparison: true
fix_target_geometry: true
image_size: [64, 48]
units:
"""
NUM_UNITS, BAD, FEW = 20, 3, 13  # counted from 0

POLL_S = 0.05  # a look at all processes takes CPU time


def serial(unit):
    return f"S{unit:02d}"


class Slurm(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        board = write(cls.path("board.yaml"), SIMULATED_PATTERN)
        for unit in range(NUM_UNITS):
            cls.succeed("simulate", "--images", 5, "--features-per-image", 30, "--pattern", board, "--seed", unit,
                        "--lens", "pinhole", "--size", "64x48", "-o", cls.path(serial(unit)))
        lines = read(cls.features(FEW)).decode().splitlines(keepends=True)
        write(cls.features(FEW), "".join(line for line in lines if line.startswith(("image,", "sim0000"))))
        write(cls.features(BAD), "no,features\n")
        cls.plan = write(cls.path("plan.yaml"), PLAN + "".join(
            f"  - {{serial: {serial(unit)}, features: {serial(unit)}/features.csv}}\n" for unit in range(NUM_UNITS)))

    @classmethod
    def features(cls, unit):
        return cls.path(serial(unit) + "/features.csv")

    def fake_sbatch(self, text):
        """A folder with a program of that name, which takes the place of others."""
        path = write(self.path("fake/sbatch"), "#!/bin/sh\n" + text)
        os.chmod(path, 0o755)
        return mock.patch.dict(os.environ, PATH=self.path("fake") + ":" + os.environ["PATH"])

    def test_without_slurm_a_line_says_what_to_do(self):
        with mock.patch.dict(os.environ, PATH=self.path("nowhere")):
            result = run("batch", self.plan, "-o", self.path("none"), "--slurm")
        self.assert_refused(result, 1, "sbatch not found in PATH", "slurm-client", "GNU parallel")

    def test_what_slurm_refuses_is_told(self):
        with self.fake_sbatch("echo 'sbatch: error: invalid partition' >&2; exit 1\n"):
            result = run("batch", self.plan, "-o", self.path("refused"), "--slurm")
        self.assert_refused(result, 7, "invalid partition")
        for words in (["--unit", 3], ["--gather"]):
            self.assertEqual(run("batch", self.plan, "-o", self.path("refused"), "--slurm", *words).returncode, 1)

    def test_tasks_are_all_units_once_and_paths_may_have_any_letter(self):
        """2,500 units are 1,000 tasks; what the shell makes of each is what raygrid would get."""
        folder = self.path("it's 100% a $HOME")
        units = "".join(f"  - {{serial: {unit}, features: x.csv}}\n" for unit in range(2500))
        plan = write(folder + "/plan.yaml", PLAN + units)
        before = cpu_seconds_of_children()
        with self.fake_sbatch(f"for word in \"$@\"; do printf '%s\\n' \"$word\"; done >>'{self.path('words')}'\n"
                              "echo 'sbatch: a warning'; echo '77;cluster'\n"):
            result = run("batch", plan, "-o", folder + "/out", "--slurm", "--json", "--seed", 5)
        self.assert_done(result)
        # In linear time: a task of Slurm reads all of it.
        self.assertLess(cpu_seconds_of_children() - before, 3)
        self.assertEqual(json.loads(result.stdout), {"schema_version": 2, "array_job_id": "77", "tasks": 1000, "gather_job_id": "77"})
        words = read(self.path("words")).decode().splitlines()
        for word in ("--array=0-999", "--requeue", "--open-mode=append", "--dependency=afterany:77",
                     "--cpus-per-task=1", f"--output={folder.replace('%', '%%')}/out/.slurm/%a.log"):
            self.assertIn(word, words)
        array, gather = [word[len("--wrap="):] for word in words if word.startswith("--wrap=")]
        show = "printf '%s ' "
        script = "\n".join(f"SLURM_ARRAY_TASK_ID={task}; {job.replace('exec ', show, 1)}; echo"
                           for task, job in ((0, array), (1, array), (500, array), (999, array), (0, gather)))
        told = subprocess.run(["sh", "-c", script], capture_output=True, text=True, check=True).stdout.splitlines()
        start = f"{programs.raygrid} batch {plan} -o {folder}/out --threads 1 --seed 5 --quiet "
        self.assertEqual([line.rstrip() for line in told], [start + units for units in ("--unit 0-1", "--unit 2-4", "--unit 1250-1251",
                                                            "--unit 2497-2499", "--gather")])

    @unittest.skipIf(what_is_missing(), what_is_missing())
    def test_a_node_that_is_lost_costs_no_unit_and_doubles_none(self):
        expected = self.path("serial")
        self.assertEqual(run("batch", self.plan, "-o", expected, "--threads", 1, "--quiet").returncode, 2)
        cluster = Cluster()
        self.addCleanup(cluster.stop)
        out = self.path("out")
        with mock.patch.dict(os.environ, cluster.environment):
            self.succeed("batch", self.plan, "-o", out, "--slurm")

        # The daemon of a node ends in the middle. The unit that it worked on goes on, but slowly.
        def work():
            finished = [unit for unit in range(NUM_UNITS) if os.path.exists(f"{out}/{serial(unit)}/unit.json")]
            return len(finished) >= 4 and self.stop_one(cluster, out)
        task, stopped = wait_until(work, POLL_S)
        os.kill(cluster.pid("n1"), signal.SIGKILL)
        # Slurm gives it to the other node, where it waits for the one that outlived its own.
        wait_until(lambda: cluster.processes(SLURM_ARRAY_TASK_ID=task, SLURMD_NODENAME="n2", SLURM_RESTART_COUNT=1), POLL_S)
        wait_until(lambda: waits_for_a_lock(out))
        self.assertFalse(os.path.exists(f"{out}/{serial(int(task))}/unit.json"))
        for pid in stopped:
            os.kill(pid, signal.SIGCONT)
        wait_until(lambda: os.path.exists(out + "/fleet.html") and not cluster.ask("squeue", "-h"), POLL_S)

        files, wanted = result_files(out), result_files(expected)
        logs = {name: files.pop(name).decode() for name in list(files) if name.startswith(".slurm/")}
        self.assertEqual(sorted(files), sorted(wanted))
        for name, contents in wanted.items():
            self.assertEqual(files[name], contents, name)
        self.assertIn("1 image with", logs[f".slurm/{FEW}.log"])
        self.assertIn(serial(BAD), logs[f".slurm/{BAD}.log"])
        self.assertIn(serial(BAD), logs[".slurm/gather.log"])
        for row in csv.DictReader(io.StringIO(read(out + "/fleet.csv").decode())):
            is_done = row["serial"] not in (serial(BAD), serial(FEW))
            self.assertEqual(float(row["elapsed_s"] or 0) > 0, is_done, row)
            self.assertEqual(row["status"] == "error", not is_done, row)

    @staticmethod
    def stop_one(cluster, out):
        """The task that the first node works on, and its processes, which are stopped; or nothing."""
        for pid, environment in cluster.processes(SLURMD_NODENAME="n1"):
            task = next(variable for variable in environment if variable.startswith(b"SLURM_ARRAY_TASK_ID="))
            task = int(task.split(b"=")[1])
            # A sanitizer that looks for leaks is a child of its process, too.
            child = next((child for child in children(pid) if command_of(child) == b"calibrate"), None)
            if task in (BAD, FEW) or command_of(pid) != b"batch" or not child:
                continue
            stopped = [pid, child]
            for one in stopped:
                os.kill(one, signal.SIGSTOP)
            if not os.path.exists(f"{out}/{serial(task)}/unit.json"):
                return task, stopped
            for one in stopped:
                os.kill(one, signal.SIGCONT)
        return None


def of_process(pid, name):
    """A file of a process, which is empty once that has ended."""
    try:
        return read(f"/proc/{pid}/{name}")
    except OSError:
        return b""


def children(pid):
    return [int(child) for child in of_process(pid, f"task/{pid}/children").split()]


def command_of(pid):
    """The first word after the program's name."""
    words = of_process(pid, "cmdline").split(b"\0")
    return words[1] if len(words) > 1 else b""


if __name__ == "__main__":
    main(__name__)
