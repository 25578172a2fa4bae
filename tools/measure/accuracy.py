"""Held-out errors of raygrid and its peers on all sets, and the size of README.md's blob."""
import functools
import os
import subprocess

import datasets
import progress
import raygrid_peer
import sets

HERE = os.path.dirname(os.path.abspath(__file__))
DEBIAN_PYTHON = "/usr/bin/python3"


def run_python(python, script, *arguments):
    """A script whose last argument is its output, beside which its remarks go."""
    log = arguments[-1] + ".log"
    with open(log, "w", encoding="utf-8") as file:
        done = subprocess.run([python, os.path.join(HERE, script), *arguments], stderr=file, check=False)
    if done.returncode:
        raise RuntimeError(f"ends in an error, see {log}")


def find_corners(options, photographs, kind, pattern, features):
    """features.csv by a detector."""
    if kind == "raygrid":
        log = features + ".log"
        if not raygrid_peer.run(options.raygrid, ["detect", photographs, "--pattern", pattern, "--no-cache", "-o",
                                                  features], log):
            raise RuntimeError(f"ends in an error, see {log}")
    else:
        run_python(DEBIAN_PYTHON, "corner_finders.py", photographs, kind, pattern, features)


def start(job, options):
    """Makes what every peer of a set needs: corners, and poses to start from."""
    if "kind" in job:
        sets.write_photograph_folder(job, options.photographs)
        find_corners(options, os.path.join(options.photographs, job["side"]), job["kind"],
                     *(os.path.join(job["folder"], name) for name in ("pattern.yaml", "features.csv")))
    raygrid_peer.write_starts(job, options.raygrid)
    sets.save(job)


def measure_raygrid(job, options, path):
    job = datasets.read_json(os.path.join(job["work"], "job.json"))
    rows = list(raygrid_peer.rows_of(job, options.raygrid))
    datasets.write_json(path, {"rows": rows, "by_peers_rule": raygrid_peer.localized_by_peers_rule(job)})


@functools.lru_cache
def has_mrcal(python):
    return subprocess.run([python, "-c", "import mrcal"], capture_output=True, check=False).returncode == 0


def programs(options, job):
    """Names of results, expected seconds and how they come about."""
    found = [("opencv-debian", 40, DEBIAN_PYTHON, "opencv_peer.py"),
             ("mrcal-debian", 20, DEBIAN_PYTHON, "mrcal_peer.py")]
    if options.new_python and not job["few"]:
        found += [("opencv-pypi", 40, options.new_python, "opencv_peer.py")]
        if has_mrcal(options.new_python):
            found += [("mrcal-pypi", 15, options.new_python, "mrcal_peer.py")]
    return found


# Sets that take longer than a small one, all told.
LENGTH = {"webcam_charuco": 12, "fisheye_190": 15, "photo_carnd_wide": 2, "photo_camodocal": 20, "photo_vins": 20}


def steps_of(job, options):
    length = (0.3 if job["few"] else 1) * (job.get("length") or LENGTH.get(job["name"], 1))

    def step(name, seconds, output, work):
        path = os.path.join(job["work"], output)
        is_kept = options.keep and os.path.exists(path)
        return None if is_kept else progress.Step(f"{job['title']}: {name}", seconds * length,
                                                  lambda: work(path))
    all_steps = [step("corners and poses", 5, "job.json", lambda _: start(job, options)),
                 step("raygrid", 45, "raygrid.json", lambda path: measure_raygrid(job, options, path))]
    for name, seconds, python, script in programs(options, job):
        all_steps.append(step(name, seconds, name + ".json", lambda path, p=python, s=script: run_python(
            p, s, os.path.join(job["work"], "job.json"), path)))
    return [s for s in all_steps if s]


def measure_blob(options):
    """README.md's second and third command; the blob's size."""
    folder = os.path.join(options.work, "blob")
    os.makedirs(folder, exist_ok=True)
    pattern = os.path.join(folder, "pattern.yaml")
    with open(pattern, "w", encoding="utf-8") as file:
        file.write(sets.PHOTOGRAPHS_PATTERN)
    result, blob = os.path.join(folder, "result"), os.path.join(folder, "front.raygrid")
    subprocess.run([options.raygrid, "calibrate", os.path.join(options.photographs, "left"), "--pattern",
                    pattern, "-o", result, "--quiet"], check=True)
    subprocess.run([options.raygrid, "pack", os.path.join(result, "camera.yaml"), "-o", blob,
                    "--remap", "640x480,hfov=60", "--quiet"], check=True)
    datasets.write_json(os.path.join(folder, "blob.json"), {"bytes": os.path.getsize(blob)})


def steps(options):
    jobs, absent = sets.shared_jobs(options.data, options.work)
    for name in absent:
        print(f"skipped: {options.data}/{name} is not there")
    wanted = [progress.Step("size of the blob", 15, lambda: measure_blob(options))]
    for job in sets.photograph_jobs(options.work) + jobs:
        wanted += steps_of(job, options)
    return wanted


def results(options):
    return results_of(sets.photograph_jobs(options.work) + sets.shared_jobs(options.data, options.work)[0], options)


def results_of(jobs, options):
    """By set: the job and all rows. Sets and programs that were not measured are not there."""
    found = []
    for job in jobs:
        path = os.path.join(job["work"], "raygrid.json")
        if not os.path.exists(path):
            continue
        raygrid = datasets.read_json(path)
        rows = raygrid["rows"]
        for name, *_ in programs(options, job):
            path = os.path.join(job["work"], name + ".json")
            rows += datasets.read_json(path) if os.path.exists(path) else []
        found.append({"job": job, "rows": rows, "by_peers_rule": raygrid["by_peers_rule"]})
    return found
