#!/usr/bin/env python3
"""raygrid-camera on a whole stack: Debian's kernel in QEMU, uvcvideo and libcamera, and USB cameras
that play frames which were rendered through a known lens."""
import os

import machine_case
from machine_case import MachineCase, SIZES, programs

STREAMS = """
run vga vga.raygrid --camera -1:1.0 --frames 40 --every-frame -o vga
run hd hd.raygrid --camera -2:1.0 --frames 40 --every-frame -o hd
run odd odd.raygrid --camera -3:1.0 --size 640x480 --frames 10 --every-frame -o odd
if [ -e /bin/lock_camera_state ]; then
  lock_camera_state $(device -1:1.0) >lock_v4l2.out
  lock_camera_state libcamera:-2:1.0 >lock_libcamera.out
fi
run v4l2_vga vga.raygrid --source $(device -1:1.0) --frames 10 --every-frame -o v4l2_vga
"""
ENDS = """
run list --list
run source --source
run several vga.raygrid --frames 1
run other_size vga.raygrid --camera -2:1.0 --frames 1 -o other_size
run told vga.raygrid --camera -1:1.0 --check
run turned turned.raygrid --camera -1:1.0 --frames 12 --every-frame
run strict turned.raygrid --camera -1:1.0 --frames 12 --every-frame --strict
run points vga.raygrid --camera -1:1.0 --points points.csv

mkdir /tmp/full
mount -t tmpfs -o size=2m none /tmp/full
run full vga.raygrid --camera -1:1.0 -o /tmp/full
ls -l /tmp/full >full.files

run terminated vga.raygrid --camera -1:1.0 -o terminated &
wait_for terminated
run second vga.raygrid --camera -1:1.0 --frames 1
end TERM terminated
run interrupted vga.raygrid --camera -1:1.0 -o interrupted &
wait_for interrupted
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
"""


class CameraInMachine(MachineCase):
    CAMERAS = tuple(SIZES)
    PLAYERS = (("vga", 10), ("hd", 5), ("odd", 10), ("vga", 10, 20))

    @classmethod
    def make_more(cls):
        """A blob that records another orientation, and what this camera does not tell."""
        machine_case.raygrid("pack", cls.path("vga_scene/true_camera.yaml"), "--remap",
                             "640x480,hfov=80", "--capture-settings",
                             "orientation=3,lens=2,crop=0,0,640,480", "-o",
                             cls.path("shared/turned.raygrid"))

    @classmethod
    def setUpClass(cls):
        cls.PROGRAMS = [program for program in [programs.lock_camera_state] if program]
        cls.set_up(programs.kernel, ("" if programs.only_ends else STREAMS) + ENDS)

    def test_vga_frames_are_those_of_the_host(self):
        self.check_stream("vga", 40)

    def test_hd_frames_are_those_of_the_host(self):
        self.check_stream("hd", 40)

    def test_a_size_that_the_driver_adjusts(self):
        self.check_stream("odd", 10)

    def test_v4l2_frames_are_those_of_the_host(self):
        self.check_stream("vga", 10, "v4l2_")

    def test_a_state_is_locked_as_it_stands_and_modes_come_back(self):
        if programs.only_ends or not programs.lock_camera_state:
            self.skipTest("--only-ends, or libcamera or V4L2 is missing")
        told = self.read("lock_v4l2.out").splitlines()
        settings = [line.split(", ") for line in self.players[0].output.splitlines()[1:]]
        self.assertEqual([words[0] for words in settings],
                         ["focus mode 0", "exposure mode 1", "white mode 0", "white mode 1",
                          "exposure mode 8", "focus mode 1"])
        # The camera's own numbers, which change with each frame while the modes are automatic.
        focus, exposure = (int(settings[i][k].split()[1]) for i, k in ((0, 2), (1, 1)))
        self.assertRegex(told[0], r"^before: focus_steps=[0-9]+$")
        self.assertEqual(told[1:],
                         [f"locked: focus at {focus} (0 to 250)",
                          f"locked: exposure {exposure / 10:.1f} ms",
                          "locked: gain at 64 (0 to 255)", "locked: white balance 4600 K",
                          f"after: exposure_us={100 * exposure} focus_steps={focus}"])
        told = self.read("lock_libcamera.out")
        self.assertIn("locked: exposure at a value the camera does not report\n", told)
        self.assertIn("open: focus: libcamera has no control for it\n", told)
        self.assertEqual([line.split(",")[0] for line in
                          self.players[1].output.splitlines()[1:]],
                         ["exposure mode 1", "exposure mode 8"])

    def test_list(self):
        self.assert_ends("list", 0)
        text = self.read("list.out")
        for size in SIZES.values():
            self.assertIn("YUYV {}x{}".format(*size), text)
        self.assertEqual(self.read("source.out"), text)
        for kind in ("libcamera:", "v4l2:/dev/video"):
            cameras = [line for line in text.splitlines() if line.startswith(kind)]
            self.assertEqual(len(cameras), 4)
            for camera in cameras:
                self.assertIn("(Emulated camera", camera)

    def test_several_cameras_need_a_choice(self):
        self.assert_ends("several", 2, "--camera")

    def test_a_blob_of_another_size_is_refused_with_the_remedy(self):
        self.assert_ends("other_size", 8, "640x480", "1280x720", "--list")
        self.assertFalse(os.path.exists(os.path.join(self.shared, "other_size")))

    def test_frames_are_compared_with_calibration(self):
        self.assert_ends("told", 0)
        self.assertIn("; capture settings: orientation=1\n", self.read("told.out"))
        error = self.read("turned.err")
        self.assertEqual(self.status("turned"), 0, error)
        for said in ("frames are upright (1), but calibration had rotated by 180 degrees (3); ",
                     "the camera does not report lens position, crop; "):
            self.assertEqual(error.count(said), 1, error)
        self.assertIn("12 delivered", error)
        self.assertRegex(error, r", capture settings differ: 1[2-9] frames")
        self.assertEqual(self.status("strict"), 8)
        self.assertIn("raygrid-camera: --strict: capture settings differ from calibration: frames are upright",
                      self.read("strict.err"))

    def test_points(self):
        self.assert_ends("points", 0)
        lines = self.read("points.out").splitlines()
        self.assertEqual(lines[0], "x,y,u,v")
        self.assertEqual(len(lines), 3)
        u, v = map(float, lines[1].split(",")[2:])
        self.assertLess(abs(u - 319.5) + abs(v - 239.5), 20)

    def test_a_full_disk(self):
        self.assert_ends("full", 7, "No space left", "free disk space")
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
        self.check_unplugged("disconnected")
        self.assertLessEqual(int(self.read("unplugged.seconds")), 2)


if __name__ == "__main__":
    machine_case.main("camera.machine")
