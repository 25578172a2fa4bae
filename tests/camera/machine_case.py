"""The test case of machines in QEMU that run raygrid-camera with emulated cameras."""
import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import machine

programs = argparse.Namespace()
SKIP = 77

SIZES = {"vga": (640, 480), "hd": (1280, 720), "odd": (634, 478)}

# One machine for all tests of a class, as booting takes a while: `run NAME ARGUMENTS` leaves
# NAME.status, .out and .err. Camera i is at port i of the bus.
SETUP = """
cd /shared
run() {
  name=$1
  shift
  raygrid-camera "$@" --timeout 60 >$name.out 2>$name.err
  echo $? >$name.status
}
device() {  # NAME: the V4L2 device of a USB camera, or vivid's of that number
  for found in /sys/class/video4linux/video*; do
    [ "$(cat $found/index)" = 0 ] || continue
    case "$(readlink -f $found/device) $(cat $found/name)" in
      *"$1 "* | *"$1-vid-cap") echo v4l2:/dev/${found##*/} ;;
    esac
  done
}
wait_for() {  # FOLDER: until it has three frames
  until [ $(ls $1 2>/dev/null | grep -c raw$) -ge 3 ]; do sleep 0.1; done
}
end() {  # SIGNAL NAME: of the program that runs, how long it takes
  kill -$1 $(pidof raygrid-camera)
  before=$(cut -d. -f1 /proc/uptime)
  wait
  echo $(($(cut -d. -f1 /proc/uptime) - before)) >$2.seconds
}
"""


def raygrid(*arguments):
    subprocess.run([programs.raygrid, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


class MachineCase(unittest.TestCase):
    """A class names its cameras, and its job is a shell script for the machine."""
    CAMERAS = ()  # names of SIZES
    PLAYERS = ()  # what play() takes, of each camera at the bus
    MACHINE = {}  # more arguments of machine.boot()
    PROGRAMS = ()  # besides raygrid-camera, and libraries that are loaded by name: all in /bin

    @classmethod
    def set_up(cls, kernel, job):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = temporary.name
        cls.shared = cls.path("shared")
        os.mkdir(cls.shared)
        for name in cls.CAMERAS:
            cls.make_camera(name, SIZES[name])
        cls.make_more()
        with open(cls.path("shared/points.csv"), "w", encoding="utf-8") as file:
            file.write("x,y\n319.5,239.5\n600,20.25\n")
        machine.build_image(kernel, cls.path("image"), [programs.camera, *cls.PROGRAMS])
        players = [cls.play(*player) for player in cls.PLAYERS]
        status, log = machine.boot(kernel, cls.path("image"), cls.shared, players, SETUP + job,
                                   **{"timeout": 500, **cls.MACHINE})
        assert status == 0, log
        for player in players:
            print(f"{player.end()} frames sent")
        cls.players = players

    @classmethod
    def make_more(cls):
        """For a class that needs more than frames of its cameras."""

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder, name)

    @classmethod
    def play(cls, name, rate, unplug_after=0, ending=".yuyv"):
        cls.num_players = getattr(cls, "num_players", 0) + 1
        player = machine.Player(programs.emulated_camera, cls.folder, f"camera{cls.num_players}",
                                SIZES[name], rate, cls.path(name + ending), unplug_after)
        cls.addClassCleanup(player.kill)
        return player

    @classmethod
    def make_camera(cls, name, size):
        """A blob, the frames that a camera with its lens sees, and what is to come of them."""
        text = "{}x{}".format(*size)
        scene, raw = cls.path(name + "_scene"), cls.path(name + "_raw")
        # Bits are compared, whatever they show.
        raygrid("simulate", "--render", "--images", 2, "--lens", "wide", "--samples-per-pixel", 1,
                "--size", text, "-o", scene)
        camera = os.path.join(scene, "true_camera.yaml")
        images = [os.path.join(scene, file) for file in sorted(os.listdir(scene))
                  if file.endswith(".png")]
        raygrid("undistort", camera, *images, "--frames", raw, "-o", cls.path(name + "_flat"))
        blob = cls.path(f"shared/{name}.raygrid")
        raygrid("pack", camera, "--remap", text + ",hfov=80", "-o", blob)
        greys = []
        for file in sorted(os.listdir(raw)):
            with open(os.path.join(raw, file), "rb") as frame:
                greys.append(frame.read())
        with open(cls.path(name + ".yuyv"), "wb") as file:
            file.write(b"".join(machine.make_frames(greys, *size, 100)))
        subprocess.run([programs.undistort_frames, blob, cls.path(name + ".yuyv"),
                        cls.path(name + ".undistorted")], check=True)

    def read(self, name):
        with open(os.path.join(self.shared, name), encoding="utf-8") as file:
            return file.read()

    def status(self, name):
        return int(self.read(name + ".status"))

    def assert_ends(self, name, status, *words):
        error = self.read(name + ".err")
        self.assertEqual(self.status(name), status, error)
        said = [line for line in error.splitlines() if line.startswith("raygrid-camera: ")]
        self.assertEqual(len(said), 1 if status else 0, error)
        for word in words:
            self.assertIn(word, said[0])

    def frames(self, folder):
        """Headers as dictionaries, and planes, of all frames written."""
        result = []
        path = os.path.join(self.shared, folder)
        for name in sorted(os.listdir(path)):
            self.assertRegex(name, r"^frame-[0-9]{6}\.raw$")
            with open(os.path.join(path, name), "rb") as file:
                header, _, planes = file.read().partition(b"\n...\n")
            lines = header.decode().splitlines()
            result.append((dict(line.split(": ", 1) for line in lines), planes))
        return result

    def check_frames(self, name, folder=None):
        """Each frame is one that the host undistorted from what was sent, bit for bit, in order."""
        width, height = SIZES[name]
        size = 2 * width * height
        with open(self.path(name + ".undistorted"), "rb") as file:
            expected = file.read()
        index_of = {expected[i * size:(i + 1) * size]: i for i in range(len(expected) // size)}
        self.assertEqual(len(index_of), 100)
        frames = self.frames(folder or name)
        indices = []
        for header, planes in frames:
            self.assertEqual(header["format"], "YUYV")
            self.assertEqual(header["size"], f"[{width}, {height}]")
            self.assertIn(planes, index_of)
            indices.append(index_of[planes])
        sequences = [int(header["sequence"]) for header, _ in frames]
        for i in range(1, len(frames)):
            # The driver drops frames that it has no buffer for, and numbers them all the same.
            self.assertGreater(sequences[i], sequences[i - 1])
            self.assertGreater((indices[i] - indices[i - 1]) % 100, 0)
        return frames, sequences

    def counts(self, name):
        """The counts that the program said at its end."""
        counted = re.search(r"(\d+) arrived, (\d+) undistorted, (\d+) delivered, (\d+) dropped, "
                            r"(\d+) damaged, (\d+) missed", self.read(name + ".err"))
        self.assertIsNotNone(counted, self.read(name + ".err"))
        keys = ("arrived", "undistorted", "written", "dropped", "damaged", "missed")
        return dict(zip(keys, map(int, counted.groups())))

    def check_unplugged(self, name):
        self.assert_ends(name, 2, "disconnected")
        frames, _ = self.check_frames("vga", name)
        self.assertGreater(len(frames), 0)
        self.assertLessEqual(len(frames), 20)
        self.assertEqual(len(frames), self.counts(name)["written"])

    def check_benchmark(self, memory):
        self.assert_ends("benchmark", 0)
        text = self.read("benchmark.out")
        self.assertIn(f"memory: {memory}\ncached: yes\n", text)
        rate = float(text.split("frames_per_second: ")[1].split()[0])
        self.assertLess(rate, 12)

    def check_stream(self, name, count, prefix=""):
        if programs.only_ends:
            self.skipTest("--only-ends: sanitizers are too slow for the frames")
        camera, name = name, prefix + name
        self.assert_ends(name, 0)
        frames, sequences = self.check_frames(camera, name)
        self.assertEqual(len(frames), count)
        counts = self.counts(name)
        print(f"{name}: {self.read(name + '.err').strip()}")
        self.assertEqual(counts["written"], count)
        self.assertEqual(counts["dropped"], 0)
        self.assertEqual(counts["damaged"], 0)
        # Every number between the first and the last one is a frame here, or one that the driver
        # never gave libcamera.
        skipped = sequences[-1] - sequences[0] + 1 - len(sequences)
        self.assertLessEqual(skipped, counts["missed"])


def skip(name, why):
    print(f"{name}: skipped: {why}")
    sys.exit(SKIP)


def main(name):
    """Runs the tests of the file, where the machine has all that it needs."""
    parser = argparse.ArgumentParser()
    for option in ("raygrid", "camera", "emulated-camera", "undistort-frames", "kernel"):
        parser.add_argument("--" + option, required=True)
    parser.add_argument("--heap-kernel", default="")
    parser.add_argument("--plugin", default="")
    parser.add_argument("--play-to-outline", default="")
    parser.add_argument("--lock-camera-state", default="")
    parser.add_argument("--until-done", action="store_true",
                        help="a capture comes to its end")
    parser.add_argument("--only-ends", action="store_true",
                        help="not the long streams: for programs that are slow")
    _, rest = parser.parse_known_args(namespace=programs)
    for tool in ("qemu-system-x86_64", "cpio", "modprobe"):
        if not shutil.which(tool, path=os.environ["PATH"] + ":/sbin:/usr/sbin"):
            skip(name, f"{tool} is missing; tools/install_packages camera-machine installs it")
    if not has_kernel(programs.kernel):
        skip(name, "no kernel; tests/camera/vm/fetch_kernel FOLDER fetches Debian's")
    unittest.main(argv=[sys.argv[0]] + rest, verbosity=2)


def has_kernel(folder):
    return os.path.isdir(os.path.join(folder, "boot"))
