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

RULE = """Held-out corners are told about in two ways, by `raygrid evaluate` for all programs. *Rigid*: all corners of an image tell how
its board stands, and count. *Flexed*: half of an image's corners, in even places, tell how its board stands and bends; the other half
counts. All images together tell how far boards bend. So flexed errors have more of the pose's noise in them, and none of a
bend's. Boards have the points that the program found: `calibrateCameraRO`'s new points, mrcal's warp, raygrid's `pattern.yaml`.

raygrid imports the peers' cameras from OpenCV's FileStorage and mrcal's `.cameramodel`. *Own code* is the rigid median by the code of
`tools/measure`, which asks the peer's own library: it shows that the import is the same camera. Models that raygrid only takes by a fit,
with thin prisms or tilts, are left out, and the non-central grid from the two large sets. Boards whose
points were found far off a plane have no flexed errors. Rows are in the order of the flexed median."""


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
    return {"rigid": figures, "flexed": figures.get("deformed")}


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
            yield {"peer": "raygrid", "version": "", "model": model, "board": "free", "camera": camera,
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


# ---- Text ----------------------------------------------------------------------

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


def cells_of(figures):
    """Views of too few corners have none of boards that bend."""
    if not figures:
        return "– | – | –"
    return f"{tables.number(figures['median_px'])} | {tables.number(figures['rms_px'])} | {figures['count']}"


def order_of(row):
    flexed = row["both"]["flexed"]
    return (flexed is None, (flexed or row["both"]["rigid"])["median_px"])


def table(rows):
    lines = ["| program | model | board | rigid median | RMS | corners | flexed median | RMS | corners | own code |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    told = [row for row in rows if row.get("both") and is_imported(row)]
    for row in sorted(told, key=order_of):
        cells = [cells_of(row["both"][way]) for way in ("rigid", "flexed")]
        lines.append(f"| {tables.name_of(row)} | {row['model']} | {row['board']} | {cells[0]} | {cells[1]} | "
                     f"{own_code(row)} |")
    return lines


def reasons(rows):
    lines = tables.failures(rows)
    for row in rows:
        label = f"Not there: {tables.name_of(row)} {row['model']}, {row.get('board')}:"
        if "camera" in row and not row["both"]:
            lines.append(f"{label} raygrid does not take it.")
        elif "camera" in row and not is_imported(row):
            lines.append(f"{label} its import has a rigid median of "
                         f"{tables.number(row['both']['rigid']['median_px'])}, its own code {own_code(row)}.")
    return lines


def text(found, absent):
    lines = [RULE, ""]
    lines += [f"Skipped, as it was not there: {name}." for name in absent] + [""] * bool(absent)
    for result in found:
        lines += [f"### {result['job']['title']}, both ways", ""] + table(result["rows"])
        more = reasons(result["rows"])
        lines += [""] + more + [""] * bool(more)
    return lines
