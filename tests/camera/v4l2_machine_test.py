#!/usr/bin/env python3
"""raygrid-camera with V4L2 alone: USB cameras and vivid's, with kernels of Debian that have no heap of
dma-bufs, or one."""
import subprocess
import unittest

import machine_case
from machine_case import MachineCase, has_kernel, programs, raygrid

STREAMS = """
run vga vga.raygrid --source $(device -1:1.0) --frames 40 --every-frame -o vga
run odd odd.raygrid --source $(device -2:1.0) --size 640x480 --frames 10 --every-frame -o odd
run jpeg vga.raygrid --source $(device -4:1.0) --frames 10 --every-frame -o jpeg
run benchmark vga.raygrid --source $(device -1:1.0) --benchmark
"""
ENDS = """
run several vga.raygrid --source v4l2 --frames 1
run other_size vga.raygrid --source $(device -2:1.0) --frames 1 -o other_size
run terminated vga.raygrid --source $(device -1:1.0) -o terminated &
wait_for terminated
run second vga.raygrid --source $(device -1:1.0) --frames 1
end TERM terminated
run unplugged vga.raygrid --source $(device -3:1.0) -o unplugged

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
run check stood.raygrid --source $single --check
run same stood.raygrid --source $single --format NV12 $still --strict
run flipped stood.raygrid --source $single --format NV12 $still --control horizontal_flip=1
run strict stood.raygrid --source $single --format NV12 $still --control horizontal_flip=1 --strict
for control in gain=300 nonsense=1 inject_vidioc_reqbufs_error=1 disconnect=1; do
  run vivid_${control%=*} vga.raygrid --source $single --control $control --frames 1
done
"""
HEAP = """
modprobe vivid n_devs=3 node_types=1,1,1 multiplanar=1,2,1 allocators=0,0,1 cache_hints=0,0,1
udevadm settle
run vga vga.raygrid --source $(device -1:1.0) --frames 10 --every-frame -o vga
run benchmark vga.raygrid --source $(device -1:1.0) --benchmark
still="--control osd_text_mode=None --frames 3 --every-frame"
for i in 0 1 2; do
  run vivid$i vga.raygrid --source $(device vivid-00$i) --format NV12 $still -o vivid$i
done
"""


class V4l2InMachine(MachineCase):
    CAMERAS = ("vga", "odd")
    PLAYERS = (("vga", 10), ("odd", 10), ("vga", 10, 20), ("vga", 5, 0, ".mjpeg"))

    @classmethod
    def make_more(cls):
        """A blob that records how the camera stood, and some of the frames as JPEGs."""
        raygrid("pack", cls.path("vga_scene/true_camera.yaml"), "--remap", "640x480,hfov=80",
                "--capture-settings", "orientation=1,lens=2", "-o", cls.path("shared/stood.raygrid"))
        subprocess.run(["ffmpeg", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "yuyv422",
                        "-video_size", "640x480", "-i", cls.path("vga.yuyv"), "-frames:v", "20",
                        "-q:v", "2", "-f", "mjpeg", cls.path("vga.mjpeg")], check=True)

    @classmethod
    def setUpClass(cls):
        cls.set_up(programs.kernel, ("" if programs.only_ends else STREAMS) + ENDS)

    def test_frames_are_those_of_the_host(self):
        self.check_stream("vga", 40)
        self.check_stream("odd", 10)
        self.assertIn("frame buffers: the driver's\n", self.read("vga.err"))

    def test_benchmark(self):
        if programs.only_ends:
            self.skipTest("--only-ends: sanitizers are too slow for the frames")
        self.check_benchmark("the driver's")

    def test_jpegs(self):
        if programs.only_ends:
            self.skipTest("--only-ends: sanitizers are too slow for the frames")
        self.assert_ends("jpeg", 0)
        with open(self.path("vga.mjpeg"), "rb") as file:
            expected = subprocess.run(
                [programs.camera, self.path("shared/vga.raygrid"), "--from", "-", "--quiet", "-o",
                 "-"], stdin=file, check=True, capture_output=True).stdout
        size = 640 * 480 * 3
        self.assertEqual(len(expected), 20 * size)
        expected = {expected[k:k + size] for k in range(0, len(expected), size)}
        frames = self.frames("jpeg")
        self.assertEqual(len(frames), 10)
        for header, planes in frames:
            self.assertEqual(header["format"], "BGR888")
            self.assertIn(planes, expected)
        self.assertEqual(self.counts("jpeg")["damaged"], 0)

    def test_formats(self):
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

    def test_frames_are_compared_with_calibration(self):
        self.assertEqual(self.status("check"), 0, self.read("check.err"))
        self.assertIn("; capture settings: ", self.read("check.out"))
        self.assertIn("orientation=1\n", self.read("check.out"))
        untold = "the camera does not report lens position; "
        for name, status, count in (("same", 0, 0), ("flipped", 0, 3)):
            error = self.read(name + ".err")
            self.assertEqual(self.status(name), status, error)
            self.assertEqual(error.count(untold), 1, error)
            self.assertIn(f", capture settings differ: {count} frames", error)
        self.assertEqual(error.count("frames are mirrored (2), but calibration had upright (1)"),
                         1, error)
        self.assertEqual(self.status("strict"), 8)
        self.assertIn("raygrid-camera: --strict: capture settings differ from calibration: frames are mirrored",
                      self.read("strict.err"))

    def test_devices_that_cannot_be_used(self):
        self.assert_ends("several", 2, "--source v4l2:/dev/video")
        self.assert_ends("other_size", 8, "640x480", "634x478", "--list")
        self.assert_ends("second", 2, "/dev/video", "in use by another process")
        self.assert_ends("vivid_gain", 2, "/dev/video", "gain")
        self.assert_ends("vivid_nonsense", 2, "nonsense", "--list")
        self.assert_ends("vivid_inject_vidioc_reqbufs_error", 2, "cannot allocate frame buffers")
        self.assert_ends("vivid_disconnect", 2, "disconnected")

    def test_a_signal_ends_it_in_order(self):
        self.assert_ends("terminated", 0)
        frames, _ = self.check_frames("vga", "terminated")
        self.assertEqual(len(frames), self.counts("terminated")["written"])
        self.assertLessEqual(int(self.read("terminated.seconds")), 2)

    def test_a_camera_that_is_unplugged(self):
        self.check_unplugged("unplugged")


class V4l2WithHeap(MachineCase):
    CAMERAS = ("vga",)
    PLAYERS = (("vga", 10),)

    @classmethod
    def setUpClass(cls):
        if not has_kernel(programs.heap_kernel):
            raise unittest.SkipTest(
                "no kernel with heaps; tests/camera/vm/fetch_kernel FOLDER trixie fetches it")
        cls.set_up(programs.heap_kernel, HEAP)

    def test_frames_of_a_heaps_memory_are_those_of_the_host(self):
        self.check_stream("vga", 10)
        self.assertIn("frame buffers: /dev/dma_heap/system, cached\n", self.read("vga.err"))

    def test_benchmark(self):
        self.check_benchmark("/dev/dma_heap/system, cached")

    def test_memory_is_the_drivers_where_it_refuses_the_heaps(self):
        planes = []
        for name, memory in (("vivid0", "/dev/dma_heap/system, cached"),
                             ("vivid1", "/dev/dma_heap/system, cached"),
                             # It wants memory in one piece.
                             ("vivid2", "the driver's, cached")):
            self.assert_ends(name, 0)
            self.assertIn(f"frame buffers: {memory}\n", self.read(name + ".err"))
            planes += [frame for _, frame in self.frames(name)]
        self.assertEqual(len(planes), 9)
        self.assertEqual(len(set(planes)), 1)


if __name__ == "__main__":
    machine_case.main("camera.machine_v4l2")
