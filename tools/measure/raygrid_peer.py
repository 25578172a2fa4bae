"""raygrid's calibrations of one set: raygrid_peer.py JOB.json RESULT.json"""
import os
import re
import subprocess
import time

import numpy as np

import datasets
import localization
import peer

MODELS = ("central-generic", "noncentral-generic", "central-radial", "thin-prism-fisheye", "opencv")
FEW_MODELS = ("central-generic", "noncentral-generic", "opencv")
WITHOUT_RESULT = (1, 2, 3, 4, 7, 8)  # exit codes


def run(raygrid, arguments, log):
    """Runs raygrid; True if it wrote a result."""
    done = subprocess.run([raygrid, *arguments, "--quiet"], capture_output=True, text=True, check=False)
    with open(log, "w", encoding="utf-8") as file:
        file.write(done.stdout + done.stderr)
    return done.returncode not in WITHOUT_RESULT and done.returncode > -1


def calibrate_arguments(job, output):
    width, height = job["image_size"]
    return ["calibrate", "--features", os.path.join(job["folder"], "features.csv"),
            "--pattern", os.path.join(job["folder"], "pattern.yaml"),
            "--image-size", f"{width}x{height}", "--skip-comparison", "-o", output]


def write_starts(job, raygrid):
    """Adds poses.csv of all images, by a camera that is used for nothing else, and its focal length."""
    output = os.path.join(job["work"], "starts")
    arguments = calibrate_arguments(job, output) + ["--model", "thin-prism-fisheye", "--fix-target-geometry"]
    if not run(raygrid, arguments, output + ".log"):
        raise RuntimeError(f"no poses to start from; see {output}.log")
    job["poses"] = os.path.join(output, "poses.csv")
    if not job["focal_px"]:
        job["focal_px"] = read_parameters(os.path.join(output, "camera.yaml"))["fx"]
        job["fov_deg"] = round(np.degrees(job["image_size"][0] / job["focal_px"]))


def error_norms(output):
    """Residual norms of the result's training and held-out corners."""
    norms = {"train": [], "test": []}
    for row in datasets.read_csv(os.path.join(output, "residuals.csv")):
        part = "test" if row["set"] == "held-out" else "train"
        norms[part].append(np.hypot(float(row["dx"]), float(row["dy"])))
    return {part: np.array(values) for part, values in norms.items()}


def row_of(job, raygrid, model, is_flat):
    output = os.path.join(job["work"], model + ("-flat" if is_flat else ""))
    parts = datasets.read_split(job["folder"])
    held_out = ",".join(image for image, part in parts.items() if part == "test")
    arguments = calibrate_arguments(job, output) + ["--model", model, "--hold-out", held_out]
    begin = time.perf_counter()
    row = {"peer": "raygrid", "version": "", "model": model, "target": "nominal" if is_flat else "estimated"}
    if not run(raygrid, arguments + ["--fix-target-geometry"] * is_flat, output + ".log"):
        return {**row, "failed": f"ends in an error, see {output}.log"}
    row["seconds"] = time.perf_counter() - begin
    row["parameters"] = datasets.read_json(os.path.join(output, "result.json"))["parameters"]
    for part, norms in error_norms(output).items():
        row[part] = localization.figures(norms)
    return row


# ---- The rule of localisation, in both programs ------------------------------

def read_parameters(path):
    """Of a parametric camera.yaml, which has one a line."""
    with open(path, encoding="utf-8") as file:
        found = re.findall(r"^  (\w+): ([-\d.e]+)$", file.read(), re.MULTILINE)
    return {name: float(value) for name, value in found}


def read_opencv_camera(path):
    """Projection of a camera.yaml of model opencv."""
    k = read_parameters(path)

    def project(points):
        x, y = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
        r2 = x * x + y * y
        g = ((1 + r2 * (k["k1"] + r2 * (k["k2"] + r2 * k["k3"]))) /
             (1 + r2 * (k["k4"] + r2 * (k["k5"] + r2 * k["k6"]))))
        u = x * g + 2 * k["p1"] * x * y + k["p2"] * (r2 + 2 * x * x)
        v = y * g + k["p1"] * (r2 + 2 * y * y) + 2 * k["p2"] * x * y
        return np.stack([k["fx"] * u + k["cx"], k["fy"] * v + k["cy"]], axis=1)
    return project


def localized_by_peers_rule(job):
    """raygrid's opencv camera and flat board, localised as peers' are."""
    data = datasets.DataSet(job)
    project = read_opencv_camera(os.path.join(job["work"], "opencv-flat", "camera.yaml"))
    return localization.figures(localization.errors_px(project, data.flat_board(), data.test, data.starts))


def rows_of(job, raygrid):
    for model in FEW_MODELS if job["few"] else MODELS:
        for is_flat in (False, True):
            yield row_of(job, raygrid, model, is_flat)
