#!/usr/bin/env python3
"""Writes the tables of README.md and benchmarks/README.md between <!-- NAME --> and <!-- end -->, from the CSV files
of benchmarks/ and runtime/cost/; tools/measure_readme does so, too.

Usage: tools/measure/page.py [FOLDER]
"""
import csv
import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
FOLDER = os.path.join(HERE, "..", "..", "benchmarks")
COST = os.path.join(HERE, "..", "..", "runtime", "cost")
PROGRAMS = ("OpenCV", "mrcal", "raygrid")
TABLE = re.compile(r"(<!-- (?!end)(\w+) -->\n).*?(?=<!-- end -->)", re.DOTALL)
# Sets of images, and how the page calls them.
PHOTOGRAPHS = {"left-sub-pix-5": "left camera, `cornerSubPix`", "left-raygrid": "left camera, `raygrid detect`",
               "right-sub-pix-5": "right camera, `cornerSubPix`", "right-raygrid": "right camera, `raygrid detect`"}
PUBLISHED = {"photo_carnd_wide": "GoPro", "photo_carnd_cal": "dash camera", "photo_camodocal": "camodocal",
             "photo_vins": "VINS-Fusion"}
SETS = {**PHOTOGRAPHS, **{name: f"`{name}`" for name in (*PUBLISHED, "picamera_chessboard", "webcam_charuco",
                                                         "fisheye_190")}}
# Columns and rows of README.md's table; the models of a row as a regular expression.
README_SETS = {**PUBLISHED, "left-sub-pix-5": "OpenCV's left camera", "picamera_chessboard": "Raspberry Pi",
               "webcam_charuco": "webcam", "fisheye_190": "190° fisheye"}
PARAMETRIC, GENERIC = "opencv|thin-prism-fisheye", "central-generic|noncentral-generic"
MODELS = (("OpenCV `calibrateCamera` / `calibrateCameraRO`", "OpenCV", "calibrateCamera.*"),
          ("OpenCV `cv::fisheye`", "OpenCV", "fisheye.*"), ("mrcal `OPENCV8`, `OPENCV12`", "mrcal", "OPENCV.*"),
          ("mrcal `SPLINED_STEREOGRAPHIC`", "mrcal", "splined.*"),
          ("raygrid `opencv`, `thin-prism-fisheye`", "raygrid", PARAMETRIC),
          ("raygrid `central-generic`, `noncentral-generic`", "raygrid", GENERIC))
CORNERS = {"sub-pix-5": "`cornerSubPix`, 11 px", "sub-pix-11": "`cornerSubPix`, 23 px",
           "sector": "`findChessboardCornersSB`", "raygrid": "`raygrid detect`"}
CORNER_ROWS = (("OpenCV", "calibrateCamera, 5 terms", "nominal"), ("raygrid", "central-generic", "nominal"),
               ("mrcal", "OPENCV8", "warp"), ("OpenCV", "calibrateCameraRO, 5 terms", "estimated"),
               ("raygrid", "opencv", "estimated"), ("raygrid", "central-generic", "estimated"))
MIN_CORNERS = 0.99  # part of a set's held-out corners
KERNELS = ("portable", "sse4", "avx2", "avx512")
CORES = ("cortex-m0plus", "cortex-m4", "cortex-m55", "rv32")


def read_text(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def read_rows(folder, name):
    with open(os.path.join(folder, name + ".csv"), encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def markdown(head, rows):
    """A table's text."""
    lines = [head, ["---"] * len(head), *rows]
    return "".join(("|" + "|".join(line) + "|" if line[0] == "---" else "| " + " | ".join(line) + " |") + "\n"
                   for line in lines)


# ---- Accuracy ------------------------------------------------------------------

def select(rows, **values):
    return [row for row in rows if all(row[key] == value for key, value in values.items())]


def read_accuracy(folder):
    """Rows of accuracy.csv without those that lack more of the held-out corners than others, which are harder ones."""
    rows, most = read_rows(folder, "accuracy"), {}
    for row in rows:
        most[row["set"]] = max(most.get(row["set"], 0), int(row["corners"] or 0))
    return [row for row in rows if not row["corners"] or int(row["corners"]) >= MIN_CORNERS * most[row["set"]]]


def is_estimated(row):
    return row["target"] != "nominal"


def best_of(rows, column):
    """The row with the smallest value; None if there is none."""
    return min((row for row in rows if row[column]), key=lambda row: float(row[column]), default=None)


def short(model):
    """A model without what the page says once."""
    model = re.sub(r"calibrateCamera(RO)?, ", "", model)
    return model.replace("fisheye::calibrate", "`cv::fisheye`").replace(" × ", "×")


def best_cell(rows, column):
    row = best_of(rows, column)
    return f"{row[column]} ({short(row['model'])})" if row else "–"


def model_lines(found, names, column, is_bold=False):
    """Lines of MODELS: for each set, the best of the models with nominal and with estimated targets."""
    def best(name, program, models, estimated):
        rows = [row for row in select(found, set=name, program=program)
                if re.fullmatch(models, row["model"]) and is_estimated(row) == estimated]
        row = best_of(rows, "median_px")
        return row[column] if row else "–"

    cells = [[[best(name, program, models, estimated) for estimated in (False, True)] for name in names]
             for _, program, models in MODELS]
    for i in range(len(names)) if is_bold else ():
        for k in (0, 1):
            lowest = min((line[i][k] for line in cells if line[i][k] != "–"), key=float, default="")
            for line in cells:
                line[i][k] = f"**{lowest}**" if line[i][k] == lowest else line[i][k]
    return [[label, *(" / ".join(cell).replace("– / –", "–") for cell in line)]
            for (label, *_), line in zip(MODELS, cells)]


def results_table(folder):
    return markdown(["model", *README_SETS.values()],
                    model_lines(read_accuracy(folder), README_SETS, "median_px", is_bold=True))


def accuracy_table(folder):
    """A row per set; of each program the best setting with nominal and with estimated targets."""
    found, lines = read_accuracy(folder), []
    for name, title in SETS.items():
        pairs = [[row for row in select(found, set=name) if is_estimated(row) == estimated]
                 for estimated in (False, True)]
        defaults = [best_of(select(rows, program="raygrid", model="central-generic"), "median_px") for rows in pairs]
        lines.append([title, *("; ".join(best_cell(select(rows, program=program), "median_px") for rows in pairs)
                               for program in PROGRAMS),
                      "; ".join(row["median_px"] if row else "–" for row in defaults)])
    return markdown(["images", *PROGRAMS, "`central-generic`"], lines)


def corners_table(folder):
    found, lines = read_rows(folder, "accuracy"), []
    for program, model, target in CORNER_ROWS:
        cells = []
        for kind in CORNERS:
            rows = [select(found, set=f"{side}-{kind}", program=program, model=model, target=target)
                    for side in ("left", "right")]
            cells.append("/".join(row[0]["median_px"] if row else "–" for row in rows))
        lines.append([f"{program} {short(model)}", target, *cells])
    return markdown(["model", "target", *CORNERS.values()], lines)


def deformation_table(folder):
    found, lines = read_rows(folder, "target_deformation"), []
    for name in dict.fromkeys(row["set"] for row in found):
        cells = []
        for program in PROGRAMS:
            row = best_of(select(found, set=name, program=program), "deformed_median_px")
            cells.append(f"{row['rigid_median_px']}/{row['deformed_median_px']}" if row else "–")
        lines.append([SETS[name], *cells])
    return markdown(["images", *PROGRAMS], lines)


# ---- Speed ---------------------------------------------------------------------

def remap_table(folder):
    found, lines = read_rows(folder, "remap_ratios"), []
    for name in dict.fromkeys(row["format"] for row in found):
        for rival in dict.fromkeys(row["rival"] for row in found):
            cells = []
            for kernels in KERNELS:
                ratios = sorted((row["ratio"] for row in select(found, format=name, rival=rival, kernels=kernels)),
                                key=float)
                cells.append(f"{ratios[0]}–{ratios[-1]}" if ratios else "–")
            lines.append([name, rival.split()[-1], *cells])
    return markdown(["format", "OpenCV", *KERNELS], lines)


def frames_table(folder):
    found, lines = select(read_rows(folder, "frame_rates"), threads="1", width_px="1920"), []
    formats = list(dict.fromkeys(row["format"] for row in found))
    for row in found:
        row["program"] = re.sub(r"(cv::remap .*), \w+ maps", r"\1, faster maps", row["program"])
    for program in dict.fromkeys(row["program"] for row in found):
        rates = [[row["frames_per_s"] for row in select(found, program=program, format=name)] for name in formats]
        lines.append([program, *(max(values, key=float, default="–") for values in rates)])
    return markdown(["program", *formats], lines)


def cost_rows(name):
    """A file of runtime/cost, by target and column."""
    return {row["target"]: row for row in read_rows(COST, name)}


def cost_table(_):
    code, instructions = cost_rows("code"), cost_rows("instructions")
    columns = ("unproject", "project", "undistort point", "GREY8", "NV12", "RGB24")
    lines = [[core, code[core]["rays"], code[core]["everything"],
              *(instructions[core][column] for column in columns)] for core in CORES]
    return markdown(["core", "bytes: rays", "everything", *columns], lines)


def runs_table(folder):
    rows = [row for row in read_rows(folder, "runs") if row["file"] not in ("localization", "remap_ratios", "sets")]
    return markdown(["file", "date", "machine"],
                    [[f"[`{row['file']}.csv`]({row['file']}.csv)", row["date"], row["machine"] or "–"] for row in rows])


TABLES = {"results": results_table, "accuracy": accuracy_table, "corners": corners_table,
          "deformation": deformation_table, "remap": remap_table, "frames": frames_table, "cost": cost_table,
          "runs": runs_table}


def with_tables(text, folder=FOLDER):
    """A page's text with the tables that the data give."""
    return TABLE.sub(lambda match: match.group(1) + TABLES[match.group(2)](folder), text)


def update(folder=FOLDER):
    for path in (os.path.join(folder, "README.md"), os.path.join(folder, "..", "README.md")):
        text = with_tables(read_text(path), folder)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)


if __name__ == "__main__":
    update(*sys.argv[1:2])
