#!/usr/bin/env python3
"""GStreamer's pipeline from a USB camera to a file, with the element raygridundistort."""
import shutil
import subprocess
import sys

import machine_case
from machine_case import MachineCase, programs

JOB = """
export GST_PLUGIN_PATH=/bin GST_PLUGIN_SYSTEM_PATH= GST_REGISTRY=/tmp/registry GST_REGISTRY_FORK=no
launch() {  # NAME BUFFERS PROPERTIES: leaves NAME.raw, .status and .err
  device=$(device -1:1.0)
  gst-launch-1.0 -q v4l2src device=${device#v4l2:} num-buffers=$2 \
    ! video/x-raw,format=YUY2,width=640,height=480 ! raygridundistort $3 \
    ! filesink location=$1.raw >$1.err 2>&1
  echo $? >$1.status
}
launch view 10 blob=vga.raygrid
launch threads 3 "blob=vga.raygrid threads=2"
launch missing 1 blob=nothing.raygrid
"""


def plugins():
    """The plugins of the pipeline; None where one is missing."""
    found = subprocess.run(["pkg-config", "--variable=pluginsdir", "gstreamer-1.0"],
                           capture_output=True, text=True, check=True).stdout.strip()
    return [f"{found}/libgst{name}.so" for name in ("coreelements", "video4linux2")]


class GstreamerInMachine(MachineCase):
    CAMERAS = ("vga",)
    PLAYERS = (("vga", 10),)

    @classmethod
    def setUpClass(cls):
        cls.PROGRAMS = [shutil.which("gst-launch-1.0"), *plugins(), programs.plugin]
        cls.set_up(programs.kernel, JOB)

    def check_file(self, name, count):
        self.assertEqual(self.status(name), 0, self.read(name + ".err"))
        size = 2 * 640 * 480
        with open(self.path("vga.undistorted"), "rb") as file:
            expected = file.read()
        expected = [expected[k:k + size] for k in range(0, len(expected), size)]
        with open(self.path(f"shared/{name}.raw"), "rb") as file:
            written = file.read()
        self.assertEqual(len(written), count * size)
        indices = [expected.index(written[k:k + size]) for k in range(0, len(written), size)]
        self.assertEqual(len(set(indices)), count)

    def test_frames_are_those_of_the_host(self):
        self.check_file("view", 10)

    def test_threads_change_nothing(self):
        self.check_file("threads", 3)

    def test_a_blob_that_is_missing_is_named(self):
        self.assertNotEqual(self.status("missing"), 0)
        self.assertIn("nothing.raygrid", self.read("missing.err"))


if __name__ == "__main__":
    if not shutil.which("gst-launch-1.0"):
        print("gstreamer.machine: skipped: gst-launch-1.0 is missing; tools/install_packages "
              "camera-machine installs it")
        sys.exit(machine_case.SKIP)
    machine_case.main("gstreamer.machine")
