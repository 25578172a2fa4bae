"""The measurements that tools/measure_readme runs once all is built and installed."""
import argparse
import os
import shutil
import subprocess
import sys

import accuracy
import both_ways
import data_files
import datasets
import frame_paths
import images
import page
import progress
import remap


def parse():
    parser = argparse.ArgumentParser()
    for name in ("raygrid", "remap-bench", "photographs", "data", "work", "output"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--new-python", default="")
    for name in ("only", "images", "pattern"):
        parser.add_argument("--" + name, default="")
    for name in ("keep", "few"):
        parser.add_argument("--" + name, action="store_true")
    return parser.parse_args()


def accuracy_files(options):
    blob = datasets.read_json(os.path.join(options.work, "blob", "blob.json"))
    return data_files.accuracy_files(accuracy.results(options), blob["bytes"])


def both_ways_files(options):
    return data_files.both_ways_files(both_ways.results(options))


def remap_files(options):
    return data_files.remap_files(remap.results(options))


def paths_files(options):
    return data_files.paths_files(frame_paths.results(options))


PARTS = {"accuracy": (accuracy.steps, accuracy_files),
         "both-ways": (both_ways.steps, both_ways_files), "remap": (remap.steps, remap_files),
         "paths": (frame_paths.steps, paths_files)}


def version_of(raygrid):
    return subprocess.run([raygrid, "--version"], capture_output=True, text=True, check=True).stdout.strip()


def measure(part, options):
    """One part, whose results have a folder of their own."""
    steps, files_of = PARTS[part]
    options = argparse.Namespace(**{**vars(options), "work": os.path.join(options.work, part)})
    if not options.keep:
        shutil.rmtree(options.work, ignore_errors=True)
    os.makedirs(options.work, exist_ok=True)
    seconds, failed = progress.run(steps(options))
    print(f"{part}: {seconds:.0f} s")
    if failed:
        sys.exit(f"measure_readme: {part}: {len(failed)} steps failed, and {options.output} is as it was; "
                 "mend them and go on with --keep")
    files = files_of(options)
    for name, rows in files.items():
        data_files.write(options.output, name, rows)
    data_files.write_run(options.output, files, version_of(options.raygrid))
    page.update(options.output)


def main():
    options = parse()
    options.data, options.work = os.path.abspath(options.data), os.path.abspath(options.work)
    if options.images:
        images.main(options)
        return
    for part in [options.only] if options.only else PARTS:
        measure(part, options)
    print(f"written: {options.output}")


if __name__ == "__main__":
    main()
