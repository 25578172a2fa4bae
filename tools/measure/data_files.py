"""The files of benchmarks/ that tools/measure_readme writes. Each part of the measurements replaces its own."""
import csv
import datetime
import os

import both_ways
import frame_paths
import remap
import tables

COLUMNS = {
    "accuracy": ("set", "program", "version", "model", "target", "parameters", "train_median_px", "median_px", "rms_px",
                 "p95_px", "corners", "seconds", "failure"),
    "localization": ("set", "raygrid_median_px", "raygrid_corners", "peers_median_px", "peers_corners"),
    "sets": ("set", "description"),
    "blob": ("command", "value", "unit"),
    "target_deformation": ("set", "program", "version", "model", "target", "rigid_median_px", "rigid_rms_px",
                           "rigid_corners", "deformed_median_px", "deformed_rms_px", "deformed_corners",
                           "own_code_median_px", "failure"),
    "remap": ("width_px", "view", "format", "program", "mpx_per_s"),
    "remap_ratios": ("format", "kernels", "rival", "view", "ratio"),
    "frame_rates": ("program", "threads", "format", "width_px", "height_px", "frames_per_s", "processor_percent"),
    "runs": ("file", "date", "machine", "raygrid"),
}


def path_of(folder, name):
    return os.path.join(folder, name + ".csv")


def write(folder, name, rows):
    with open(path_of(folder, name), "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS[name], restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def write_run(folder, names, version):
    """When, where and with which raygrid these files were measured."""
    with open(path_of(folder, "runs"), encoding="utf-8", newline="") as file:
        rows = {row["file"]: row for row in csv.DictReader(file)}
    for name in names:
        rows[name] = {"file": name, "date": datetime.date.today().isoformat(), "raygrid": version,
                      "machine": f"{os.cpu_count()} processors, {remap.processor()}"}
    write(folder, "runs", rows.values())


def accuracy_files(results, blob_bytes):
    return {"accuracy": tables.accuracy_rows(results), "localization": tables.localization_rows(results),
            "sets": tables.set_rows(results),
            "blob": [{"command": "pack --remap 640x480,hfov=60", "value": f"{blob_bytes / 1000:.1f}", "unit": "kB"}]}


def both_ways_files(measured):
    return {"target_deformation": both_ways.data_rows(measured)}


def remap_files(measured):
    return {"remap": remap.speed_rows(measured), "remap_ratios": remap.ratio_rows(measured)}


def paths_files(measured):
    return {"frame_rates": frame_paths.data_rows(measured)}
