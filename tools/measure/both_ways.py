"""Held-out errors with rigid boards and with boards that may bend, of raygrid's cameras and of its
peers'. raygrid imports what a peer calibrated, with the board as the peer knows it, and evaluates all
alike."""
import os

import accuracy
import datasets
import progress
import raygrid_peer
import sets
import tables

MODELS = ("central-generic", "noncentral-generic", "thin-prism-fisheye", "opencv")
LIMIT = 0.01  # part of the median by which the peer's own code may differ

def jobs(options):
    """Of the photographs those with the best corners, and the shared sets."""
    photographs = [job for job in sets.photograph_jobs(options.work) if job["kind"] == "raygrid"]
    shared, absent = sets.shared_jobs(options.data, options.work)
    usual = [job for job in shared if not job["few"]]
    few = [name for name, *_, is_few in sets.SHARED if is_few]
    return [{**job, "both_ways": True} for job in photographs + usual], [n for n in absent if n not in few]


# ---- raygrid -------------------------------------------------------------------

def write_held_out(job):
    """features.csv of the held-out images."""
    parts = datasets.read_split(job["folder"])
    path = os.path.join(job["work"], "held_out.csv")
    with open(os.path.join(job["folder"], "features.csv"), encoding="utf-8", newline="") as file:
        lines = file.read().splitlines()
    with open(path, "w", encoding="utf-8") as file:
        for number, line in enumerate(lines):
            if number == 0 or parts[line.split(",")[0]] == "test":
                file.write(line + "\n")
    return path


def evaluate(options, camera, pattern, held_out):
    """Both figures of a camera's file."""
    log = camera + ".evaluated.json"
    arguments = ["evaluate", camera, "--features", held_out, "--pattern", pattern, "--json"]
    if not raygrid_peer.run(options.raygrid, arguments, log):
        return None
    with open(log, encoding="utf-8") as file:
        text = file.read()
    # Remarks of an import stand beside the result.
    figures = datasets.parse_json(text[text.index("{"):text.rindex("}") + 1])
    return {"rigid": figures, "flexed": figures.get("with_deformation")}


def models_of(job):
    """Without the non-central grid where one calibration takes minutes."""
    return [m for m in MODELS if m != "noncentral-generic" or job["name"] not in accuracy.LENGTH]


def raygrid_rows(job, options):
    parts = datasets.read_split(job["folder"])
    held_out = ",".join(image for image, part in parts.items() if part == "test")
    for model in models_of(job):
        output = os.path.join(job["work"], model)
        camera = os.path.join(output, "camera.yaml")
        arguments = raygrid_peer.calibrate_arguments(job, output) + ["--model", model, "--hold-out", held_out]
        if options.keep and os.path.exists(camera) or raygrid_peer.run(options.raygrid, arguments, output + ".log"):
            yield {"peer": "raygrid", "version": "", "model": model, "target": "estimated", "camera": camera,
                   "pattern": os.path.join(output, "pattern.yaml")}


def measure(job, options, path):
    """All programs' cameras, one after the other."""
    rows = list(raygrid_rows(job, options))
    for name, _, python, script in accuracy.programs(options, {**job, "few": True}):
        output = os.path.join(job["work"], name + ".json")
        accuracy.run_python(python, script, os.path.join(job["work"], "job.json"), output)
        rows += datasets.read_json(output)
    held_out = write_held_out(job)
    for row in rows:
        if "camera" in row:
            row["both"] = evaluate(options, row["camera"], row["pattern"], held_out)
    datasets.write_json(path, rows)


def steps_of(job, options):
    path = os.path.join(job["work"], "both_ways.json")
    if options.keep and os.path.exists(path):
        return []
    length = accuracy.LENGTH.get(job["name"], 1)
    return [progress.Step(f"{job['title']}: corners and poses", 5 * length, lambda: accuracy.start(job, options)),
            progress.Step(f"{job['title']}: all programs", 20 * length, lambda: measure(job, options, path))]


def steps(options):
    wanted, absent = jobs(options)
    for name in absent:
        print(f"skipped: {options.data}/{name} is not there")
    return [step for job in wanted for step in steps_of(job, options)]


# ---- Data ----------------------------------------------------------------------

def results(options):
    found = []
    for job in jobs(options)[0]:
        path = os.path.join(job["work"], "both_ways.json")
        if os.path.exists(path):
            found.append({"job": job, "rows": datasets.read_json(path)})
    return found


def own_code(row):
    """The rigid median by the peer's own code; raygrid has no other."""
    return tables.number(row["test"]["median"]) if "test" in row else ""


def is_imported(row):
    """Whether the import is the peer's camera, by the corners' median."""
    if "test" not in row:
        return True
    median = row["test"]["median"]
    return abs(row["both"]["rigid"]["median_px"] - median) <= LIMIT * median


def order_of(row):
    deformed = row["both"]["flexed"]
    return (deformed is None, (deformed or row["both"]["rigid"])["median_px"])


def columns_of(way, figures):
    """Views of too few corners have no errors with deformed targets."""
    if not figures:
        return {}
    return {f"{way}_median_px": tables.number(figures["median_px"]), f"{way}_rms_px": tables.number(figures["rms_px"]),
            f"{way}_corners": figures["count"]}


def failure_of(row):
    if "failed" in row:
        return row["failed"]
    if not row.get("both"):
        return "raygrid does not take it"
    return (f"its import has a rigid median of {tables.number(row['both']['rigid']['median_px'])}, "
            f"its own code {own_code(row)}")


def data_rows(found):
    """Rows of target_deformation.csv, by set in the order of the median with deformed targets."""
    for result in found:
        name = result["job"]["name"]
        compared = [row for row in result["rows"] if row.get("both") and is_imported(row)]
        for row in sorted(compared, key=order_of):
            yield {**tables.head_of(name, row), **columns_of("rigid", row["both"]["rigid"]),
                   **columns_of("deformed", row["both"]["flexed"]), "own_code_median_px": own_code(row)}
        for row in result["rows"]:
            if "failed" in row or "camera" in row and row not in compared:
                yield {**tables.head_of(name, row), "failure": failure_of(row)}
