#!/usr/bin/env python3
"""The examples undistort_frame and track_point, as a user runs them, against the reference."""
import math
import os
import subprocess
import sys
import tempfile
import unittest

import blob_reference as reference
import make_golden

UNDISTORT, TRACK = sys.argv[1:3]
NV12 = next(f for f in make_golden.FORMATS if len(f) == 2 and {p.plane for p in f} == {0, 1})


def run(*command):
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)


class ExamplesTest(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)

    def path(self, name):
        return os.path.join(self._folder.name, name)

    def write(self, name, data):
        with open(self.path(name), "wb") as file:
            file.write(data)
        return self.path(name)

    def write_blob(self, blob):
        return self.write("camera.raygrid", reference.serialize(blob))

    def test_nv12_frame_is_undistorted_as_the_reference_does(self):
        blob = make_golden.make_wide()
        size = blob.camera.width, blob.camera.height
        frame = make_golden.make_frame(size[0], size[1] * 3 // 2)
        planes = {0: frame[:size[0] * size[1]], 1: frame[size[0] * size[1]:]}
        expected = b""
        for place in NV12:
            rows = [bytearray(row) for row in reference.sample_rows(planes[place.plane], size[0])]
            out_size = make_golden.plane_sizes(NV12, blob.remap.width,
                                               blob.remap.height)[place.plane]
            output = [bytearray(out_size[0]) for _ in range(out_size[1])]
            for channel in range(place.channels):
                make_golden.remap_channel(blob, place, channel, rows, output,
                                          (16, 128)[place.plane], False)
            expected += b"".join(output)
        done = run(UNDISTORT, self.write_blob(blob), self.write("in.nv12", frame),
                   self.path("out.nv12"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout, f"{blob.remap.width} x {blob.remap.height}\n")
        with open(self.path("out.nv12"), "rb") as file:
            self.assertEqual(file.read(), expected)

    def test_short_frame_is_refused(self):
        done = run(UNDISTORT, self.write_blob(make_golden.make_wide()),
                   self.write("in.nv12", b"123"), self.path("out.nv12"))
        self.assertEqual(done.returncode, 1)
        self.assertIn("not an NV12 frame", done.stderr)
        self.assertFalse(os.path.exists(self.path("out.nv12")))

    def track(self, blob, *numbers):
        done = run(TRACK, self.write_blob(blob), *numbers)
        self.assertEqual(done.returncode, 0, done.stderr)
        return {line.split()[0]: line.split()[1:] for line in done.stdout.splitlines()}

    def test_point_stays_where_the_camera_does(self):
        found = self.track(make_golden.make_wide(), 120.25, 90.5, 0, 0)
        self.assertAlmostEqual(float(found["pixel"][0]), 120.25, delta=0.002)
        self.assertAlmostEqual(float(found["pixel"][1]), 90.5, delta=0.002)

    def test_point_is_found_where_the_reference_sees_it_again(self):
        blob = make_golden.make_wide()
        found = self.track(blob, 150, 110, 12, -7)
        before = reference.unproject(blob, 150, 110)
        after = reference.unproject(blob, *map(float, found["pixel"]))
        for value, expected in zip(found["direction"], before):
            self.assertAlmostEqual(float(value), expected, delta=2e-6)
        yaw, pitch = math.radians(12), math.radians(-7)
        x, y, z = before
        x, z = x * math.cos(yaw) - z * math.sin(yaw), x * math.sin(yaw) + z * math.cos(yaw)
        z, y = z * math.cos(pitch) - y * math.sin(pitch), z * math.sin(pitch) + y * math.cos(pitch)
        for value, expected in zip(after, (x, y, z)):
            self.assertAlmostEqual(value, expected, delta=1e-4)

    def test_point_behind_the_camera_is_out_of_sight(self):
        done = run(TRACK, self.write_blob(make_golden.make_wide()), 160, 120, 180, 0)
        self.assertEqual(done.stdout.splitlines()[-1], "not visible")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
