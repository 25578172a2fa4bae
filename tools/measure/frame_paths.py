"""Frames a second of every way of a frame through raygrid, beside programs that undistort frames: the same
lens and, but for cameraundistort, the same view. Each way is one command, told how many frames to undistort;
what it takes for one frame only is subtracted."""
import os
import statistics
import subprocess
import threading
import time
from typing import Callable, NamedTuple

import numpy as np

import progress
from remap import processor

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
SIZES = ((640, 480), (1920, 1080))
FORMATS = ("GREY", "NV12", "RGB")
ROUNDS, SECONDS = 3, 1.2
CHANNELS = {"GREY": 1, "NV12": 1.5, "RGB": 3}
GSTREAMER = {"GREY": "GRAY8", "NV12": "NV12", "RGB": "RGB"}
FFMPEG = {"GREY": "gray", "RGB": "rgb24"}
LIBCAMERA = {"GREY": "R8", "NV12": "NV12", "RGB": "BGR888"}
THREADS = os.cpu_count() or 1


class Setup(NamedTuple):
    """What the commands of one size need."""
    folder: str
    width: int
    height: int
    out: str = "/dev/null"


class Way(NamedTuple):
    """The command for a setup, a format and a number of frames; whether frames come on standard input."""
    name: str
    threads: int
    command: Callable[[Setup, str, int], list[str]]
    formats: tuple[str, ...] = FORMATS
    fed: bool = False
    can_write: bool = True


def ways(options):
    """Those that this machine has, and the names of those that it has not."""
    build = os.path.dirname(os.path.dirname(os.path.abspath(options.raygrid)))
    found, absent = [], []

    def add(name, there, threads, command, **more):
        if there:
            found.extend(Way(name, n, lambda s, f, k, n=n: command(s, f, k, n), **more) for n in threads)
        else:
            absent.append(name)

    def loop(python, program, kind="fixed"):
        return lambda s, f, k, n: [python, os.path.join(HERE, "frame_loop.py"), program, s.folder, f, str(k),
                                   str(n), s.out, kind]

    def node(s, f, k, _):
        return ["node", os.path.join(HERE, "frame_loop.mjs"), os.path.join(ROOT, "runtime/wasm/raygrid.js"),
                s.folder, f, str(k), s.out]

    def camera(s, f, _, n):
        return [os.path.join(build, "bin/raygrid-camera"), os.path.join(s.folder, "view.raygrid"), "--from", "-",
                "--format", LIBCAMERA[f], "--size", f"{s.width}x{s.height}", "--every-frame", "--threads", str(n),
                "--quiet", "-o", "-"]

    def pipeline(element):
        def command(s, f, k, n):
            caps = f"video/x-raw,format={GSTREAMER[f]},width={s.width},height={s.height},framerate=30/1"
            return ["gst-launch-1.0", "-q", "videotestsrc", "num-buffers=1", "pattern=snow", "!", caps, "!",
                    "imagefreeze", f"num-buffers={k}", "!", *element(s, n), "!", "fakesink", "sync=false"]
        return command

    def ffmpeg(s, f, k, n):
        maps = [f"{s.folder}/maps_{axis}.pgm" for axis in "xy"]
        form = "gray" if f == "GREY" else "color"
        return ["ffmpeg", "-v", "error", "-y", "-threads", str(n), "-filter_complex_threads", str(n), "-f", "rawvideo",
                "-pix_fmt", FFMPEG[f], "-s", f"{s.width}x{s.height}", "-i", "-", "-i", maps[0], "-i", maps[1],
                "-filter_complex", f"[0][1][2]remap=format={form}", "-frames:v", str(k), "-f", "rawvideo", "-pix_fmt",
                FFMPEG[f], s.out]

    every = sorted({1, min(THREADS, 4)})
    add("raygrid, the library", True, (1,), loop("/usr/bin/python3", "raygrid"))
    add("raygrid, WebAssembly in Node", has("node", "--version"), (1,), node)
    add("raygrid, GStreamer", has("gst-inspect-1.0", "imagefreeze"), every,
        pipeline(lambda s, n: ["raygridundistort", f"blob={s.folder}/view.raygrid", f"threads={n}"]),
        can_write=False)
    add("raygrid-camera, of a pipe", True, every, camera, fed=True, can_write=False)
    for kind in ("fixed", "float"):
        add(f"cv::remap {opencv_version('/usr/bin/python3')}, {kind} maps", True, every,
            loop("/usr/bin/python3", "opencv", kind))
        if options.new_python:
            add(f"cv::remap {opencv_version(options.new_python)}, {kind} maps", True, every,
                loop(options.new_python, "opencv", kind))
    add("cameraundistort of GStreamer", has("gst-inspect-1.0", "cameraundistort"), (1,), formats=("GREY", "RGB"),
        command=pipeline(lambda s, _: ["cameraundistort", f'settings="{read(s.folder + "/settings.yml")}"']),
        can_write=False)
    add("ffmpeg, remap (nearest)", has("ffmpeg", "-version"), every, ffmpeg, formats=("GREY", "RGB"), fed=True)
    return found, absent


def has(*command):
    try:
        return subprocess.run(command, capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        return False


def opencv_version(python):
    return subprocess.run([python, "-c", "import cv2; print(cv2.__version__)"], capture_output=True, text=True,
                          check=True).stdout.strip()


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def frame_bytes(setup, name):
    return int(setup.width * setup.height * CHANNELS[name])


def environment(options):
    build = os.path.dirname(os.path.dirname(os.path.abspath(options.raygrid)))
    return {**os.environ, "GST_PLUGIN_PATH": os.path.join(build, "lib/gstreamer-1.0"),
            "PYTHONPATH": os.path.join(ROOT, "runtime/python"), "PYTHONDONTWRITEBYTECODE": "1",
            "RAYGRID_LIBRARY": os.path.join(build, "runtime/libraygrid.so")}


def run(command, environ, frame=b"", frames=0):
    """Seconds by the clock and of processors. The same frame is fed as often as it says."""
    start = time.monotonic()
    with subprocess.Popen(command, env=environ, stdin=subprocess.PIPE if frames else subprocess.DEVNULL,
                          stdout=subprocess.DEVNULL) as process:
        feeder = threading.Thread(target=feed, args=(process.stdin, frame, frames))
        if frames:
            feeder.start()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        seconds = time.monotonic() - start
        if frames:
            feeder.join()
    if process.returncode != 0:
        raise subprocess.CalledProcessError(process.returncode, command)
    return seconds, usage.ru_utime + usage.ru_stime


def feed(pipe, frame, frames):
    try:
        for _ in range(frames):
            pipe.write(frame)
        pipe.close()
    except BrokenPipeError:
        pass  # the command has ended, which is told by its status


def prepare(options, width, height):
    """One lens, its view as a blob, as maps and as cameraundistort's settings, and frames of a picture."""
    setup = Setup(os.path.join(options.work, f"{width}x{height}"), width, height)
    path = setup.folder
    for command in (("simulate", "--images", "1", "--lens", "pinhole", "--size", f"{width}x{height}", "-o", path),
                    ("fit", path + "/true_camera.yaml", "--model", "opencv", "-o", path + "/lens.yaml"),
                    ("pack", path + "/lens.yaml", "--remap", f"{width}x{height},alpha=0", "-o", path + "/view.raygrid"),
                    ("export", path + "/view.raygrid", "--rectified", "--to", "maps", "-o", path + "/maps.npz"),
                    ("export", path + "/view.raygrid", "--rectified", "--to", "ffmpeg", "-o", path + "/maps.pgm"),
                    ("export", path + "/lens.yaml", "--to", "opencv", "-o", path + "/lens.yml")):
        subprocess.run([options.raygrid, *command], check=True, stdout=subprocess.DEVNULL)
    text = read(path + "/lens.yml")
    text = text[text.index("camera_matrix:"):].replace("camera_matrix", "cameraMatrix")
    text = text.replace("distortion_coefficients", "distCoeffs")
    with open(path + "/settings.yml", "w", encoding="utf-8") as file:
        file.write("%YAML:1.0\n---\n" + text[:text.index("]", text.index("distCoeffs")) + 1] + "\n")
    y, x = np.mgrid[0:height, 0:width]
    grey = (128 + 60 * np.sin(x / 9) + 60 * np.sin(y / 7)).astype(np.uint8)
    pictures = {"GREY": grey, "RGB": np.dstack([grey, 255 - grey, grey[::-1]]),
                "NV12": np.concatenate([grey, grey[:height // 2]])}
    for name, picture in pictures.items():
        picture.tofile(os.path.join(path, name + ".raw"))
    return setup


def check_pictures(options, setup, found):
    """Every way that can write a picture makes the same one, within rounding. ffmpeg takes the nearest pixels."""
    results = {}
    for way in found:
        if not way.can_write or way.threads != 1:
            continue
        out = os.path.join(setup.folder, "result.raw")
        with open(os.path.join(setup.folder, "GREY.raw"), "rb") as file:
            run(way.command(setup._replace(out=out), "GREY", 1), environment(options), file.read(), int(way.fed))
        results[way.name] = np.fromfile(out, np.uint8).astype(float)
    first = next(iter(results.values()))
    for name, picture in results.items():
        apart = np.sqrt(np.mean((picture - first) ** 2))
        if not apart < (8 if "nearest" in name else 0.6):
            raise RuntimeError(f"the picture of {name} is {apart:.2f} grey values from that of raygrid")


def measure(options, setup, found):
    """Frames a second and the share of a processor, by way, number of threads and format."""
    environ, results = environment(options), {}
    for name in FORMATS:
        with open(os.path.join(setup.folder, name + ".raw"), "rb") as file:
            frame = file.read()

        def seconds(way, frames):
            return run(way.command(setup, name, frames), environ, frame, frames if way.fed else 0)

        asked = [way for way in found if name in way.formats]
        counts, times = {}, {way: [] for way in asked}
        for way in asked:
            pace = max((seconds(way, 51)[0] - seconds(way, 1)[0]) / 50, 1e-4)
            counts[way] = max(30, round(SECONDS / pace))
        for _ in range(ROUNDS):
            for way in asked:
                few, many = seconds(way, 1), seconds(way, counts[way] + 1)
                times[way].append((many[0] - few[0], many[1] - few[1]))
        for way in asked:
            clock, processors = (statistics.median(values) for values in zip(*times[way]))
            results.setdefault(way.name, {}).setdefault(way.threads, {})[name] = (
                counts[way] / clock, processors / clock)
    return results


def steps(options):
    setups = {}

    def work(size):
        found, absent = ways(options)
        setup = setups.setdefault(size, prepare(options, *size))
        check_pictures(options, setup, found)
        options.paths[size] = measure(options, setup, found)
        options.absent = absent

    options.paths = {}
    count = 20 * len(FORMATS)
    return [progress.Step(f"ways of frames, {width} x {height}", count * (ROUNDS + 1) * (SECONDS + 0.5),
                          lambda size=(width, height): work(size)) for width, height in SIZES]


def results(options):
    return options


def data_rows(options):
    """Rows of frame_rates.csv."""
    for name in options.absent:
        print(f"skipped, as it is not there: {name}")
    for name in dict.fromkeys(name for size in SIZES for name in options.paths[size]):
        for threads in options.paths[SIZES[0]][name]:
            for width, height in SIZES:
                for form, (rate, share) in options.paths[width, height][name][threads].items():
                    yield {"program": name, "threads": threads, "format": form, "width_px": width, "height_px": height,
                           "frames_per_s": f"{rate:.0f}", "processor_percent": f"{100 * share:.0f}"}
