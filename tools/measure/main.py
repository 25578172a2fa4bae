"""The measurements that tools/measure_readme runs once all is built and installed."""
import argparse
import os
import shutil
import sys

import accuracy
import benchmarks_file
import both_ways
import datasets
import frame_paths
import progress
import remap
import sets


def parse():
    parser = argparse.ArgumentParser()
    for name in ("raygrid", "remap-bench", "photographs", "data", "work", "output"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--new-python", default="")
    parser.add_argument("--only", default="")
    parser.add_argument("--keep", action="store_true")
    return parser.parse_args()


def accuracy_sections(options):
    blob = datasets.read_json(os.path.join(options.work, "blob", "blob.json"))
    absent = sets.shared_jobs(options.data, options.work)[1]
    return benchmarks_file.accuracy_sections(accuracy.results(options), blob["bytes"], absent)


def both_ways_sections(options):
    return benchmarks_file.both_ways_sections(both_ways.results(options), both_ways.jobs(options)[1])


def remap_sections(options):
    return benchmarks_file.remap_sections(remap.results(options))


def paths_sections(options):
    return benchmarks_file.paths_sections(frame_paths.results(options))


PARTS = {"accuracy": (accuracy.steps, accuracy_sections),
         "both-ways": (both_ways.steps, both_ways_sections), "remap": (remap.steps, remap_sections),
         "paths": (frame_paths.steps, paths_sections)}


def measure(part, options):
    """One part, whose results have a folder of their own."""
    steps, sections = PARTS[part]
    options = argparse.Namespace(**{**vars(options), "work": os.path.join(options.work, part)})
    if not options.keep:
        shutil.rmtree(options.work, ignore_errors=True)
    os.makedirs(options.work, exist_ok=True)
    seconds, failed = progress.run(steps(options))
    print(f"{part}: {seconds:.0f} s")
    if failed:
        sys.exit(f"measure_readme: {part}: {len(failed)} steps failed, and {options.output} is as it was; "
                 "mend them and go on with --keep")
    benchmarks_file.write(options.output, sections(options))


def main():
    options = parse()
    options.data, options.work = os.path.abspath(options.data), os.path.abspath(options.work)
    for part in [options.only] if options.only else PARTS:
        measure(part, options)
    print(f"written: {options.output}")


if __name__ == "__main__":
    main()
