#!/usr/bin/env python3
"""Images as people and cameras leave them: turned, deep, of other sizes, no images at all. What is
given stays as it is."""
import json
import os
import struct
import subprocess
import zlib

import png_files
from command_test import HANG_S, CommandTest, PATTERN, SIMULATED_PATTERN, call, commands, main, programs, read, run, write
from png_files import chunk, read_png

SIZE = (160, 120)
# Grey levels between remaps in 8 bits and in more: the runtime's weights are coarser there.
NEAR = 3


def png(pixels, channels=1, bits=8, size=SIZE, chunks=b""):
    return png_files.png(pixels, size, channels, bits, chunks)


def tiff(pixels, orientation, size=SIZE):
    """8 bits, grey."""
    entries = [(256, size[0]), (257, size[1]), (258, 8), (259, 1), (262, 1), (273, 8),
               (274, orientation), (277, 1), (278, size[1]), (279, len(pixels))]
    return (b"II*\0" + struct.pack("<I", 8 + len(pixels)) + bytes(pixels) +
            struct.pack("<H", len(entries)) +
            b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in entries) + bytes(4))


def exif(orientation):
    return struct.pack("<2sHIHHHIII", b"II", 42, 8, 1, 274, 4, 1, orientation, 0)


def scene():
    return [(3 * x + 2 * y + ((x // 16 + y // 16) % 2) * 60) % 256
            for y in range(SIZE[1]) for x in range(SIZE[0])]


class Images(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for arguments in (("simulate", "--images", 1, "--lens", "wide", "--size", "160x120", "-o",
                           cls.path("sim")),
                          ("pack", cls.path("sim/true_camera.yaml"), "--remap", "160x120", "-o",
                           cls.path("c.raygrid"))):
            cls.succeed(*arguments)
        cls.grey = png(scene())

    def undistort(self, *images, to="flat", **options):
        more = [word for name, value in options.items() for word in ("--" + name, value)]
        return run("undistort", self.path("c.raygrid"), *images, "-o", self.path(to), *more)

    def undistorted(self, contents, name):
        self.assert_done(self.undistort(write(self.path("in/" + name), contents), to="kept"))
        return read_png(self.path("kept/" + name.split(".")[0] + ".png"))

    # ---- What undistort writes ----------------------------------------------

    def test_a_program_found_in_the_path_reads_images(self):
        picture = write(self.path("path/a.png"), png(scene()))
        pattern = write(self.path("path/pattern.yaml"), PATTERN)
        path = os.path.dirname(programs.raygrid) + os.pathsep + os.environ["PATH"]
        result = subprocess.run(
            [os.path.basename(programs.raygrid), "detect", picture, "--pattern", pattern, "--no-cache",
             "-o", self.path("path/f.csv")], env={**os.environ, "PATH": path}, cwd=self.folder,
            capture_output=True, text=True, timeout=HANG_S, check=False)
        self.assert_refused(result, 3, "no target found")

    def test_images_that_would_get_one_name_are_refused(self):
        for pair in (("one/x.pgm", "two/x.pgm"), ("one/y.png", "one/y.pgm")):
            for name in pair:
                write(self.path(name), self.grey)
            with self.subTest(pair):
                for options in ({}, {"frames": self.path("none/frames")}):
                    result = self.undistort(*map(self.path, pair), to="none", **options)
                    self.assert_refused(result, 2, *pair)
                    self.assert_nothing_in(self.path("none"))

    def test_channels_and_depth_are_kept(self):
        levels = scene()
        channels, bits, grey = self.undistorted(self.grey, "grey.png")
        self.assertEqual((channels, bits), (1, 8))
        pgm = b"P5 160 120 255\n" + bytes(levels)
        self.assertTrue(self.undistorted(pgm, "grey8.pgm") == (1, 8, grey))
        for name, count, size in (("rgb.png", 3, 8), ("rgba.png", 4, 8), ("deep_rgb.png", 3, 16)):
            with self.subTest(name):
                scale = 1 if size == 8 else 257
                samples = [scale * level for level in levels for _ in range(count)]
                channels, bits, got = self.undistorted(png(samples, count, size), name)
                self.assertEqual((channels, bits), (count, size))
                self.assertLessEqual(max(abs(got[count * i + c] / scale - grey[i])
                                         for i in range(len(grey)) for c in range(count)), NEAR)
        # Twelve bits of sixteen: the values stay, and no bit is lost.
        deep = [16 * level + i % 16 for i, level in enumerate(levels)]
        for name, contents in (("deep.png", png(deep, bits=16)),
                               ("deep.pgm", b"P5 160 120 4095\n" +
                                struct.pack(f">{len(deep)}H", *deep))):
            with self.subTest(name):
                channels, bits, got = self.undistorted(contents, name)
                self.assertEqual((channels, bits), (1, 16))
                self.assertGreater(len(set(got)), 1000)
                self.assertLessEqual(max(abs(a / 16 - b) for a, b in zip(got, grey)), NEAR)

    def test_deep_frames_are_undistorted_as_deep_images(self):
        levels = [251 * level + i % 251 for i, level in enumerate(scene())]
        image = write(self.path("raw/a.png"), png(levels, bits=16))
        self.assert_done(self.undistort(image, to="raw/flat", frames=self.path("raw/frames")))
        frame = self.path("raw/frames/a.raw")
        self.assertEqual(read(frame), struct.pack(f"<{len(levels)}H", *levels))
        self.succeed(self.path("c.raygrid"), frame, self.path("raw/b.raw"),
                     program=programs.undistort)
        expected = read_png(self.path("raw/flat/a.png"))[2]
        self.assertEqual(read(self.path("raw/b.raw")), struct.pack(f"<{len(levels)}H", *expected))
        self.succeed(self.path("c.raygrid"), frame, self.path("raw/b.pgm"),
                     program=programs.undistort)
        self.assertEqual(read(self.path("raw/b.pgm")), b"P5\n160 120\n65535\n" +
                         struct.pack(f">{len(levels)}H", *expected))

    # ---- Outputs never replace inputs -----------------------------------------

    def assert_kept(self, path, contents, result, *words):
        self.assert_refused(result, 7, "would overwrite", *words)
        self.assertEqual(read(path), contents)

    def test_inputs_are_not_replaced(self):
        image = write(self.path("png/a.png"), self.grey)
        self.assert_kept(image, self.grey, self.undistort(self.path("png"), to="png"), "png/a.png")
        os.symlink(self.path("png"), self.path("link"))
        self.assert_kept(image, self.grey, self.undistort(self.path("png"), to="link"))
        pattern = write(self.path("png/pattern.yaml"), SIMULATED_PATTERN)
        for options in (("--overlay", self.path("png"), "-o", self.path("png/features.csv")),
                        ("-o", image)):
            result = run("detect", self.path("png"), "--pattern", pattern, *options)
            self.assert_kept(image, self.grey, result)
        self.assertEqual(sorted(os.listdir(self.path("png"))), ["a.png", "pattern.yaml"])
        camera = self.path("sim/true_camera.yaml")
        points = write(self.path("points.csv"), "x,y,z\n0,0,1\n")
        pixels = write(self.path("pixels.csv"), "x,y\n80,60\n")
        for path, arguments in (
                (pattern, ("detect", image, "--pattern", pattern, "-o", pattern)),
                (pattern, ("simulate", "--pattern", pattern, "-o", self.path("png"))),
                (pattern, ("calibrate", image, "--pattern", pattern, "-o", self.path("png"))),
                (self.path("sim/features.csv"),
                 ("calibrate", "--features", self.path("sim/features.csv"), "--image-size",
                  "160x120", "--pattern", pattern, "-o", self.path("sim")))):
            with self.subTest(arguments[0]):
                self.assert_kept(path, read(path), run(*arguments))
        values = {"CAMERA": camera, "FIRST": camera, "SECOND": camera, "FILES": camera, "IMAGES": image,
                  "--points": points, "--pixels": pixels, "--model": "opencv", "--pattern": pattern,
                  "--features": self.path("sim/features.csv")}
        for name in sorted(set(commands()) - {"capture"}):  # which runs until it is stopped
            for path in (camera, points, pixels, image, pattern):
                words = call({**values, "--output": path}.get, name)
                if not words or path not in words[:-1] or "--output" not in run(name, "--help").stdout:
                    continue
                with self.subTest(words):
                    contents = read(path)
                    result = run(*words, *(() if "--output" in words else ("-o", path)))
                    self.assertNotEqual(result.returncode, 0)
                    self.assertEqual(read(path), contents)

    def test_pictures_are_not_written_among_the_images(self):
        folder = self.path("jpg")
        image = write(os.path.join(folder, "a.pgm"), b"P5 160 120 255\n" + bytes(scene()))
        pattern = write(self.path("p.yaml"), SIMULATED_PATTERN)
        for result in (self.undistort(folder, to="jpg"), self.undistort(image, to="jpg/."),
                       run("detect", folder, "--pattern", pattern, "-o", self.path("f.csv"),
                           "--overlay", folder)):
            self.assert_refused(result, 7, "a.pgm", "use another output folder")
        self.assertEqual(os.listdir(folder), ["a.pgm"])

    # ---- Turned images ----------------------------------------------------------

    def test_images_tagged_as_turned_are_named_and_used_as_stored(self):
        levels = scene()
        whole = {"plain.png": self.grey, "upright.png": png(levels, chunks=chunk(b"eXIf", exif(1))),
                 "turned.png": png(levels, chunks=chunk(b"eXIf", exif(6))),
                 "upright.tif": tiff(levels, 1), "mirrored.tif": tiff(levels, 2),
                 "quarter.tif": tiff(levels, 8), "half.tif": tiff(levels, 3)}
        expected = self.undistorted(self.grey, "plain.png")
        for name, contents in whole.items():
            image = write(self.path("turned/" + name), contents)
            with self.subTest(name):
                stem = name.split(".")[0]
                folder = "untwisted/" + name.replace(".", "-")
                result = self.undistort(image, to=folder)
                self.assert_done(result)
                flat = self.path(f"{folder}/{stem}.png")
                self.assertTrue(read_png(flat) == expected)  # no diff of 19200 numbers
                is_turned = name not in ("plain.png", "upright.png", "upright.tif")
                self.assertEqual(name in result.stderr and "as stored" in result.stderr, is_turned)


class Boards(CommandTest):
    """Photographs of a board. Which are used is the question, not how well: the board is small and
    flat, and one image is held out, so that a calibration takes a second and not ten."""
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.pattern = write(cls.path("pattern.yaml"), PATTERN)
        result = run("simulate", "--render", "--images", 6, "--lens", "wide", "--size",
                     "320x240", "--pattern", cls.pattern, "--samples-per-pixel", 2, "--seed",
                     2, "-o", cls.path("sim"))  # the board is found in each
        assert result.returncode == 0, result.stderr
        cls.photos = {name: read(os.path.join(cls.path("sim"), name))
                      for name in sorted(os.listdir(cls.path("sim"))) if name.endswith(".png")}

    def folder_with(self, **files):
        folder = self.path("folder-" + self.id())
        for name, contents in (*self.photos.items(), *files.items()):
            write(os.path.join(folder, name.replace("_", ".")), contents)
        return folder

    def calibrate(self, *images, to=None, held_out="sim0004.png"):
        self.out = to or self.path("out-" + self.id())
        return run("calibrate", *images, "--pattern", self.pattern, "--model", "opencv",
                   "--skip-comparison", "--no-refine-features", "--fix-target-geometry", "--hold-out", held_out,
                   "-o", self.out)

    def images_of_result(self):
        return json.loads(read(os.path.join(self.out, "result.json")))["images"]

    def test_every_image_is_used_or_named_with_a_reason(self):
        blank = png([200] * (320 * 240), size=(320, 240))
        others = {"z1_png": png([0] * 100, size=(10, 10)), "z2_png": b"no image", "z3_png": blank,
                  "z4_heic": b"", "z5_png": blank}
        folder = self.folder_with(**others)
        self.assert_done(self.calibrate(folder, held_out="sim0002.png,z5.png"))
        images = self.images_of_result()
        reasons = {image["image"]: image["reason"] for image in images["rejected"]}
        used = {line.split(",")[0] for line in read(os.path.join(
            self.out, "features.csv")).decode().splitlines() if line.startswith("sim")}
        self.assertEqual(images["used"], len(used))
        self.assertEqual(sorted([*used, "sim0002.png", *reasons]), sorted(
            [*self.photos, *(name.replace("_", ".") for name in others)]))
        for name, words in (("z1.png", "10 x 10"), ("z2.png", "not an image"),
                            ("z3.png", "features"), ("z4.heic", "PNG"), ("z5.png", "features")):
            self.assertIn(words, reasons[name])

    def test_copies_are_named_and_used_once(self):
        folder = self.folder_with(**{f"z{name}": photo for name, photo in self.photos.items()
                                     if name < "sim0003"})
        done = self.calibrate(folder)
        self.assert_done(done)
        images = self.images_of_result()
        self.assertEqual(len(images["rejected"]), 3)
        self.assertEqual(images["used"], 5)  # and one is held out
        reasons = {image["image"]: image["reason"] for image in images["rejected"]}
        for name in ("sim0000.png", "sim0002.png"):
            self.assertIn(f"duplicate of {name}", reasons[f"z{name}"])
        self.assertIn("zsim0000.png", done.stderr)
        with_copies = read(os.path.join(self.out, "camera.yaml"))
        self.assert_done(self.calibrate(self.path("sim"), to=self.path("once")))
        self.assertEqual(with_copies, read(self.path("once/camera.yaml")))

    def test_pictures_of_an_earlier_result_are_no_views(self):
        folder = self.folder_with()
        results = []
        for _ in range(2):
            self.assert_done(self.calibrate(folder, to=folder))
            results.append({name: read(os.path.join(folder, name))
                            for name in ("camera.yaml", "features.csv", "poses.csv")})
            for name, contents in self.photos.items():
                self.assertEqual(read(os.path.join(folder, name)), contents)
        self.assertIn("example_before.png", os.listdir(folder))
        self.assertEqual(results[0], results[1])
        left_out = {image["image"] for image in self.images_of_result()["rejected"]}
        self.assertLessEqual({"example_before.png", "example_after.png"}, left_out)
        self.assertLessEqual(left_out - set(self.photos),
                             {"example_before.png", "example_after.png", "uncertainty.png"})

    def test_detect_and_calibrate_take_turned_images_as_stored(self):
        turned = {}
        for name, photo in self.photos.items():
            turned[name] = photo[:33] + chunk(b"eXIf", exif(6)) + photo[33:]
        folder = self.path("turned")
        for name, photo in turned.items():
            write(os.path.join(folder, name), photo)
        features = []
        for images in (self.path("sim"), folder):
            path = self.path("turned.csv")
            result = self.succeed("detect", images, "--pattern", self.pattern, "-o", path, "--no-cache")
            features.append(read(path))
        self.assertEqual(features[0], features[1])
        calibrated = self.calibrate(folder)
        self.assert_done(calibrated)
        for text in (result.stderr, calibrated.stderr):
            self.assertIn("as stored", text)
            for name in turned:
                self.assertIn(name, text)

    # ---- What is no image of a reasonable size ---------------------------------

    def test_pipes_and_devices_among_images_are_skipped(self):
        folder = self.folder_with()
        os.mkfifo(os.path.join(folder, "a.png"))
        os.symlink("/dev/zero", os.path.join(folder, "b.png"))
        result = self.succeed("detect", folder, "--pattern", self.pattern, "-o", self.path("f.csv"))
        for name in ("a.png", "b.png"):
            self.assertIn(f"{name}: skipped: not a regular file", result.stderr)
        result = run("detect", folder, "--pattern", os.path.join(folder, "b.png"), "-o",
                     self.path("f.csv"))
        self.assert_refused(result, 2, "b.png", "device")

    def test_sizes_are_checked_before_pixels_are_read(self):
        empty = zlib.compress(b"")
        def huge(width, height):
            return (b"\x89PNG\r\n\x1a\n" +
                    chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
                    chunk(b"IDAT", empty) + chunk(b"IEND", b""))
        command = ("detect", write(self.path("huge.png"), huge(30000, 30000)), "--pattern",
                   self.pattern, "-o", self.path("f.csv"))
        self.assert_refused(run(*command), 2, "30000 x 30000", "--allow-huge-images")
        self.assert_refused(run(*command, "--allow-huge-images"), 2, "corrupt")
        write(self.path("huge.png"), huge(1000000, 1))
        for option in ((), ("--allow-huge-images",)):
            self.assert_refused(run(*command, *option), 2, "1000000 x 1")

    def test_sizes_of_options_are_checked(self):
        camera = self.path("sim/true_camera.yaml")
        image = self.path("sim/sim0000.png")
        texts = (("4294967936x480", "--allow-huge-images"), ("640x4294967936", "--allow-huge-images"), ("16385x8", "--allow-huge-images"),
                 ("1000000x1000000", "--allow-huge-images"), ("99999999999999999999x9", "WIDTHxHEIGHT"),
                 ("640", "WIDTHxHEIGHT"), ("640x", "WIDTHxHEIGHT"), ("-640x480", "WIDTHxHEIGHT"),
                 ("640x480 ", "WIDTHxHEIGHT"), ("0x480", "WIDTHxHEIGHT"))
        # Sizes are read by one function, behind a reader of --remap's own: the others show that
        # they ask it, with a size of each kind.
        few = texts[::5]
        for arguments, given in ((("simulate", "--size"), texts),
                                 (("pack", camera, "--remap"), texts),
                                 (("calibrate", "--features", self.path("sim/features.csv"),
                                   "--pattern", self.pattern, "--image-size"), few),
                                 (("simulate", "--render", "--size"), few),
                                 (("undistort", camera, image, "--size"), few),
                                 (("experiment", "pattern-segments", "--size"), few)):
            for text, word in given:
                with self.subTest(arguments=arguments, text=text):
                    result = run(*arguments, text, "-o", self.path("never"))
                    self.assert_refused(result, 1, word)
                    self.assertFalse(os.path.exists(self.path("never/features.csv")))
        self.succeed("simulate", "--images", 1, "--lens", "pinhole", "--size", "17000x12000",
                     "--features-per-image", 20, "--allow-huge-images", "-o", self.path("huge"))
        result = run("simulate", "--camera", self.path("huge/true_camera.yaml"), "--render",
                     "--images", 1, "-o", self.path("never"))
        self.assert_refused(result, 2, "17000 x 12000", "--allow-huge-images")


if __name__ == "__main__":
    main(__name__)
