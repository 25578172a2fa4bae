#!/usr/bin/env python3
"""Prints what tests/run found: a line for each target, where the time went, what failed.

Reads what the targets left in the build folder: TARGET.seconds ("build 12", "tests 34"),
TARGET.xml (ctest's JUnit file), TARGET.KIND.passed, TARGET.log and TARGET/.ninja_log.
"""
import argparse
import os
import re
import sys
import xml.etree.ElementTree as xml

NUM_SLOWEST = 10
# Targets of one command: a single test.
COMMANDS = ("analysis", "fuzz", "micropython", "packages", "wheels")
FOOTPRINTS = ("cortex-m0plus", "cortex-m4")


def read(*path):
    try:
        with open(os.path.join(*path), encoding="utf-8", errors="replace") as file:
            return file.read()
    except FileNotFoundError:
        return ""


def status_of(case):
    """What became of a test. ctest says notrun of one that skipped itself, and of one that could
    not start; only their messages differ."""
    status = case.get("status")
    if status not in ("notrun", "disabled"):
        return status
    skipped = case.find("skipped")
    message = skipped.get("message") if skipped is not None else ""
    return "skipped" if re.match("SKIP_|Disabled", message or "") else "fail"


class Target:
    """What is known of one target's run."""

    def __init__(self, build, name, kind):
        self.name = name
        self.was_skipped = name in read(build, "skipped").split()
        self.has_passed = bool(read(build, f"{name}.{kind}.passed"))
        self.lacks_packages = read(build, "fetched").strip() not in ("", "0")
        self.seconds = {kind: int(seconds) for kind, seconds in
                        re.findall(r"^(\w+) (\d+)$", read(build, name + ".seconds"), re.MULTILINE)}
        self.tests = []  # name, seconds, and "run", "fail" or "skipped"
        text = read(build, name + ".xml")
        if text:
            self.tests = [(case.get("name"), float(case.get("time") or 0), status_of(case))
                          for case in xml.fromstring(text).iter("testcase")]
        elif name in COMMANDS and self.seconds:
            self.tests = [(name, self.seconds["tests"], "run" if self.has_passed else "fail")]
        self.log = read(build, name, "Testing", "Temporary", "LastTest.log") or read(build, name + ".log")

    def failed(self):
        return [name for name, _, status in self.tests if status == "fail"]

    def skipped(self):
        return [name for name, _, status in self.tests if status == "skipped"]

    def summary(self):
        if self.was_skipped:
            return "skipped, without its libraries"
        if not self.tests:
            if self.lacks_packages and not self.log:
                return "packages are missing, see build/fetching.log"
            return "did not build or had no test, see build/%s.log" % self.name
        text = "%d tests, %d failed" % (len(self.tests), len(self.failed()))
        if self.skipped():
            text += ", %d skipped" % len(self.skipped())
        return text


def compiled_sources(build, targets, began):
    """Seconds, target and object of what was compiled in this run."""
    found = {}
    for target in targets:
        for line in read(build, target.name, ".ninja_log").splitlines()[1:]:
            start, end, written, output, _ = line.split("\t")
            if output.endswith((".o", ".gch", ".pch")) and int(written) / 1e9 >= began:
                found[target.name, output] = (int(end) - int(start)) / 1000
    return sorted(((seconds, *key) for key, seconds in found.items()), reverse=True)


def print_slowest(title, rows):
    if rows:
        print("\n" + title)
    for seconds, target, name in rows[:NUM_SLOWEST]:
        name = re.sub(r"CMakeFiles/|\.dir|Unity/|_cxx\.cxx|\.o$", "", name)
        print("  %7.1f s  %-13s %s" % (seconds, target, name))


def print_runtime(targets):
    """What the runtime takes of boards, and that all of them remap alike."""
    footprints = []
    for target in targets:
        if target.name in FOOTPRINTS:
            block = re.search(r"^.*footprint\.py.*?^<end", target.log, re.MULTILINE | re.DOTALL)
            lines = re.findall(r"^(?:\.text|stack|symbols).*", block[0], re.MULTILINE) if block else []
            footprints += ["  %s: %s" % (target.name, line) for line in lines]
    if footprints:
        print("\nFootprint of the runtime (open, validate, unproject, remap)", *footprints, sep="\n")
    crcs = {target.name: sorted(set(re.findall(r"remap CRC [0-9a-f]*", target.log))) for target in targets}
    crcs = {name: found for name, found in crcs.items() if found}
    if crcs:
        print("\nCRC of the same undistorted frame")
    for name, found in crcs.items():
        print("  %-14s %s" % (name, " ".join(found)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kind", required=True, help="quick, default or everything")
    parser.add_argument("--began", type=int, required=True, help="when the run began, in seconds of the epoch")
    parser.add_argument("build", help="the folder that holds the targets' folders")
    parser.add_argument("targets", nargs="+")
    arguments = parser.parse_args()
    targets = [Target(arguments.build, name, arguments.kind) for name in arguments.targets]

    print_runtime(targets)
    print_slowest("Slowest tests", sorted(
        ((seconds, target.name, name) for target in targets if target.name not in COMMANDS
         for name, seconds, _ in target.tests), reverse=True))
    print_slowest("Slowest sources", compiled_sources(arguments.build, targets, arguments.began))

    print("\n%-15s %7s %7s   load %s" % ("seconds", "build", "tests", " ".join("%.1f" % x for x in os.getloadavg())))
    for target in targets:
        print("%-15s %7s %7s   %s" % (target.name, target.seconds.get("build", ""),
                                      target.seconds.get("tests", ""), target.summary()))
    failures = 0
    total = 0
    for target in targets:
        if target.was_skipped:
            continue
        total += max(1, len(target.tests))
        # A target without a failed test that did not pass either: it did not build.
        failures += len(target.failed()) or int(not target.has_passed)
        for name in target.failed():
            print("failed: %s %s" % (target.name, name))
    if not total:
        print("\nnothing was tested")
        return 1
    # All targets together, in ctest's own words.
    print("\n%d%% tests passed, %d tests failed out of %d"
          % (100 * (total - failures) // total, failures, total))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
