#!/usr/bin/env python3
"""Random small inputs to all commands: each ends by itself within 60 CPU seconds and 1 GB, with an exit code
of the README, says why where it fails, in words of its own, and leaves nothing half-written. By
hand: --count 2000, --seed N, --only N for one."""
import argparse
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import threading

from command_test import HANG_S, SIMULATED_PATTERN, call, commands, programs, read, run, specifications, write
from image_size_test import black_png
from images_test import chunk, exif, png, tiff

MAX_SECONDS, MAX_BYTES = 60, 1 << 30
NUMBERS = ("0", "1", "-1", "0.02", "1e-6", "1e-9", "1e-300", "1e300", "1e308", "1e12", ".nan",
           ".inf", "1e999", "7", "640", "1000", "65536", "2147483647", "4294967936",
           "99999999999999999999", "x", "''", "[]")
SIZES = ("64x48", "160x120", "1x1", "2x2", "0x0", "8192x8192", "16384x40", "16385x2",
         "65536x65536", "1000000x1000000", "4294967936x480", "640", "-1x5", "nanxnan")
IMAGE_SIZES = ((64, 48), (160, 120), (640, 480), (33, 1), (1, 1), (2, 2), (3, 40), (31, 31),
               (32, 32), (40, 16384), (16384, 33))
# Far more pixels than bytes.
LARGE = {"black.png": (16000, 16000), "wide.png": (16384, 3000), "large.png": (8000, 8000)}
FORMATS = ("opencv", "ros", "kalibr", "colmap", "mrcal", "basalt", "nerfstudio", "metashape",
           "puzzlepaint", "depthai", "libcamera", "photonvision", "dso", "ocamcalib", "calib-line",
           "kitti-rectified")
TABLE_FORMATS = ("c", "hex", "maps", "stmap", "ffmpeg", "rays", "isaac", "tum", "dw100", "ti-ldc",
                 "vpi", "rockchip-fec", "rockchip-ldch", "hailo", "depthai-mesh",
                 "puzzlepaint-dataset")
WORDS = ("chessboard:14x10:30mm", "chessboard:9x6", "chessboard:1x1:1km", "star:1000x1000:1mm")


class Case:
    """The files and the command of one number; the same ones for the same seed."""

    def __init__(self, folder, base, seed, index):
        self.random = random.Random(f"{seed} {index}")
        self.folder, self.base, self.count = folder, base, 0
        names = sorted(set(commands()) - {"capture"})  # which has a page to be closed
        self.name = names[index % len(names)]
        words = getattr(self, "run_" + self.name.replace("-", "_"), self.run_by_help)()
        self.arguments = [self.name] + [str(word) for word in words]
        if self.chance(0.03):
            self.arguments += ["--seed", self.random.choice(("-1", "7", "18446744073709551616"))]
        self.limits = {}
        if self.chance(0.04):
            self.limits[resource.RLIMIT_FSIZE] = self.random.choice((0, 100, 5000, 100000))
        if self.chance(0.04):
            self.limits[resource.RLIMIT_NOFILE] = self.random.choice((4, 5, 6, 8, 12))

    def chance(self, part):
        return self.random.random() < part

    def path(self, end):
        self.count += 1
        return os.path.join(self.folder, f"{self.count}{end}")

    def no_file(self):
        """A name of something else, where a file was expected."""
        path = self.path("")
        self.random.choice((os.mkfifo, lambda p: os.symlink("/dev/zero", p), os.mkdir,
                            lambda p: os.symlink(p, p), lambda p: os.symlink("/dev/full", p)))(path)
        return path

    def output(self, end=""):
        """A place to write to: a new one, in most cases."""
        if self.chance(0.93):
            return self.path(end)
        return self.random.choice((self.no_file, lambda: "", lambda: self.file(end, b"old"),
                                   lambda: os.path.join(self.file("", b"old"), "below"),
                                   lambda: "/dev/full"))()

    def file(self, end, contents):
        return write(self.path(end), contents)

    # ---- Inputs: good ones, or odd and damaged ones --------------------------------

    def good(self, *names):
        """A good file, in most cases: one bad input is to be refused, not several."""
        if self.chance(0.65):
            return os.path.join(self.base, self.random.choice(names))
        return None

    def damaged(self, contents):
        """Bytes changed, cut or doubled, in some cases."""
        contents = bytearray(contents)
        for _ in range(self.random.choice((0, 0, 1, 3, 30))):
            if contents:
                contents[self.random.randrange(len(contents))] = self.random.randrange(256)
        if self.chance(0.1):
            del contents[self.random.randrange(len(contents) + 1):]
        if self.chance(0.05):
            contents += bytes(contents)
        return bytes(contents)

    def with_numbers(self, text, part=0.15):
        """Some numbers of a text file are others."""
        words = text.replace("[", "[ ").replace(",", " , ").replace("]", " ]").split(" ")
        places = [i for i, word in enumerate(words) if word.strip("-").replace(".", "").isdigit()]
        for i in places:
            if self.chance(part / max(1, len(places)) ** 0.5):
                words[i] = self.random.choice(NUMBERS)
        return " ".join(words)

    def image(self):
        size = self.random.choice(IMAGE_SIZES)
        pixels = [self.random.choice((0, 128, 255))] * (size[0] * size[1])
        if self.chance(0.04):
            return os.path.join(self.base + "-large", self.random.choice(sorted(LARGE)))
        kind = self.random.randrange(8)
        if kind == 0:
            end, contents = ".png", png(pixels, size=size, chunks=chunk(b"eXIf", exif(6)))
        elif kind == 1:
            end, contents = ".tif", tiff(pixels, self.random.randrange(12), size)
        elif kind == 2:
            width, height = self.random.choice(((30000, 30000), (1, 1 << 31), (0, 5), size))
            end, contents = ".pgm", b"P5 %d %d 255\n" % (width, height) + bytes(pixels)
        elif kind == 3:
            return self.no_file()
        elif kind == 4:
            end, contents = ".png", png([257 * level for level in pixels], bits=16, size=size)
        else:
            photos = sorted(name for name in os.listdir(self.base) if name.endswith(".png"))
            end, contents = ".png", read(os.path.join(self.base, self.random.choice(photos)))
        return self.file(end, self.damaged(contents) if self.chance(0.5) else contents)

    def images(self):
        odd = [self.image() for _ in range(self.random.choice((1, 2, 5)))]
        return self.random.choice(([self.base], [self.base, *odd], odd))

    def text(self, name, end, part=0.15):
        if self.chance(0.04):
            return self.no_file()
        contents = read(os.path.join(self.base, name))
        if self.chance(0.5):
            contents = self.with_numbers(contents.decode(), part).encode()
        elif self.chance(0.5):
            contents = self.damaged(contents)
        return self.file(end, contents)

    def pattern(self):
        path = self.good("pattern.yaml")
        if path:
            return path
        if self.chance(0.3):
            return self.random.choice([*WORDS, *specifications()])
        kind = self.random.choice([*commands("pattern"), "points", "other"])
        if self.chance(0.5):
            return self.text("pattern.yaml", ".yaml", 0.8)
        sides = [self.random.choice((2, 3, 8, 14, 100, 1000, 1001, -1, "x")) for _ in range(2)]
        board = (f"id: 0, kind: {kind}, columns: {sides[0]}, rows: {sides[1]}, square_m: "
                 f"{self.random.choice(NUMBERS)}, marker_m: {self.random.choice(NUMBERS)}, "
                 "dictionary: DICT_4X4_50, spacing_ratio: 0.3, segments: 16, "
                 "tags: [{id: 0, column: 1, row: 1, squares: 4}], xyz: [[0, 0, 0], [1, 0, 0]]")
        boards = "".join(f"  - {{{board.replace('id: 0', f'id: {i}', 1)}}}\n"
                         for i in range(self.random.choice((1, 1, 3, 200))))
        return self.file(".yaml", "raygrid_pattern: 1\nboards:\n" + boards)

    def camera(self):
        path = self.good("true_camera.yaml", "c.raygrid")
        if path:
            return path
        if self.chance(0.3):
            return self.file(".raygrid", self.damaged(read(os.path.join(self.base, "c.raygrid"))))
        return self.foreign() if self.chance(0.3) else self.text("true_camera.yaml", ".yaml")

    def features(self):
        return self.good("features.csv") or self.text("features.csv", ".csv", 0.3)

    def numbers(self, columns):
        if self.chance(0.05):
            return self.no_file()
        if self.chance(0.05):
            return self.file(".csv", b"," * 5000000)
        rows = [",".join(self.random.choice(NUMBERS) for _ in columns)
                for _ in range(self.random.choice((0, 1, 5)))]
        return self.file(".csv", self.damaged("\n".join([",".join(columns)] + rows).encode()))

    def size(self):
        if self.chance(0.65):
            return "160x120"
        return self.random.choice(SIZES)

    # ---- Commands ---------------------------------------------------------------

    def run_by_help(self):
        """What the help requires, and in some cases an output."""
        values = {"IMAGES": self.image, "--features": self.features, "--output": self.output, "--pattern": self.pattern,
                  "--pixels": lambda: self.numbers("xy"), "--points": lambda: self.numbers("xyz")}
        words = call(lambda name: values.get(name, self.camera)(), self.name)
        more = self.random.choice(([], ["--json"], ["--output", self.output(".csv")]))
        has_output = "--output" in run(self.name, "--help").stdout and "--output" not in words
        return words[1:] + (more if has_output or "--json" in more else [])

    def run_calibrate(self):
        measured = (["--features", self.features(), "--image-size",
                     "160x120" if self.chance(0.7) else self.size()]
                    if self.chance(0.6) else [*self.images(), "--no-refine-features"])
        model = self.random.choice(("opencv", "central-generic", "noncentral-generic",
                                    "central-radial", "thin-prism-fisheye", "none"))
        names = ("sim0001.png", '"a,b"', '"', ",,", "x" * 9000)
        held_out = ["--hold-out", self.random.choice(names)]
        return [*measured, "--pattern", self.pattern(), "--model", model, "--knot-spacing-px",
                self.random.choice(("40", "160", "2", "0", "nan", "1e300", "auto")),
                *(["--duplicate-px", self.random.choice(("0", "auto", "-1", "40"))]
                  if self.chance(0.1) else []),
                *(["--rolling-shutter", "--timestamps", self.numbers("xy")]
                  if self.chance(0.1) else []),
                "--skip-comparison", *(held_out if self.chance(0.1) else []), "-o", self.output()]

    def run_check(self):
        return [self.camera(), *self.images(), "--pattern", self.pattern()]

    def run_detect(self):
        return [*self.images(), "--pattern", self.pattern(), "-o", self.output(".csv"), "--overlay",
                self.output(), "--no-cache"]

    def run_experiment(self):
        return ["curvature-bias", "--features", self.features(), "--image-size", self.size(),
                "--pattern", self.pattern(), "--camera", self.camera(), "--image", self.image(),
                "-o", self.output()]

    def run_export(self):
        more = self.random.choice(((), ("--max-fit-error-px", self.random.choice(NUMBERS)),
                                   ("--rectified", "--size", self.size()), ("--rectified",)))
        if self.random.random() < 0.3:
            return self.table_export()
        return [self.camera(), "--to", self.random.choice(FORMATS), *more, "-o",
                self.output(self.random.choice((".yaml", ".xml", ".json")))]

    def table_export(self):
        name = self.random.choice(TABLE_FORMATS)
        more = {"hex": ("--address", self.random.choice(NUMBERS)),
                "maps": ("--size", self.size()), "stmap": ("--size", self.size(), "--inverse"),
                "rays": ("--stride", self.random.choice(NUMBERS)),
                "ti-ldc": ("--stride", self.random.choice(NUMBERS)),
                "dw100": ("--max-fit-error-px", self.random.choice(NUMBERS)),
                "isaac": ("--max-fit-error-px", self.random.choice(NUMBERS))}.get(name, ())
        return [self.camera(), "--to", name, *more, "-o",
                self.output(self.random.choice((".h", ".c", ".npz", ".exr", ".pgm", ".json", ".bin")))]

    def run_import(self):
        more = self.random.choice(((), (), ("--image-size", self.size())))
        return [self.foreign(), *more, "-o", self.output(".yaml")]

    def run_fit(self):
        model = self.random.choice(("opencv", "central-radial", "thin-prism-fisheye", "opencv-14",
                                    "omni-radtan", "double-sphere", "eucm"))
        spline = self.random.choice(([], ["--model", "splined-stereographic"] + self.random.choice(
            ([], ["--spline", "9x4"], ["--spline", "4x30,fov=1"], ["--spline", "1x1,fov=999"]))))
        return [self.camera(), *(spline or ["--model", model]), "-o", self.output(".yaml")]

    def run_inspect(self):
        return [self.random.choice((self.camera, self.pattern, self.features, self.image))()]

    def run_pack(self):
        remap = self.size() + self.random.choice(("", ",hfov=60", ",hfov=179.9", ",hfov=1e-9"))
        number = lambda: self.random.choice(NUMBERS)
        capture = (["--capture-settings", f"crop={number()},0,{number()},480,lens={number()},"
                    f"zoom={number()},orientation={number()}"] if self.chance(0.3) else [])
        return [self.camera(), "--remap", remap, *capture, "-o", self.output(".raygrid")]

    def run_pattern(self):
        side = lambda: self.random.choice(("2", "8", "14", "1000", "0", "-3", "1001"))
        length = lambda: self.random.choice(("0.001", "1", "20", "1e6", "1e-300", "nan"))
        words = call(lambda name: self.output() if name == "--output" else length() if name.endswith("-mm") else side(),
                     "pattern", self.random.choice(commands("pattern")))
        return [*words[1:], "--dpi", self.random.choice(("1", "50", "72", "1e9"))]

    def run_rectify(self):
        rig = self.good("pair/true_rig.yaml") or self.text("pair/true_rig.yaml", ".yaml")
        name = lambda: self.random.choice(("cam0", "cam1", "cam1", "cam7", "", "../x"))
        distance = ["--distance", self.random.choice(NUMBERS)] if self.chance(0.1) else []
        return [rig, "--left", "cam0" if self.chance(0.8) else name(), "--right", name(), "--size",
                self.size(), "--alpha", self.random.choice(("0", "0", "1", "0.3", "-1", "nan")),
                *distance, "-o", self.output()]

    def run_localize(self):
        measured = ["--features", self.features()] if self.chance(0.6) else self.images()
        return [self.camera(), *measured, *(["--refine-target"] if self.chance(0.3) else []), "--pattern",
                self.pattern(), "-o", self.output()]

    def run_hand_eye(self):
        poses = self.good("poses", "result") or self.text("poses/poses.csv", ".csv", 1)
        robot = self.good("true_poses.csv") or self.text("true_poses.csv", ".csv", 1)
        return [poses, "--robot", robot, *(["--eye-to-hand"] if self.chance(0.8) else []),
                *(["--robot-sigma-mm", self.random.choice(NUMBERS)] if self.chance(0.2) else []),
                *(["--robot-unit", "mm"] if self.chance(0.1) else []), "-o", self.output()]

    def run_report(self):
        folder = self.path("")
        shutil.copytree(os.path.join(self.base, "result"), folder)
        for _ in range(self.random.choice((1, 2))):
            path = os.path.join(folder, self.random.choice(sorted(os.listdir(folder))))
            text = read(path)
            if path.endswith((".json", ".yaml", ".csv")) and self.chance(0.5):
                write(path, self.with_numbers(text.decode("latin-1"), 1))
            else:
                write(path, self.damaged(text))
        return [folder]

    def run_simulate(self):
        camera = (["--camera", self.camera()] if self.chance(0.5) else
                  ["--lens", "pinhole", "--size", self.size()])
        return [*camera, "--pattern", self.pattern(), "--images", "2", "--samples-per-pixel", "1",
                *(["--render"] if self.chance(0.5) else []),
                *(["--moving", "--line-delay-us", self.random.choice(("20", "-20", "nan", "1e9"))]
                  if self.chance(0.3) else []), "-o", self.output()]

    def run_undistort(self):
        return [self.camera(), *self.images(), "--size", self.size(), "--hfov",
                self.random.choice(("60", "179.99", "1e-9", "0")),
                *(["--inverse"] if self.chance(0.3) else []), "-o", self.output()]

    def run_batch(self):
        options = self.with_numbers("model: opencv\nimage_size: [ 160 , 120 ]\nlimits: {focal_px: [ 1 , 2 ]}\n")
        serials = [self.random.choice(("A1", "A2", "..", "a b", "7")) for _ in range(2)]
        more = self.random.choice(("", ", lens_batch: L1", ", repeats: A1", ", repeats: G, operator: ann, station: 2"))
        units = [f"  - {{serial: {serial}, features: {self.text('features.csv', '.csv')}{more}}}\n"
                 for serial in serials]
        plan = f"raygrid_batch: 1\npattern: {self.base}/pattern.yaml\nskip_comparison: true\n{options}units:\n"
        return [self.file(".yaml", self.damaged((plan + "".join(units)).encode())), "-o", self.output()]

    def run_update(self):
        slots = self.output(".bin") if self.chance(0.7) else self.file(".bin", b"\xff" * 16384)
        size = ["--slot-size", self.random.choice(("64K", "8K", "7", *NUMBERS))] if self.chance(0.5) else []
        return [self.camera(), "--slots", slots, *size]

    def run_view(self):
        image = ["--image", self.image()] if self.chance(0.5) else []
        remap = ["--remap", self.size() + ",hfov=60"] if self.chance(0.3) else []
        return [self.camera(), *image, *remap, "-o", self.output(".png")]

    def foreign(self):
        """Another program's file."""
        return self.text("foreign." + self.random.choice(FORMATS), ".yaml")


def set_limits(limits):
    """Sets the case's limits, and one of memory: a run beyond that fails as one beyond MAX_BYTES
    does, and leaves the machine alone."""
    for kind, limit in limits.items():
        resource.setrlimit(kind, (limit, limit))
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    limit = 16 << 30 if most == resource.RLIM_INFINITY else min(most, 16 << 30)
    resource.setrlimit(resource.RLIMIT_AS, (limit, most))


def half_written(folder):
    return [name for _, folders, names in os.walk(folder) for name in folders + names
            if ".part-" in name or ".raygrid-" in name]


def what_is_wrong(raygrid, case):
    """How a run ends that ought to have ended otherwise; and its seconds and bytes."""
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen([raygrid, *case.arguments, "--threads", "2"], stdout=output,
                                   stderr=output, stdin=subprocess.DEVNULL, cwd=case.folder,
                                   preexec_fn=lambda: set_limits(case.limits))
        hangs = threading.Timer(HANG_S, process.kill)
        hangs.daemon = True
        hangs.start()
        try:
            _, status, usage = os.wait4(process.pid, 0)
        finally:
            hangs.cancel()
        process.returncode = code = os.waitstatus_to_exitcode(status)
        output.seek(0)
        text = output.read().decode("utf-8", "replace")
    seconds = usage.ru_utime + usage.ru_stime
    figures = (seconds, 1024 * usage.ru_maxrss)
    if seconds > MAX_SECONDS:
        return f"takes {seconds:.0f} CPU seconds", figures
    if figures[1] > MAX_BYTES:
        return f"takes {figures[1] / (1 << 20):.0f} MiB", figures
    if not 0 <= code <= 8:
        return f"ends with {code}: {text[-300:]}", figures
    is_printed = resource.RLIMIT_FSIZE not in case.limits
    if code and is_printed and "raygrid: " not in text:
        return f"ends with {code} and says nothing", figures
    for word in ("OpenCV", "terminate called", "Assertion", "std::", "json.exception"):
        if word in text:
            return f"says {word}: {text[-300:]}", figures
    left = half_written(case.folder)
    if left:
        return f"ends with {code} and leaves {left[:3]}: {text[-200:]}", figures
    return "", figures


def make_base(raygrid, folder):
    """Good inputs, which cases are made from."""
    pattern = write(os.path.join(folder, "pattern.yaml"), SIMULATED_PATTERN)
    for arguments in (
            ("simulate", "--render", "--lens", "wide", "--size", "160x120", "--images", "9",
             "--samples-per-pixel", "2", "--pattern", pattern, "-o", folder + "/sim"),
            *(("export", folder + "/sim/true_camera.yaml", "--to", name, "-o",
               f"{folder}/sim/foreign.{name}") for name in FORMATS),
            ("pack", folder + "/sim/true_camera.yaml", "--remap", "160x120", "-o",
             folder + "/sim/c.raygrid"),
            ("calibrate", "--features", folder + "/sim/features.csv", "--image-size", "160x120",
             "--pattern", pattern, "--model", "opencv", "--skip-comparison", "-o",
             folder + "/sim/result"),
            ("localize", folder + "/sim/true_camera.yaml", "--features", folder + "/sim/features.csv", "--pattern", pattern,
             "-o", folder + "/sim/poses"),
            ("simulate", "--cameras", "2", "--baseline-m", "0.1", "--lens", "wide", "--size",
             "160x120", "--images", "2", "--pattern", pattern, "-o", folder + "/sim/pair")):
        result = subprocess.run([raygrid, *arguments], capture_output=True, text=True, check=False)
        assert result.returncode in (0, 6), result.stderr
    for name, size in LARGE.items():
        write(f"{folder}/sim-large/{name}", black_png(*size))
    return folder + "/sim"


class Summary:
    """How many runs there were, and the worst of them."""
    def __init__(self):
        self.num_runs = self.num_wrong = 0
        self.slowest = self.largest = (0, 0)

    def add(self, index, case, wrong, figures):
        self.num_runs += 1
        self.slowest = max(self.slowest, (figures[0], index))
        self.largest = max(self.largest, (figures[1], index))
        if wrong:
            self.num_wrong += 1
            print(f"case {index}: raygrid {' '.join(case.arguments)} {case.limits or ''}\n"
                  f"  {wrong}", flush=True)

    def print(self):
        print(f"{self.num_runs} runs, {self.num_wrong} end otherwise; slowest "
              f"{self.slowest[0]:.1f} s (case {self.slowest[1]}), largest "
              f"{self.largest[0] / (1 << 20):.0f} MiB (case {self.largest[1]})", flush=True)


def sweep():
    parser = argparse.ArgumentParser()
    parser.add_argument("--raygrid", required=True)
    parser.add_argument("--count", type=int, default=48)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", type=int)
    options, _ = parser.parse_known_args()
    programs.raygrid = options.raygrid
    summary = Summary()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_CACHE_HOME"] = folder + "/cache"
        base = make_base(options.raygrid, folder)
        indices = range(options.count) if options.only is None else [options.only]
        try:
            for index in indices:
                with tempfile.TemporaryDirectory() as place:
                    case = Case(place, base, options.seed, index)
                    summary.add(index, case, *what_is_wrong(options.raygrid, case))
        except KeyboardInterrupt:
            print("interrupted")
    summary.print()
    return 1 if summary.num_wrong or summary.num_runs < len(indices) else 0


if __name__ == "__main__":
    sys.exit(sweep())
