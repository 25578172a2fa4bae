"""Markdown of the accuracy's results, and README.md's figures among them."""
import sets

RULE = """Each program calibrates from the `train` images of `split.csv`. Then the camera and the board are fixed, and each held-out
image is localised: least squares of reprojection errors under Huber's loss of 1 px, without corners that are more than 3 px and
six times the median off. Figures are the lengths of the reprojection errors of all held-out corners, the ones left out too,
in pixels. All programs localise by this rule, from the same starting poses, and each with its own board: `calibrateCameraRO`'s new
points, mrcal's warp (two numbers), raygrid's `pattern.yaml`. *Free* is a board each of whose corners may lie anywhere.
raygrid localises by its own code, peers by `tools/measure/localization.py`; a raygrid camera that both localise shows that it
makes no difference (last line of each set). Where raygrid counts fewer corners, the others lie outside its calibrated area or what
its model can show. Rows are in the order of the held-out median. `train` is the median of the images
that were calibrated with. Peers of two versions that agree to 0.001 px have one row. Seconds are those of one calibration on a
machine that may have had other work; only raygrid's have a choice of the grid's resolution among them, and files.

Peers' settings: OpenCV's calibrations take up to 100 iterations and, where they leave more than 1 px, the better of their own start
and a rough focal length (`cv::fisheye` always, with and without `CALIB_CHECK_COND`). mrcal has its outlier rejection, regularisation
and the passes of `mrcal-calibrate-cameras`, three sizes of splines, and starts from the poses that all localise from, since
its own start fails on some sets. raygrid has its defaults."""


def number(value):
    return f"{value:.3f}"


def is_same(first, second):
    keys = ("model", "board", "peer", "parameters")
    if "failed" in first or "failed" in second or any(first[k] != second[k] for k in keys):
        return False
    pairs = [(first["train"]["median"], second["train"]["median"])]
    pairs += [(first["test"][k], second["test"][k]) for k in ("median", "rms", "p95")]
    return all(abs(a - b) < 1e-3 for a, b in pairs)


def merged(rows):
    """Rows of two versions as one where they agree."""
    left = []
    for row in rows:
        twin = next((r for r in left if is_same(r, row)), None)
        if twin:
            twin["version"] += ", " + row["version"]
        else:
            left.append(dict(row))
    return left


def name_of(row):
    return f"{row['peer']} {row['version']}".strip()


def table(rows):
    lines = ["| program | model | board | parameters | train | held-out median | RMS | 95 % | corners | seconds |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    for row in sorted((r for r in merged(rows) if "failed" not in r), key=lambda r: r["test"]["median"]):
        test = row["test"]
        lines.append(f"| {name_of(row)} | {row['model']} | {row['board']} | {row['parameters']} | "
                     f"{number(row['train']['median'])} | {number(test['median'])} | {number(test['rms'])} | "
                     f"{number(test['p95'])} | {test['count']} | {row['seconds']:.1f} |")
    return lines


def failures(rows):
    reasons = {}
    for row in rows:
        if "failed" in row:
            reasons.setdefault((row["peer"], row["failed"]), []).append(f"{row['version']} {row['model']}")
    return [f"Not there: {peer} {', '.join(names)}: {reason}." for (peer, reason), names in reasons.items()]


def best(rows, figure, of_raygrid):
    found = [r for r in rows if "failed" not in r and (r["peer"] == "raygrid") == of_raygrid]
    return min(found, key=lambda r: r["test"][figure])


def verdict(rows):
    """Who is better, by each figure: raygrid's default, its best, and the best of all peers' settings."""
    if not any(r["peer"] != "raygrid" and "failed" not in r for r in rows):
        return "No peer calibrates from this set."
    default = find(rows, "raygrid", "central-generic", "free")
    words = []
    for figure, what in (("median", "median"), ("rms", "RMS")):
        own, other = best(rows, figure, True), best(rows, figure, False)
        ours, theirs, usual = (r["test"][figure] for r in (own, other, default))
        if ours < 0.98 * theirs:
            word = "raygrid is better"
        elif ours > 1.02 * theirs:
            word = "raygrid is worse"
        else:
            word = "they are within 2 %"
        words.append(f"{what}: {word} ({number(ours)} with {own['model']}, {number(usual)} with its default; "
                     f"{number(theirs)} with {name_of(other)}, {other['model']})")
    return "Best of each by " + "; by ".join(words) + "."


def find(rows, peer, model, board):
    """The row of the oldest version, if there is one."""
    return next((r for r in rows if (r["peer"], r["model"], r["board"]) == (peer, model, board)), None)


def set_text(result):
    rows, job = result["rows"], result["job"]
    lines = [f"### {job['title']}", ""] + table(rows) + ["", verdict(rows)] + failures(rows)
    by_raygrid = find(rows, "raygrid", "opencv", "flat")["test"]
    by_peers = result["by_peers_rule"]
    lines += [f"One camera (raygrid opencv, flat) localised by raygrid: median {by_raygrid['median']:.4f} of "
              f"{by_raygrid['count']} corners; by the peers' code: {by_peers['median']:.4f} of {by_peers['count']}.", ""]
    return lines


# ---- Corners, model and board --------------------------------------------------

DECOMPOSITION = (
    ("OpenCV", "calibrateCamera, 5 terms", "flat"), ("OpenCV", "calibrateCamera, 12 terms", "flat"),
    ("mrcal", "OPENCV8", "flat"), ("raygrid", "opencv", "flat"), ("raygrid", "central-generic", "flat"),
    ("raygrid", "noncentral-generic", "flat"), ("mrcal", "OPENCV8", "warped"),
    ("OpenCV", "calibrateCameraRO, 5 terms", "free"), ("OpenCV", "calibrateCameraRO, 12 terms", "free"),
    ("raygrid", "opencv", "free"), ("raygrid", "central-generic", "free"), ("raygrid", "noncentral-generic", "free"))


def median_of(row):
    return number(row["test"]["median"]) if row and "test" in row else "–"


def decomposition_text(results):
    rows_of = {(r["job"].get("side"), r["job"].get("corners")): r["rows"] for r in results}
    heads = [corners for corners, _ in sets.CORNERS]
    lines = ["OpenCV's photographs, 10 to calibrate from and 3 held out of each camera; Debian's peers. Held-out median in",
             "px, left / right camera, by corners. Errors beside different corners have these corners' noise in them.", "",
             "| model | board | " + " | ".join(heads) + " |", "|---" * (len(heads) + 2) + "|"]
    for peer, model, board in DECOMPOSITION:
        cells = []
        for corners in heads:
            rows = [find(rows_of.get((side, corners), []), peer, model, board) for side in sets.SIDES]
            cells.append(" / ".join(median_of(row) for row in rows))
        lines.append(f"| {peer} {model} | {board} | " + " | ".join(cells) + " |")
    return lines + [""]


# ---- Figures of README.md ------------------------------------------------------

# Set, program, model, board.
RAYGRID_MODELS = ("thin-prism-fisheye", "central-generic", "noncentral-generic")
README_FIGURES = (
    ("left-sub-pix-5", "OpenCV", "calibrateCamera, 5 terms", "flat"),
    ("left-sub-pix-5", "OpenCV", "calibrateCameraRO, 5 terms", "free"),
    ("left-sub-pix-5", "OpenCV", "calibrateCameraRO, 14 terms", "free"),
    ("left-sub-pix-5", "mrcal", "splined 7 × 6", "flat"), ("left-sub-pix-5", "mrcal", "splined 7 × 6", "warped"),
    *(("left-sub-pix-5", "raygrid", model, board) for model in RAYGRID_MODELS for board in ("flat", "free")),
    ("fisheye_190", "OpenCV", "fisheye::calibrate", "flat"),
    ("fisheye_190", "mrcal", "splined 34 × 22", "flat"), ("fisheye_190", "mrcal", "splined 34 × 22", "warped"),
    *(("fisheye_190", "raygrid", model, board) for model in RAYGRID_MODELS for board in ("flat", "free")),
    ("left-raygrid", "raygrid", "central-generic", "free"),
    ("left-raygrid", "OpenCV", "calibrateCameraRO, 5 terms", "free"),
)


def readme_figures(results, blob_bytes):
    by_name = {r["job"]["name"]: r for r in results}
    lines = ["Held-out medians, from the tables below, and the blob of README.md's commands.", "",
             "| figure | set | program | model | board |", "|---|---|---|---|---|"]
    for name, peer, model, board in README_FIGURES:
        row = find(merged(by_name[name]["rows"]), peer, model, board) if name in by_name else None
        if not row or "test" not in row:
            continue
        lines.append(f"| {number(row['test']['median'])} px | {by_name[name]['job']['title']} | {name_of(row)} | "
                     f"{model} | {board} |")
    lines.append(f"| {blob_bytes / 1000:.1f} kB | left camera's photographs | raygrid | "
                 "`pack --remap 640x480,hfov=60` | free |")
    return lines
