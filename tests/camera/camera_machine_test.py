#!/usr/bin/env python3
"""raygrid-camera on a whole stack: Debian's kernel in QEMU, uvcvideo and libcamera, and USB cameras
that play frames which were rendered through a known lens."""
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

# One machine for all tests, as booting takes a while: `run NAME ARGUMENTS` leaves NAME.status,
# .out and .err. Camera i is at port i of the bus.
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
wait_for() {
  until [ -e $1 ]; do sleep 0.1; done
}
end() {  # SIGNAL NAME: of the program that runs, how long it takes
  kill -$1 $(pidof raygrid-camera)
  before=$(cut -d. -f1 /proc/uptime)
  wait
  echo $(($(cut -d. -f1 /proc/uptime) - before)) >$2.seconds
}
"""
STREAMS = """
run vga vga.raygrid --camera -1:1.0 --frames 40 --every-frame -o vga
run hd hd.raygrid --camera -2:1.0 --frames 40 --every-frame -o hd
run odd odd.raygrid --camera -3:1.0 --size 640x480 --frames 10 --every-frame -o odd
run v4l2_vga vga.raygrid --source $(device -1:1.0) --frames 40 --every-frame -o v4l2_vga
run v4l2_odd odd.raygrid --source $(device -3:1.0) --size 640x480 --frames 10 --every-frame \
  -o v4l2_odd
"""
ENDS = """
run list --list
run source --source
run several vga.raygrid --frames 1
run v4l2_several vga.raygrid --source v4l2 --frames 1
run v4l2_other_size vga.raygrid --source $(device -2:1.0) --frames 1 -o other_size
run other_size vga.raygrid --camera -2:1.0 --frames 1 -o other_size
run points vga.raygrid --camera -1:1.0 --points points.csv

mkdir /tmp/full
mount -t tmpfs -o size=2m none /tmp/full
run full vga.raygrid --camera -1:1.0 -o /tmp/full
ls -l /tmp/full >full.files

run terminated vga.raygrid --camera -1:1.0 -o terminated &
wait_for terminated/frame-000002.raw
run second vga.raygrid --camera -1:1.0 --frames 1
run v4l2_second vga.raygrid --source $(device -1:1.0) --frames 1
end TERM terminated
run interrupted vga.raygrid --camera -1:1.0 -o interrupted &
wait_for interrupted/frame-000002.raw
end INT interrupted

ifconfig lo up
run page vga.raygrid --camera -1:1.0 --http 8080 &
until wget -q -O page.html http://127.0.0.1:8080/; do sleep 0.2; done
wget -q -O - http://127.0.0.1:8080/after | head -c 300000 >page.mjpg
end TERM page

mkdir unplugged
run unplugged vga.raygrid --camera -4:1.0 -o unplugged
last=$(stat -c %Y unplugged | sort -n | tail -n 1)
echo $(($(date +%s) - last)) >unplugged.seconds
run v4l2_unplugged vga.raygrid --source $(device -5:1.0) -o v4l2_unplugged

modprobe vivid n_devs=2 node_types=1,1 multiplanar=1,2
udevadm settle
single=$(device vivid-000)
apart=$(device vivid-001)
still="--control osd_text_mode=None --frames 3 --every-frame"
for format in NV12 YUV420 BGR888 SRGGB8; do
  run vivid_$format vga.raygrid --source $single --format $format $still -o vivid_$format
  dd if=${single#v4l2:} of=vivid_$format.frame bs=1M count=1
  run apart_$format vga.raygrid --source $apart --format $format $still -o apart_$format
done
for control in gain=300 nonsense=1 inject_vidioc_reqbufs_error=1 disconnect=1; do
  run vivid_${control%=*} vga.raygrid --source $single --control $control --frames 1
done
"""


def raygrid(*arguments):
    subprocess.run([programs.raygrid, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


class CameraInMachine(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = temporary.name
        cls.shared = cls.path("shared")
        os.mkdir(cls.shared)
        for name, size in SIZES.items():
            cls.make_camera(name, size)
        with open(cls.path("shared/points.csv"), "w", encoding="utf-8") as file:
            file.write("x,y\n319.5,239.5\n600,20.25\n")
        machine.build_image(programs.kernel, cls.path("image"), [programs.camera])
        players = [cls.play("vga", 10), cls.play("hd", 5), cls.play("odd", 10),
                   cls.play("vga", 10, 20), cls.play("vga", 10, 20)]
        status, log = machine.boot(programs.kernel, cls.path("image"), cls.shared, players,
                                   SETUP + ("" if programs.only_ends else STREAMS) + ENDS,
                                   timeout=500)
        assert status == 0, log
        for player in players:
            print(f"{player.end()} frames sent")

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder, name)

    @classmethod
    def play(cls, name, rate, unplug_after=0):
        cls.num_players = getattr(cls, "num_players", 0) + 1
        player = machine.Player(programs.emulated_camera, cls.folder, f"camera{cls.num_players}",
                                SIZES[name], rate, cls.path(name + ".yuyv"), unplug_after)
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
        counted = re.search(r"(\d+) arrived, (\d+) undistorted, (\d+) taken, (\d+) dropped, "
                            r"(\d+) damaged, (\d+) missed", self.read(name + ".err"))
        self.assertIsNotNone(counted, self.read(name + ".err"))
        keys = ("arrived", "undistorted", "written", "dropped", "damaged", "missed")
        return dict(zip(keys, map(int, counted.groups())))

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

    def test_vga_frames_are_those_of_the_host(self):
        self.check_stream("vga", 40)

    def test_hd_frames_are_those_of_the_host(self):
        self.check_stream("hd", 40)

    def test_a_size_that_the_driver_adjusts(self):
        self.check_stream("odd", 10)

    def test_v4l2_frames_are_those_of_the_host(self):
        self.check_stream("vga", 40, "v4l2_")
        self.check_stream("odd", 10, "v4l2_")

    def test_formats_of_v4l2(self):
        for name in ("NV12", "YUV420", "BGR888", "SRGGB8"):
            expected = subprocess.run(
                [programs.camera, self.path("shared/vga.raygrid"), "--from",
                 self.path(f"shared/vivid_{name}.frame"), "--format", name, "--frames", "1",
                 "--every-frame", "--quiet", "-o", "-"], check=True, capture_output=True).stdout
            for device in ("vivid_", "apart_"):
                with self.subTest(device + name):
                    self.assert_ends(device + name, 0)
                    frames = self.frames(device + name)
                    self.assertEqual(len(frames), 3)
                    for header, planes in frames:
                        self.assertEqual(header["format"], name)
                        self.assertEqual(planes, expected)

    def test_v4l2_devices_that_cannot_be_used(self):
        self.assert_ends("v4l2_several", 2, "--source v4l2:/dev/video")
        self.assert_ends("v4l2_other_size", 8, "640x480", "1280x720", "--list")
        self.assert_ends("v4l2_second", 2, "/dev/video", "in use by another process")
        self.assert_ends("vivid_gain", 2, "/dev/video", "gain")
        self.assert_ends("vivid_nonsense", 2, "nonsense", "--list")
        self.assert_ends("vivid_inject_vidioc_reqbufs_error", 2, "no memory for frames")
        self.assert_ends("vivid_disconnect", 2, "was unplugged")

    def test_list(self):
        self.assert_ends("list", 0)
        text = self.read("list.out")
        for size in SIZES.values():
            self.assertIn("YUYV {}x{}".format(*size), text)
        self.assertEqual(self.read("source.out"), text)
        for kind in ("libcamera:", "v4l2:/dev/video"):
            cameras = [line for line in text.splitlines() if line.startswith(kind)]
            self.assertEqual(len(cameras), 5)
            for camera in cameras:
                self.assertIn("(Emulated camera", camera)

    def test_several_cameras_need_a_choice(self):
        self.assert_ends("several", 2, "--camera")

    def test_a_blob_of_another_size_is_refused_with_the_remedy(self):
        self.assert_ends("other_size", 8, "640x480", "1280x720", "--list")
        self.assertFalse(os.path.exists(os.path.join(self.shared, "other_size")))

    def test_points(self):
        self.assert_ends("points", 0)
        lines = self.read("points.out").splitlines()
        self.assertEqual(lines[0], "x,y,u,v")
        self.assertEqual(len(lines), 3)
        u, v = map(float, lines[1].split(",")[2:])
        self.assertLess(abs(u - 319.5) + abs(v - 239.5), 20)

    def test_a_full_disk(self):
        self.assert_ends("full", 7, "No space left", "make room")
        sizes = {int(line.split()[4]) for line in self.read("full.files").splitlines()[1:]}
        self.assertNotIn(".part", self.read("full.files"))
        self.assertTrue(sizes)
        for size in sizes:
            self.assertGreater(size, 614400)

    def test_a_second_process_is_refused(self):
        self.assert_ends("second", 2, "in use by another process")

    def test_signals_end_it_in_order(self):
        for name in ("terminated", "interrupted"):
            with self.subTest(name):
                self.assert_ends(name, 0)
                frames, _ = self.check_frames("vga", name)
                self.assertEqual(len(frames), self.counts(name)["written"])
                self.assertGreater(len(frames), 0)
                self.assertLessEqual(int(self.read(name + ".seconds")), 2)

    def test_the_page_moves(self):
        self.assert_ends("page", 0)
        self.assertIn('src="/after"', self.read("page.html"))
        with open(os.path.join(self.shared, "page.mjpg"), "rb") as file:
            pictures = file.read().split(b"--frame\r\n")[1:-1]
        self.assertGreater(len(set(pictures)), 1)

    def test_a_camera_that_is_unplugged(self):
        for name in ("unplugged", "v4l2_unplugged"):
            self.assert_ends(name, 2, "was unplugged")
            frames, _ = self.check_frames("vga", name)
            self.assertGreater(len(frames), 0)
            self.assertLessEqual(len(frames), 20)
            self.assertEqual(len(frames), self.counts(name)["written"])
        self.assertLessEqual(int(self.read("unplugged.seconds")), 2)


def skip(why):
    print("camera.machine: skipped: " + why)
    sys.exit(SKIP)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    for option in ("raygrid", "camera", "emulated-camera", "undistort-frames", "kernel"):
        parser.add_argument("--" + option, required=True)
    parser.add_argument("--only-ends", action="store_true",
                        help="not the long streams: for programs that are slow")
    _, rest = parser.parse_known_args(namespace=programs)
    for tool in ("qemu-system-x86_64", "cpio", "modprobe"):
        if not shutil.which(tool, path=os.environ["PATH"] + ":/sbin:/usr/sbin"):
            skip(f"{tool} is missing; tools/install_packages camera-machine installs it")
    if not os.path.isdir(os.path.join(programs.kernel, "boot")):
        skip("no kernel; tests/camera/vm/fetch_kernel FOLDER fetches Debian's")
    unittest.main(argv=[sys.argv[0]] + rest, verbosity=2)
