#!/usr/bin/env python3
"""Frames a second of raygridundistort beside cameraundistort of gstreamer1.0-opencv, in pipelines
that are the same but for the element: one frame again and again, undistorted and thrown away.

  element_bench.py --raygrid build/host/bin/raygrid --plugin build/host/lib/gstreamer-1.0

Each element takes its turn, five times; medians are printed, and the processor's share. Without an
element, the pipeline takes next to no time. cameraundistort has the same lens, as OpenCV's model of
it. It takes neither NV12 nor YUY2."""
import argparse
import os
import resource
import statistics
import subprocess
import tempfile
import time

ROUNDS, FRAMES = 5, 400
SIZES = ((640, 480), (1920, 1080))
FORMATS = ("GRAY8", "RGB", "NV12", "YUY2")
THEIRS = ("GRAY8", "RGB")


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def measure(pipeline, frames, environment):
    """Wall and processor seconds."""
    start, before = time.monotonic(), cpu_seconds()
    subprocess.run(["gst-launch-1.0", "-q", *pipeline(frames)], env=environment, check=True)
    return time.monotonic() - start, cpu_seconds() - before


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--raygrid", required=True)
    parser.add_argument("--plugin", required=True, help="the folder of libgstraygrid.so")
    arguments = parser.parse_args()
    environment = {**os.environ, "GST_PLUGIN_PATH": os.path.abspath(arguments.plugin)}
    has_theirs = subprocess.run(["gst-inspect-1.0", "cameraundistort"], capture_output=True,
                                check=False).returncode == 0
    if not has_theirs:
        print("without cameraundistort: apt-get install gstreamer1.0-opencv")
    print("| format | size | raygridundistort | 2 threads | cameraundistort | ratio |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for width, height in SIZES:
            settings, blob = make_lens(arguments.raygrid, folder, width, height)
            for name in FORMATS:
                elements = {"ours": ["raygridundistort", f"blob={blob}"],
                            "two": ["raygridundistort", f"blob={blob}", "threads=2"]}
                if has_theirs and name in THEIRS:
                    elements["theirs"] = ["cameraundistort", f'settings="{settings}"']
                print_row(name, width, height, elements, environment)


def print_row(name, width, height, elements, environment):
    def pipeline_of(element):
        caps = f"video/x-raw,format={name},width={width},height={height},framerate=30/1"
        return lambda frames: ["videotestsrc", "num-buffers=1", "pattern=snow", "!", caps, "!",
                               "imagefreeze", f"num-buffers={frames}", "!", *element, "!",
                               "fakesink", "sync=false"]

    seconds = {which: [] for which in elements}
    for _ in range(ROUNDS):
        for which, element in elements.items():
            few = measure(pipeline_of(element), 1, environment)
            many = measure(pipeline_of(element), FRAMES + 1, environment)
            seconds[which].append((many[0] - few[0], many[1] - few[1]))
    medians = {which: (statistics.median(wall for wall, _ in times),
                       statistics.median(cpu for _, cpu in times))
               for which, times in seconds.items()}

    def cell(which):
        if which not in medians:
            return "-"
        wall, cpu = medians[which]
        return f"{FRAMES / wall:.0f} ({100 * cpu / wall:.0f} %)"

    ratio = f"{medians['theirs'][0] / medians['ours'][0]:.1f}" if "theirs" in medians else "-"
    print(f"| {name} | {width} x {height} | {cell('ours')} | {cell('two')} | "
          f"{cell('theirs')} | {ratio} |", flush=True)


def make_lens(raygrid, folder, width, height):
    """The settings of cameraundistort, and a blob, of one lens in views of the frames' size."""
    path = os.path.join(folder, f"{width}")
    lens, blob = path + ".yaml", path + ".raygrid"
    for command in (("simulate", "--images", "1", "--lens", "pinhole", "--size", f"{width}x{height}",
                     "-o", path),
                    ("fit", path + "/true_camera.yaml", "--model", "opencv", "-o", lens),
                    ("pack", lens, "--remap", f"{width}x{height},alpha=0", "-o", blob),
                    ("export", lens, "--to", "opencv", "-o", path + ".yml")):
        subprocess.run([raygrid, *command], check=True, stdout=subprocess.DEVNULL)
    with open(path + ".yml", encoding="utf-8") as file:
        text = file.read()
    matrices = text[text.index("camera_matrix:"):]
    matrices = matrices.replace("camera_matrix", "cameraMatrix")
    matrices = matrices.replace("distortion_coefficients", "distCoeffs")
    end = matrices.index("]", matrices.index("distCoeffs")) + 1
    return "%YAML:1.0\n---\n" + matrices[:end] + "\n", blob


if __name__ == "__main__":
    main()
