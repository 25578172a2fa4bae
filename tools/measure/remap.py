"""Undistortion beside cv::remap of Debian's and of the newest OpenCV: remap_bench and remap_rival.py
in turn, on the same maps and frames."""
import math
import os
import re
import subprocess

import datasets
import progress

HERE = os.path.dirname(os.path.abspath(__file__))
WIDTHS = (1280, 1920, 3840)
ROUNDS = 3
FORMATS = ("GREY", "GREY nearest", "NV12", "RGB24")


def parse(text):
    """Megapixels a second by view, format and program, of what remap_bench prints."""
    speeds, view = {}, None
    for line in text.splitlines():
        head = re.match(r"(\S.*), (\d+) x (\d+): blocks", line)
        if head:
            view = head.group(1)
        row = re.match(r"  (%s) +(.*) Mpx/s" % "|".join(sorted(FORMATS, reverse=True)), line)
        if view and row:
            speeds.setdefault(view, {})[row.group(1)] = {
                name: float(value) for name, value in re.findall(r"(\S+) (\d+)(?: \([\d.]+\))?", row.group(2))}
    return speeds


def name_rival(speeds, version):
    for formats in speeds.values():
        for name, found in formats.items():
            formats[name] = {f"cv::remap {version}" if k == "cv::remap" else k: v for k, v in found.items()}


def measure(options, width, number):
    """One round: each program for some seconds."""
    maps = os.path.join(options.work, "maps")
    os.makedirs(maps, exist_ok=True)
    bench = subprocess.run([options.remap_bench, "--write", maps, str(width)], capture_output=True, text=True,
                           check=True).stdout
    speeds = parse(bench)
    name_rival(speeds, datasets.read_json(os.path.join(maps, "views.json"))["opencv"])
    if options.new_python:
        rival = os.path.join(maps, "rival.json")
        subprocess.run([options.new_python, os.path.join(HERE, "remap_rival.py"), maps, rival], check=True)
        for view, formats in datasets.read_json(rival).items():
            for name, speed in formats.items():
                speeds[view][name].update(speed)
    datasets.write_json(os.path.join(options.work, f"remap-{width}-{number}.json"), speeds)


def steps(options):
    return [progress.Step(f"remap, {width} px wide, round {number + 1}", 15 * width / 1000,
                          lambda w=width, n=number: measure(options, w, n))
            for number in range(ROUNDS) for width in WIDTHS]


def results(options):
    """Medians of the rounds, by width."""
    by_width = {}
    for width in WIDTHS:
        rounds = [datasets.read_json(os.path.join(options.work, f"remap-{width}-{n}.json")) for n in range(ROUNDS)]
        by_width[width] = {
            view: {name: {program: sorted(r[view][name][program] for r in rounds)[ROUNDS // 2]
                          for program in formats[name]} for name in formats}
            for view, formats in rounds[0].items()}
    return by_width


def processor():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        return re.search(r"model name\s*: (.*)", file.read()).group(1)


def mean_ratio(by_width, view, name, first, second):
    """Geometric mean over the widths."""
    logs = [math.log(m[view][name][first] / m[view][name][second]) for m in by_width.values()]
    return math.exp(sum(logs) / len(logs))


def is_rival(program):
    return program.startswith("cv::remap")


def ratio_rows(by_width):
    """Rows of remap_ratios.csv: how many times faster raygrid's kernels are than each rival."""
    first = next(iter(by_width.values()))
    for name in FORMATS:
        programs = first[next(iter(first))][name]
        for kernel in programs:
            for rival in programs:
                if is_rival(kernel) or not is_rival(rival):
                    continue
                for view in first:
                    yield {"format": name, "kernels": kernel, "rival": rival, "view": view,
                           "ratio": f"{mean_ratio(by_width, view, name, kernel, rival):.2f}"}


def speed_rows(by_width):
    """Rows of remap.csv."""
    for width, views in by_width.items():
        for view, formats in views.items():
            for name in FORMATS:
                for program, speed in formats[name].items():
                    label = program if is_rival(program) else "raygrid " + program
                    yield {"width_px": width, "view": view, "format": name, "program": label,
                           "mpx_per_s": f"{speed:.0f}"}
