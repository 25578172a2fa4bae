#!/usr/bin/env python3
"""How the camera stood while it was calibrated: from a camera.yaml or by hand into a blob, and back."""
import json
import subprocess
import sys

from command_test import CommandTest, main, programs, read, run, with_word, write

CAPTURE = """capture:
  lens_position: 2.5
  lens_tolerance: 0.25
  crop: [8, -4, 320, 240]
  zoom: 1
  orientation: 3
  sensor_temperature_c: -5.5
  exposure_us: 8333
  analogue_gain: 1.5
"""
FACTS = {"lens_position_dpt": 2.5, "lens_tolerance_dpt": 0.25, "crop": [8, -4, 320, 240],
         "zoom": 1.0, "orientation": 3, "sensor_temperature_c": -5.5, "exposure_us": 8333.0,
         "analogue_gain": 1.5}
CAPTURE_SECTION = 11
# Offsets in the section, and values that no writer writes.
NONSENSE = ((16, 0), (20, 0), (16, 0xffffffff), (8, 0x80000000), (0, 0x7fffffff), (4, 0xffffffff),
            (24, 0), (28, 0), (28, 0x030f00ff), (28, 0x0000090f), (28, 0x0000037e), (28, 0x000003ff), (32, 0x04000001), (36, 0), (36, 0x40000001),
            (40, 0), (40, 0x04000001))


class CaptureTest(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.camera = cls.simulated_camera("wide")
        cls.known = write(cls.path("known.yaml"), read(cls.camera) + CAPTURE.encode())
        assert run("pack", cls.known, "-o", cls.path("known.raygrid")).returncode == 0

    def pack(self, *options, camera=None):
        return run("pack", camera or self.camera, *options, "-o", self.path("c.raygrid"))

    def facts(self, name="c.raygrid"):
        result = self.succeed("inspect", self.path(name), "--json")
        return json.loads(result.stdout)

    def test_camera_file_goes_into_the_blob(self):
        facts = self.facts("known.raygrid")
        self.assertEqual(facts["format_version"], "1.6")
        self.assertEqual(facts["capture"], FACTS)
        self.assertEqual(self.facts("known.yaml")["capture"], FACTS)
        text = run("inspect", self.path("known.raygrid")).stdout
        self.assertIn("capture: lens position 2.5 dpt, lens tolerance 0.25 dpt, crop 8, -4, 320, 240, "
                      "zoom 1, orientation 3, sensor temperature -5.5 °C, exposure 8333 us, "
                      "analogue gain 1.5\n", text)

    def test_independent_reader_agrees(self):
        told = subprocess.run([sys.executable, programs.reference, "inspect",
                               self.path("known.raygrid")], capture_output=True, text=True, check=True)
        self.assertIn("capture:\n  lens_position: 163840\n  lens_tolerance: 16384\n"
                      "  crop: (8, -4, 320, 240)\n  zoom: 65536\n  orientation: 3\n  temperature: -360448\n"
                      "  exposure: 8333\n  gain: 98304\n", told.stdout)

    def test_words_say_it_by_hand(self):
        self.assert_done(self.pack("--capture-settings", "crop=8,-4,320,240,lens=2.5", "--capture-settings",
                                   "tolerance=0.25,zoom=1,orientation=3,temperature=-5.5,exposure=8333,"
                                   "gain=1.5"))
        self.assertEqual(read(self.path("c.raygrid")), read(self.path("known.raygrid")))
        self.assert_done(self.pack("--capture-settings", "lens=1"))
        self.assertEqual(self.facts()["capture"], {"lens_position_dpt": 1.0, "lens_tolerance_dpt":
                                                   round(0.1 * 65536) / 65536})

    def test_words_stand_instead_of_those_of_the_file(self):
        self.assert_done(self.pack("--capture-settings", "orientation=1,lens=0", camera=self.known))
        self.assertEqual(self.facts()["capture"], {**FACTS, "lens_position_dpt": 0.0,
                                                   "orientation": 1})

    def test_blobs_without_are_as_ever(self):
        self.assert_done(self.pack())
        plain = read(self.path("c.raygrid"))
        self.assertNotIn("capture", self.facts())
        self.assertEqual(self.facts()["format_version"], "1.3")
        self.assert_done(self.pack("--capture-settings", "none", camera=self.known))
        self.assertEqual(read(self.path("c.raygrid")), plain)
        self.assertEqual(len(read(self.path("known.raygrid"))), len(plain) + 16 + 44)

    def test_fit_keeps_it(self):
        for camera in ("known.yaml", "known.raygrid"):
            self.succeed("fit", self.path(camera), "--model", "opencv", "-o",
                         self.path("fitted.yaml"))
            self.assertEqual(self.facts("fitted.yaml")["capture"], FACTS)
            self.assert_done(self.pack(camera=self.path("fitted.yaml")))
            self.assertEqual(self.facts()["capture"], FACTS)

    def test_wrong_words_are_refused(self):
        for words, said in (
                ("", "empty"), ("lens", "lens=DIOPTRES"), ("focus=1", "'focus=1'"),
                ("lens=near", "'near'"), ("lens=nan", "lens"), ("lens=1025", "1024"),
                ("lens=1,tolerance=-1", "tolerance"), ("tolerance=1", "requires lens"),
                ("lens=1,lens=2", "twice"), ("crop=0,0,320", "four numbers"),
                ("crop=0,0,320x240", "four numbers"), ("crop=0,0,0,240", "crop"),
                ("crop=0,0,320,-240", "crop"), ("crop=0,0,1.5,240", "integer"),
                ("crop=0,0,1e12,240", "integer"), ("crop=70000,0,320,240", "65536"),
                ("crop=0,0,10241,240", "64"), ("zoom=0.99", "zoom"), ("zoom=inf", "zoom"),
                ("orientation=0", "1 to 8"), ("orientation=9", "1 to 8"),
                ("orientation=1.5", "integer"), ("none,lens=1", "none")):
            with self.subTest(words):
                self.assert_refused(self.pack("--capture-settings", words), 1, "--capture-settings", said)

    def test_wrong_files_are_refused(self):
        for capture, said in (
                ("capture: 5\n", "mapping"), ("capture: {}\n", "capture: empty"),
                ("capture: {lens: 1}\n", "'lens'"), ("capture: {lens_tolerance: 1}\n", "requires"),
                ("capture: {crop: [0, 0, 320]}\n", "crop"),
                ("capture: {crop: [0, 0, 0, 240]}\n", "crop"),
                ("capture: {crop: [0, 0, 99999999999, 240]}\n", "bad.yaml"),
                ("capture: {crop: [0, 0, a, 240]}\n", "bad.yaml"),
                ("capture: {zoom: .nan}\n", "zoom"), ("capture: {orientation: 9}\n", "1 to 8"),
                ("capture: {lens_position: .inf}\n", "lens_position")):
            with self.subTest(capture):
                bad = write(self.path("bad.yaml"), read(self.camera) + capture.encode())
                for command in (["pack", bad, "-o", self.path("never.raygrid")], ["inspect", bad],
                                ["fit", bad, "--model", "opencv", "-o", self.path("never.yaml")]):
                    self.assert_refused(run(*command), 2, "bad.yaml", said)

    def test_nonsense_of_a_forged_blob_is_refused_everywhere(self):
        blob = read(self.path("known.raygrid"))
        self.assertEqual(with_word(blob, CAPTURE_SECTION, 16, 320), blob)
        for offset, value in NONSENSE:
            forged = write(self.path("forged.raygrid"), with_word(blob, CAPTURE_SECTION, offset, value))
            for command in (["inspect", forged],
                            ["fit", forged, "--model", "opencv", "-o", self.path("never.yaml")],
                            ["export", forged, "--to", "opencv", "-o", self.path("never.yml")]):
                with self.subTest((offset, hex(value), command[0])):
                    self.assert_refused(run(*command), 8, "forged.raygrid")
            self.assertEqual(subprocess.run([sys.executable, programs.reference, "check", forged],
                                            capture_output=True, check=False).returncode, 8)


if __name__ == "__main__":
    main(__name__)
