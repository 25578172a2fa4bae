#!/usr/bin/env python3
"""A live capture on a whole stack: Debian's kernel in QEMU, uvcvideo, raygrid-capture, and a USB
camera whose rendered board follows the outline of the page. It is unplugged in the middle. With
--until-done the page's last word is waited for, and the camera found compared with the truth."""
import json
import os
import subprocess
import time

import machine
import machine_case
from machine_case import MachineCase, programs, raygrid

SIZE = (320, 240)
RATE = 10
BOARD = "star:14x10:18mm"
LENS = "wide"
UNPLUG_AT, FINISH_AT = 2, 3  # kept frames; to the end takes several minutes
TOKEN = "token-of-the-emulated-machine"
PORT = 8080
JOB = f"""
modprobe virtio_net
ifconfig lo up
ifconfig eth0 10.0.2.15 netmask 255.255.255.0 up
capture() {{  # NAME OPTIONS: leaves NAME.status, .out and .err, how long it took to end
  name=$1
  shift
  raygrid-capture --source $(device -1:1.0) --pattern {BOARD} -o session --until 0.03px \\
    --no-calibrate --listen 0.0.0.0 --port {PORT} --token-file token --timeout 60 \\
    "$@" >$name.out 2>$name.err
  echo $? >$name.status
  cut -d' ' -f1 /proc/uptime >$name.uptime
}}
raygrid-capture --list >list.out 2>list.err
echo $? >list.status
capture unplugged
cp session/session.json unplugged.json
ls session/frames >unplugged.frames
until [ -n "$(device -1:1.0)" ]; do sleep 0.1; done
capture resumed --resume
"""


class CaptureInMachine(MachineCase):
    PLAYERS = (("live", RATE),)

    @classmethod
    def setUpClass(cls):
        # Emulated AVX2 takes eight times as long as what is without it.
        cls.MACHINE = {"cpu": "max,-avx,-avx2,-fma", "forward": (machine.free_port(), PORT),
                       "timeout": 2700 if programs.until_done else 500}
        folder = os.path.dirname(programs.raygrid)
        cls.PROGRAMS = [os.path.join(folder, "raygrid-capture")]
        start = time.monotonic()
        cls.set_up(programs.kernel, JOB)
        print(f"{time.monotonic() - start:.0f} s")
        cls.said = cls.operator.communicate(timeout=20)[1].decode()
        if programs.until_done:
            raygrid("calibrate", cls.path("shared/session"))

    @classmethod
    def make_more(cls):
        with open(cls.path("shared/token"), "w", encoding="utf-8") as file:
            file.write(TOKEN + "\n")
        raygrid("simulate", "--images", 1, "--lens", LENS, "--size", "{}x{}".format(*SIZE), "-o",
                cls.path("scene"))

    @classmethod
    def play(cls, name, rate, unplug_after=0, ending=""):
        # pylint: disable=consider-using-with
        cls.operator = subprocess.Popen(
            [programs.play_to_outline, str(cls.MACHINE["forward"][0]), f"10.0.2.15:{PORT}", TOKEN,
             LENS, "{}x{}".format(*SIZE), BOARD, str(UNPLUG_AT),
             "0" if programs.until_done else str(FINISH_AT)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        cls.addClassCleanup(cls.operator.kill)
        player = machine.Player(programs.emulated_camera, cls.folder, name, SIZE, rate, "-",
                                orders=cls.operator.stdout)
        cls.addClassCleanup(player.kill)
        cls.operator.stdout.close()  # the camera's alone
        cls.operator.stdout = None
        return player

    def session(self, name):
        """The frames of a session file, whose images are all there."""
        frames = json.loads(self.read(name))["frames"]
        for frame in frames:
            path = os.path.join(self.shared, "session", "frames", frame["image"])
            with open(path, "rb") as file:
                self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")
        return frames

    def test_an_unplugged_camera_leaves_all_kept_frames(self):
        self.assertEqual(self.status("unplugged"), 2)
        said = [line for line in self.read("unplugged.err").splitlines()
                if line.startswith("raygrid-capture: ")]
        self.assertEqual(said, ["raygrid-capture: camera: disconnected; reconnect it"])
        frames = self.session("unplugged.json")
        self.assertGreaterEqual(len(frames), UNPLUG_AT)
        self.assertEqual([frame["image"] for frame in frames],
                         self.read("unplugged.frames").split())

    def test_it_lists_the_camera(self):
        self.assertEqual(self.status("list"), 0, self.read("list.err"))
        text = self.read("list.out")
        self.assertRegex(text, r"v4l2:/dev/video[0-9]+ \(Emulated camera")
        self.assertIn("YUYV {}x{}".format(*SIZE), text)

    def test_it_goes_on(self):
        self.assertEqual(self.status("resumed"), 0, self.read("resumed.err"))
        before, frames = self.session("unplugged.json"), self.session("session/session.json")
        self.assertEqual(frames[:len(before)], before)
        self.assertGreater(len(frames), len(before))
        self.assertRegex(self.said, rf"^{len(frames)} frames kept of [0-9]+ views\n$")
        # All with the focus of the first one, though the camera forgot it.
        self.assertEqual(len({frame["focus_steps"] for frame in frames}), 1)

    def test_the_camera_is_accurate(self):
        if not programs.until_done:
            self.skipTest("without --until-done the session ends after a few frames, "
                          "too few to calibrate with")
        told = subprocess.run(
            [programs.raygrid, "compare", self.path("scene/true_camera.yaml"),
             os.path.join(self.shared, "session/calibration/camera.yaml"), "--json"],
            check=True, capture_output=True, text=True).stdout
        print(self.said.strip(), told)
        self.assertLessEqual(json.loads(told)["median_px"], 0.02)


if __name__ == "__main__":
    machine_case.main("camera.machine_capture")
