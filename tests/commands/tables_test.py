#!/usr/bin/env python3
"""Exports of bytes and pixels: compilers, objcopy and numpy read what raygrid wrote."""
import array
import json
import math
import os
import re
import shutil
import subprocess
import unittest
import zlib

from command_test import CommandTest, HERE, NO_OPENCV, main, python_with, read, run, write

HOST_COMPILERS = [words for words in (("gcc", "c", "c99"), ("gcc", "c++", "c++98"),
                                      ("clang-14", "c", "c17")) if shutil.which(words[0])]
BOARD_COMPILERS = [name for name in ("arm-none-eabi-gcc",) if shutil.which(name)]
WARNINGS = ("-Wall", "-Wextra", "-pedantic", "-Werror")

MAPS_PEER = os.path.join(HERE, "maps_peer.py")
STMAP_PEER = os.path.join(HERE, "stmap_peer.py")
ISAAC_PEER = os.path.join(HERE, "isaac_peer.py")
RAYS_PEER = os.path.join(HERE, "rays_peer.py")
OPENCV = python_with("cv2")

PROGRAM = """#include "front.h"
#include "front.h"
#include <stdio.h>
int main(void) {
  if ((uintptr_t)front_raygrid % 4 != 0) return 1;
  if (sizeof(front_raygrid) != FRONT_RAYGRID_SIZE) return 2;
  printf("%lu %d %d ", (unsigned long)FRONT_RAYGRID_CRC32, FRONT_RAYGRID_WIDTH,
         FRONT_RAYGRID_HEIGHT);
  fwrite(front_raygrid, 1, FRONT_RAYGRID_SIZE, stdout);
  return 0;
}
"""

BOARD_PROGRAM = """#include "front.h"
const void* find_blob(void);
const void* find_blob(void) { return front_raygrid; }
"""


class TableTest(CommandTest):
    def export(self, camera, *arguments, out):
        result = self.succeed("export", camera, *arguments, "--json", "-o", self.path(out))
        return json.loads(result.stdout)

    def done(self, *command, check=True):
        result = subprocess.run(command, capture_output=True, check=False, cwd=self.folder)
        if check:
            self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout


class Blobs(TableTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        camera = cls.simulated_camera("wide")
        text = re.sub("^(name|serial): .*\n", "", read(camera).decode(), flags=re.MULTILINE)
        cls.camera = write(cls.path("named.yaml"),
                           'name: "left */ /* ??/ \\u00e9"\nserial: "*/ 1"\n' + text)
        cls.blob = cls.path("front.raygrid")
        cls.succeed("pack", cls.camera, "--remap", "160x120", "-o", cls.blob)
        cls.bytes = read(cls.blob)

    def check_program(self, folder):
        """In both languages and with each compiler the array is the blob, and is aligned."""
        sources = [source for source in ("front.c",) if os.path.exists(f"{folder}/{source}")]
        write(f"{folder}/main.c", PROGRAM)
        for compiler, language, standard in HOST_COMPILERS:
            with self.subTest(compiler=compiler, standard=standard):
                objects = []
                for source in sources:
                    objects.append(f"{folder}/front.o")
                    self.done(compiler, "-std=c99", *WARNINGS, "-c", f"{folder}/{source}", "-o",
                              objects[-1])
                self.done(compiler, *WARNINGS, "-std=" + standard, "-x", language,
                          f"{folder}/main.c", "-x", "none", *objects, "-o", f"{folder}/main")
                head, _, rest = self.done(f"{folder}/main").partition(b" 160 120 ")
                self.assertEqual(int(head), zlib.crc32(self.bytes))
                self.assertTrue(rest == self.bytes)
        write(f"{folder}/board.c", BOARD_PROGRAM)
        for compiler in BOARD_COMPILERS:
            for source in ("board.c", *sources):
                self.done(compiler, "-std=c99", *WARNINGS, "-ffreestanding", "-c",
                          f"{folder}/{source}", "-o", f"{folder}/board.o")

    def test_compilers_find_the_blob_in_the_array(self):
        told = self.export(self.blob, "--to", "c", out="one/front.h")
        self.assertEqual((told["files"], told["bytes"], told["crc32"]),
                         ([self.path("one/front.h")], len(self.bytes), zlib.crc32(self.bytes)))
        told = self.export(self.blob, "--to", "c", out="two/front.c")
        self.assertEqual(told["files"], [self.path("two/front.c"), self.path("two/front.h")])
        for folder in ("one", "two"):
            self.check_program(self.path(folder))

    def test_the_name_is_one_that_c_knows(self):
        for file, name in (("int.h", "int_raygrid"), ("4 left-1.h", "camera_4_left_1_raygrid"),
                           ("_\u00e9.h", "camera_raygrid"), ("a--b_.h", "a_b_raygrid")):
            self.export(self.blob, "--to", "c", out=file)
            self.assertTrue(f"const uint8_t {name}[" in read(self.path(file)).decode())
            self.done("gcc", "-std=c99", *WARNINGS, "-fsyntax-only", "-x", "c", self.path(file))

    def test_objcopy_finds_the_blob_in_intel_hex(self):
        """Also where it begins within a line, and where it crosses a border of 64 KiB."""
        for address in (0, 0x0800FFF4, 2**32 - len(self.bytes)):
            with self.subTest(hex(address)):
                self.export(self.blob, "--to", "hex", "--address", hex(address), out="front.hex")
                self.done("objcopy", "-I", "ihex", "-O", "binary", "front.hex", "back.bin")
                self.assertTrue(read(self.path("back.bin")) == self.bytes)
                self.done("objcopy", "-I", "ihex", "-O", "srec", "front.hex", "back.srec")
                first = re.search(rb"^S(\d)..([0-9A-F]*)", read(self.path("back.srec")).replace(
                    b"S0", b"x"), re.MULTILINE)
                digits = {b"1": 4, b"2": 6, b"3": 8}[first[1]]
                self.assertEqual(int(first[2][:digits], 16), address)

    def test_objcopy_finds_a_wrong_byte(self):
        self.export(self.blob, "--to", "hex", "--address", 0, out="front.hex")
        text = read(self.path("front.hex")).decode().splitlines()
        text[2] = text[2][:9] + f"{int(text[2][9:11], 16) ^ 1:02X}" + text[2][11:]
        write(self.path("mutant.hex"), "\n".join(text) + "\n")
        result = subprocess.run(["objcopy", "-I", "ihex", "-O", "binary", self.path("mutant.hex"),
                                 self.path("mutant.bin")], capture_output=True, check=False)
        self.assertNotEqual(result.returncode, 0)

    def test_what_cannot_be(self):
        def refused(camera, code, *words, to, out="never/x.h", more=()):
            with self.subTest((to, more)):
                self.assert_refused(run("export", camera, "--to", to, *more, "-o",
                                        self.path(out)), code, *words)
        refused(self.camera, 2, "named.yaml", "not a blob", "raygrid pack", to="c")
        refused(self.blob, 1, "x.txt: c writes .h or .c", to="c", out="never/x.txt")
        refused(self.blob, 1, "--address", "0x08080000", to="hex")
        for address, words in (("0x08080002", ("aligned to 4",)), ("0xfffffffc", ("32-bit",)),
                               ("0x100000000", ("number",)), ("12q", ("number",))):
            refused(self.blob, 1, "--address", *words, to="hex", more=("--address=" + address,))
        for option, value in (("--address", "4"), ("--hfov", "60"), ("--max-fit-error-px", "1")):
            refused(self.blob, 1, option, "not supported by --to c", to="c", more=(option, value))
        refused(self.blob, 1, "--rectified", "hex", to="hex",
                more=("--rectified", "--address", "4"))
        refused(self.camera, 1, "--address", "ros", to="ros", more=("--address", "4"))
        refused(self.blob, 1, "--to bin", "opencv", "c", "hex", to="bin")
        broken = write(self.path("broken.raygrid"), self.bytes[:-9] + b"x" + self.bytes[-8:])
        refused(broken, 8, "broken.raygrid", to="c")
        self.assert_nothing_in(self.path("never"))
        write(self.path("own.h"), self.bytes)
        self.assert_refused(run("export", self.path("own.h"), "--to", "c", "-o",
                                self.path("own.c")), 7, "overwrite the input")

    def test_all_are_listed(self):
        listed = {entry["name"]: entry for entry in
                  json.loads(run("export", "--list", "--json").stdout)}
        self.assertEqual((listed["c"]["source"], listed["hex"]["options"]), ("a blob", ["address"]))
        self.assertEqual(listed["maps"]["models"], ["float", "fixed"])
        self.assertEqual([name for name, entry in listed.items() if entry["source"] != "a lens" and
                          entry["can_import"]], ["stmap", "rays", "tum", "puzzlepaint-dataset"])
        text = run("export", "--list").stdout
        for entry in listed.values():
            self.assertIn(entry["name"] + ": " + entry["description"], text)


class Maps(TableTest):
    WIDTH, HEIGHT = 320, 240
    # A grey of 16 bits changes by no more a pixel in this image.
    GREY_PER_PX = 1800

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.camera = cls.simulated_camera("wide", f"{cls.WIDTH}x{cls.HEIGHT}")
        pixels = array.array("H", [int(32768 + 12000 * math.sin(x / 9) + 12000 * math.sin(y / 11))
                                   for y in range(cls.HEIGHT) for x in range(cls.WIDTH)])
        pixels.byteswap()
        cls.image = write(cls.path("image.pgm"), b"P5 %d %d 65535\n" % (cls.WIDTH, cls.HEIGHT) +
                          pixels.tobytes())

    def seen_by_opencv(self, *files, view=()):
        self.succeed("undistort", self.camera, self.image, "-o", self.path("flat"), *view)
        result = self.succeed(MAPS_PEER, self.image, self.path("flat/image.png"), *map(self.path, files),
                              program=OPENCV)
        return json.loads(result.stdout)

    def check_places(self, maps, camera, distance, least):
        """Places in maps are where `project` sees the view's pixels, but for rounding to 24 bits."""
        (f, _, cx), (_, _, cy), _ = maps["K"]
        places = [(x, y) for y in range(0, self.HEIGHT, 3) for x in range(0, self.WIDTH, 2)]
        points = write(self.path("p.csv"), "x,y,z\n" + "".join(
            f"{(x - cx) / f * distance!r},{(y - cy) / f * distance!r},{distance}\n"
            for x, y in places))
        result = self.succeed("project", camera, "--points", points)
        rows = [line.split(",") for line in result.stdout.split()]
        self.assertEqual(rows[0], ["x", "y", "z", "u", "v", "valid"])
        count = 0
        for (_, _, _, u, v, valid), *place in zip(rows[1:], maps["x"], maps["y"]):
            self.assertEqual(valid == "1", place != [-1, -1])
            count += valid == "1"
            for ours, theirs in zip((u, v), place) if valid == "1" else ():
                rounding = 2.0 ** (math.floor(math.log2(abs(theirs) + 1e-9)) - 24)
                self.assertLess(abs(float(ours) - theirs), 1e-6 + rounding)
        self.assertGreater(count, least)

    @unittest.skipUnless(OPENCV, NO_OPENCV)
    def test_opencv_sees_what_raygrid_does(self):
        """With a table of 0.05 px and OpenCV's steps of 1/32 px; half a pixel is seen. More than 10,000
        places are those of `project`, but for their rounding to 24 bits."""
        view = ("--hfov", 100, "--max-error-px", 0.05)
        for model, out in (("float", "m.npz"), ("fixed", "f.npz"), ("float", "m.yaml"),
                           ("fixed", "f.xml")):
            told = self.export(self.camera, "--to", "maps", "--model", model, "--hfov", 100,
                               out=out)
        self.assertAlmostEqual(told["view"]["hfov_deg"], 100, 6)
        plain, fixed, *others = self.seen_by_opencv("m.npz", "f.npz", "m.yaml", "f.xml", view=view)
        shape = [self.HEIGHT, self.WIDTH]
        self.assertEqual((plain["types"], plain["shapes"]), (["float32"] * 2, [shape] * 2))
        self.assertEqual((fixed["types"], fixed["shapes"]),
                         (["int16", "uint16"], [shape + [2], shape]))
        self.assertEqual(plain["source_size"], [self.WIDTH, self.HEIGHT])
        self.assertEqual(plain["K"], told["view"]["K"])
        self.assertEqual(others, [plain, fixed])
        for maps in (plain, fixed):
            off, moved = maps["difference"], maps["moved"]
            self.assertLess(off["max"] / self.GREY_PER_PX, 0.05 + 2 ** 0.5 / 64)
            self.assertLess(off["rms"] / self.GREY_PER_PX, 0.02)
            self.assertLess(off["seen_by_one"], 0.001)
            self.assertGreater(moved["rms"] / self.GREY_PER_PX, 0.2)
        self.check_places(plain, self.camera, 1, least=10000)

    def check_stmap(self, *view):
        self.export(self.camera, "--to", "maps", *view, out="m.npz")
        self.export(self.camera, "--to", "stmap", *view, out="s.exr")
        maps, stmap = self.seen_by_opencv("m.npz", "s.exr", view=view)
        # Parts of the image have 24 bits, and t is 1 less another number.
        for axis, length in (("x", self.WIDTH), ("y", self.HEIGHT)):
            self.assertLess(max(abs(a - b) for a, b in zip(maps[axis], stmap[axis])),
                            length * 2 ** -23)
        self.assertEqual(maps["unseen"], stmap["unseen"])
        self.assertGreater(maps["unseen"], 0.01)
        for made in (maps, stmap):
            self.assertLess(made["difference"]["rms"] / self.GREY_PER_PX, 0.02)
            self.assertLess(made["difference"]["seen_by_one"], 0.001)
            self.assertGreater(made["moved"]["rms"] / self.GREY_PER_PX, 0.2)

    @unittest.skipUnless(OPENCV, NO_OPENCV)
    def test_stmaps_are_the_maps_in_both_directions(self):
        self.check_stmap("--hfov", 100)
        self.check_stmap("--hfov", 100, "--inverse")

    @unittest.skipUnless(shutil.which("oiiotool"), "no oiiotool; 'tools/install_packages tests' installs it")
    def test_oiiotool_sees_what_raygrid_does(self):
        view = ("--hfov", 100, "--rotate", "5,10,3")
        self.export(self.camera, "--to", "stmap", *view, out="o.exr")
        self.succeed("undistort", self.camera, self.image, "-o", self.path("oi"), *view)
        off = {}
        for flip in (0, 1):
            told = self.done("oiiotool", self.image, "o.exr",
                             f"--st_warp:filter=triangle:flip_t={flip}", "oi/image.png", "--diff",
                             check=False)
            mean = float(re.search(rb"Mean error = ([\d.e+-]+)", told)[1])
            off[flip] = mean * 65535 / self.GREY_PER_PX
        self.assertLess(off[1], 0.02)
        self.assertGreater(off[0], 0.2)

    @unittest.skipUnless(OPENCV, NO_OPENCV)
    def test_nothing_is_seen_beyond_the_image_circle(self):
        x, y, radius = 150, 125, 90
        camera = write(self.path("circle.yaml"), read(self.camera).decode() +
                       f"image_circle: [{x}, {y}, {radius}]\n")
        self.export(camera, "--to", "maps", "--hfov", 100, out="c.npz")
        self.export(camera, "--to", "maps", "--hfov", 100, "--inverse", out="cr.npz")
        self.export(self.camera, "--to", "maps", "--hfov", 100, "--inverse", out="m.npz")
        there, back, everywhere = self.seen_by_opencv("c.npz", "cr.npz", "m.npz",
                                                      view=("--hfov", 100))
        distances = [math.dist((x, y), place) for place in zip(there["x"], there["y"])
                     if place != (-1, -1)]
        self.assertLess(max(distances), radius + 1e-4)
        self.assertGreater(max(distances), radius - 1)
        at = ((a, b) for b in range(0, self.HEIGHT, 3) for a in range(0, self.WIDTH, 2))
        for place, one, other in zip(at, zip(back["x"], back["y"]),
                                     zip(everywhere["x"], everywhere["y"])):
            self.assertEqual(one, other if math.dist(place, (x, y)) <= radius else (-1, -1))

    def nearest_indices(self, path):
        """The samples of a PGM of the view."""
        pixels = read(self.path(path))
        head = b"P5\n%d %d\n65535\n" % (self.WIDTH, self.HEIGHT)
        self.assertTrue(pixels.startswith(head))
        samples = array.array("H", pixels[len(head):])
        samples.byteswap()
        return samples

    def check_nearest(self, maps, indices):
        """Samples of indices are the nearest to places in maps; 65535 where there are none."""
        at = [y * self.WIDTH + x for y in range(0, self.HEIGHT, 3) for x in range(0, self.WIDTH, 2)]
        for axis in ("x", "y"):
            for place, index in zip(maps[axis], (indices[axis][k] for k in at)):
                if place == -1:
                    self.assertEqual(index, 65535)
                else:
                    self.assertLess(abs(index - place), 0.5001)

    @unittest.skipUnless(OPENCV, NO_OPENCV)
    def test_ffmpegs_maps_are_the_nearest_pixels(self):
        self.export(self.camera, "--to", "maps", "--hfov", 100, out="m.npz")
        told = self.export(self.camera, "--to", "ffmpeg", "--hfov", 100, out="ff/m.pgm")
        self.assertEqual(told["files"], [self.path("ff/m_x.pgm"), self.path("ff/m_y.pgm")])
        maps, = self.seen_by_opencv("m.npz", view=("--hfov", 100))
        indices = {axis: self.nearest_indices(f"ff/m_{axis}.pgm") for axis in "xy"}
        self.check_nearest(maps, indices)
        indices["x"] = array.array("H", [65535] + list(indices["x"])[:-1])
        with self.assertRaises(AssertionError):
            self.check_nearest(maps, indices)

    @unittest.skipUnless(shutil.which("ffmpeg"), "no ffmpeg; 'tools/install_packages tests' installs it")
    def test_ffmpeg_takes_the_pixels_that_the_maps_say(self):
        self.export(self.camera, "--to", "ffmpeg", "--hfov", 100, out="m.pgm")
        grey = bytes((x * 7 + y * 13) % 251 + 2 for y in range(self.HEIGHT)
                     for x in range(self.WIDTH))
        write(self.path("grey.pgm"), b"P5\n%d %d\n255\n" % (self.WIDTH, self.HEIGHT) + grey)
        self.done("ffmpeg", "-v", "error", "-i", "grey.pgm", "-i", "m_x.pgm", "-i", "m_y.pgm",
                  "-lavfi", "remap=format=gray", "-frames:v", "1", "-f", "rawvideo", "-pix_fmt",
                  "gray", "out.raw")
        x, y = (self.nearest_indices(f"m_{axis}.pgm") for axis in "xy")
        pairs = [(grey[b * self.WIDTH + a], out) for a, b, out in
                 zip(x, y, read(self.path("out.raw"))) if a != 65535]
        self.assertGreater(len(pairs), 70000)
        self.assertTrue(all(a == b for a, b in pairs))

    @unittest.skipUnless(OPENCV, NO_OPENCV)
    def test_what_is_not_seen_is_border(self):
        view = ("--alpha", 1, "--size", "200x150")
        self.export(self.camera, "--to", "maps", *view, out="m.npz")
        maps, = self.seen_by_opencv("m.npz", view=(*view, "--max-error-px", 0.3))
        self.assertGreater(maps["unseen"], 0.05)
        self.assertLess(maps["difference"]["seen_by_one"], 0.005)

    @unittest.skipUnless(OPENCV, NO_OPENCV)
    def test_cameras_of_lines_show_far_scenes(self):
        lines = self.simulated_camera("noncentral", f"{self.WIDTH}x{self.HEIGHT}")
        self.export(lines, "--to", "maps", "--hfov", 80, out="m.npz")
        maps, = self.seen_by_opencv("m.npz", view=("--hfov", 80))
        self.check_places(maps, lines, 1e6, least=10000)
        with self.assertRaises(AssertionError):
            self.check_places(maps, lines, 1, least=10000)

    def test_the_view_is_that_of_a_blob_or_as_rectified_has_it(self):
        blob = self.path("v.raygrid")
        self.succeed("pack", self.camera, "--remap", "320x240,hfov=50,direction=distort",
                     "--remap", "64x48,hfov=60", "--max-error-px", 0.3, "-o", blob)
        told = self.export(blob, "--to", "maps", out="m.npz")
        self.assertEqual(told["view"]["size"], [64, 48])
        self.assertAlmostEqual(told["view"]["hfov_deg"], 60, 3)
        told = self.export(self.camera, "--to", "maps", "--projection", "cylindrical", "--hfov",
                           120, out="m.npz")
        self.assertEqual(told["view"]["projection"], "cylindrical")

    def test_same_bytes_at_any_time_and_with_any_number_of_threads(self):
        for threads in (1, 2):
            self.export(self.camera, "--to", "maps", "--threads", threads, "--size", "64x48",
                        out=f"t{threads}.npz")
        self.assertTrue(read(self.path("t1.npz")) == read(self.path("t2.npz")))
        # Two bytes of time and two of date: 1 January 1980.
        self.assertEqual(read(self.path("t1.npz"))[10:14], b"\0\0\x21\0")

    def test_what_cannot_be(self):
        for more, words in ((("--model", "x", "-o", "never/m.npz"), ("--model x", "float, fixed")),
                            (("-o", "never/m.txt"), ("m.txt", ".npz")),
                            (("--stride", "2", "-o", "never/m.npz"), ("--stride", "maps")),
                            (("--poses", "p.csv", "-o", "never/m.npz"), ("--poses", "maps")),
                            (("--hfov", "x", "-o", "never/m.npz"), ("--hfov",))):
            with self.subTest(more):
                more = [*more[:-1], self.path(more[-1])]
                self.assert_refused(run("export", self.camera, "--to", "maps", *more), 1, *words)
        self.assert_nothing_in(self.path("never"))
        for to, more, words in (("stmap", (), (".exr",)), ("stmap", ("--model", "x"), ("--model",)),
                                ("ros", ("--inverse",), ("--inverse", "ros"))):
            self.assert_refused(run("export", self.camera, "--to", to, *more, "-o",
                                    self.path("never/m.npz")), 1, *words)
        self.assert_refused(run("export", self.path("board.yaml"), "--to", "maps", "-o",
                                self.path("never/m.npz")), 2, "board.yaml")


class ImportTest(TableTest):
    def imported(self, rays, *more):
        result = self.succeed("import", self.path(rays), "-o", self.path("camera.yaml"), "--json", *more)
        told, = json.loads(result.stdout)["cameras"]
        return told, result.stderr

    def distance(self, camera):
        """Of the imported camera from another one, which may not turn or move: largest and RMS."""
        pixels = [(x, y) for x in range(3, 157, 7) for y in range(2, 118, 5)]
        text = "x,y\n" + "".join(f"{x},{y}\n" for x, y in pixels)
        result = self.succeed("unproject", camera, "--pixels", write(self.path("p.csv"), text), "--json")
        rows = [row for row in json.loads(result.stdout) if row["dx"] is not None]
        points = "x,y,z\n" + "".join(
            ",".join(repr(row.get("o" + axis, 0) + row["d" + axis]) for axis in "xyz") + "\n"
            for row in rows)
        result = self.succeed("project", self.path("camera.yaml"), "--points",
                              write(self.path("q.csv"), points), "--json")
        seen = json.loads(result.stdout)
        self.assertTrue(all(row["valid"] for row in seen))
        errors = [math.dist((a["x"], a["y"]), (b["u"], b["v"])) for a, b in zip(rows, seen)]
        return max(errors), math.sqrt(sum(error ** 2 for error in errors) / len(errors))


@unittest.skipUnless(OPENCV, NO_OPENCV)
class Rays(ImportTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.camera = cls.simulated_camera("wide")

    def numpy(self, rays):
        """What numpy says of rays, which it saves again in many ways."""
        result = self.succeed(RAYS_PEER, self.path(rays), self.folder, program=OPENCV)
        return json.loads(result.stdout)

    def test_numpy_reads_the_rays(self):
        self.export(self.camera, "--to", "rays", "--stride", 7, out="r.npz")
        told = self.numpy("r.npz")
        self.assertEqual((told["directions"], told["x"], told["y"], told["image_size"]),
                         (["float64", [18, 24, 3]], ["float64", [24]], ["float64", [18]],
                          ["int32", [2]]))
        pixels = write(self.path("p.csv"), "x,y\n" + "".join(
            f"{min(7 * k, 159)},0\n" for k in range(24)))
        result = run("unproject", self.camera, "--pixels", pixels, "--json")
        for row, theirs in zip(json.loads(result.stdout), told["directions_of_first_row"]):
            self.assertLess(math.dist([row["dx"], row["dy"], row["dz"]], theirs), 1e-8)
        again = self.path("same.npz")
        for out in ("r.npz", "same.npz"):
            self.export(self.camera, "--to", "rays", "--threads", 1 + (out == "r.npz"), out=out)
        self.assertTrue(read(self.path("r.npz")) == read(again))

    def test_import_after_export_is_nearly_the_camera(self):
        """With the error that is told; half a pixel is found."""
        self.export(self.camera, "--to", "rays", out="r.npz")
        told, _ = self.imported("r.npz")
        self.assertEqual((told["model"], told["image_size"]), ("central-generic", [160, 120]))
        self.assertLess(told["fit"]["rms_px"], 0.002)
        largest, rms = self.distance(self.camera)
        self.assertLess(largest, 1.2 * told["fit"]["max_px"])
        self.assertLess(rms, 1.5 * told["fit"]["rms_px"])
        self.numpy("r.npz")
        self.imported("moved.npz")
        self.assertAlmostEqual(self.distance(self.camera)[1], 0.5, 2)

    def test_pixels_beyond_the_image_circle_have_no_ray(self):
        camera = write(self.path("circle.yaml"), read(self.camera).decode() +
                       "image_circle: [80, 60, 50]\n")
        self.export(camera, "--to", "rays", out="r.npz")
        result = self.succeed("import", self.path("r.npz"), "-o", self.path("camera.yaml"))
        self.assertIn(f"{100 - 100 * math.pi * 50 ** 2 / (160 * 120):.1f} %", result.stderr)

    def test_pixels_that_are_left_out_say_what_lies_between(self):
        self.export(self.camera, "--to", "rays", "--stride", 16, out="r.npz")
        told, _ = self.imported("r.npz")
        rms = self.distance(self.camera)[1]
        self.assertLess(told["fit"]["rms_px"], rms)
        self.assertLess(rms, told["fit"]["held_out_rms_px"])

    def test_lines_that_do_not_meet_stay_lines(self):
        lines = self.simulated_camera("noncentral")
        self.export(lines, "--to", "rays", out="r.npz")
        self.assertEqual(self.numpy("r.npz")["origins"], ["float64", [120, 160, 3]])
        told, _ = self.imported("r.npz")
        self.assertEqual(told["model"], "noncentral-generic")
        self.assertLess(told["fit"]["rms_px"], 0.003)
        self.assertLess(self.distance(lines)[0], 1.2 * told["fit"]["max_px"])
        told, _ = self.imported("r.npz", "--model", "central-generic")
        self.assertEqual(told["model"], "central-generic")
        self.assertGreater(told["fit"]["rms_px"], 0.003)

    def test_tables_of_other_programs(self):
        """Directions alone, of any length, as float32 and compressed; a circle of pixels."""
        self.export(self.camera, "--to", "rays", out="r.npz")
        self.numpy("r.npz")
        told, _ = self.imported("plain.npz")
        self.assertLess(self.distance(self.camera)[0], 1.2 * told["fit"]["max_px"] + 1e-4)
        told, remarks = self.imported("circle.npz")
        self.assertLess(told["fit"]["rms_px"], 0.002)
        self.assertIn("22.7 %", remarks)

    def test_what_cannot_be(self):
        self.export(self.camera, "--to", "rays", "--stride", 4, out="r.npz")
        self.numpy("r.npz")
        for way, words in (("y_up", ("mirrored", "y down")), ("opengl", ("backwards", "z forward")),
                           ("fortran", ("Fortran", "ascontiguousarray")),
                           ("big_endian", (">f8", "float64")), ("none", ("directions (0)",)),
                           ("flat", ("rows x columns x 3",)), ("two", ("x 2 instead of",)),
                           ("other_name", ("'directions'",)), ("places", ("x: must be in ascending order",)),
                           ("few_places", ("y: has",)), ("small", ("image_size",)),
                           ("huge", ("16384",)), ("objects", ("directions",))):
            with self.subTest(way):
                self.assert_refused(run("import", self.path(way + ".npz"), "-o",
                                        self.path("never/c.yaml")), 2, way + ".npz: ", *words)
        good = read(self.path("r.npz"))
        for name, contents in (("cut", good[:-40]), ("short", good[:9]),
                               ("wrong", good[:900] + b"xyz" + good[903:])):
            with self.subTest(name):
                self.assert_refused(run("import", write(self.path("bad.npz"), contents), "-o",
                                        self.path("never/c.yaml")), 2, "bad.npz: ")
        rays, never = self.path("r.npz"), self.path("never/c.yaml")
        for arguments, code, words in (
                (("export", rays, "--to", "ros", "-o", never), 2, ("r.npz", "raygrid import")),
                (("import", rays, "-o", never, "--model", "opencv"), 1, ("central-generic", "fit")),
                (("import", rays, "-o", never, "--from", "ros"), 2, ("rays", "ros")),
                (("import", rays, "-o", never, "--image-size", "8x8"), 1, ("--image-size",)),
                (("import", rays, rays, "-o", never), 1, ("separately",)),
                (("export", self.camera, "--to", "rays", "-o", never), 1, (".npz",)),
                (("export", self.camera, "--to", "rays", "--stride", "0", "-o",
                  self.path("never/c.npz")), 1, ("--stride",)),
                (("export", self.camera, "--to", "ros", "--stride", "2", "-o", never), 1,
                 ("--stride", "ros"))):
            with self.subTest(arguments):
                self.assert_refused(run(*arguments), code, *words)
        self.assert_nothing_in(self.path("never"))
        self.assert_refused(run("import", rays, "-o", rays), 7, "overwrite the input")


@unittest.skipUnless(OPENCV, NO_OPENCV)
class Isaac(TableTest):
    SIZE = 160, 120

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.camera = cls.simulated_camera("wide")

    def looked_up(self, camera, table, ahead="ahead"):
        """What a renderer's lookups say at 10,000 places, half of them whole pixels."""
        width, height = self.SIZE
        places = [(k % width, k // width) for k in range(0, 15000, 3)]
        places += [(1 + k * 0.6180339887 % 1 * (width - 3), 1 + k * 0.7548776662 % 1 * (height - 3))
                   for k in range(5000)]
        pixels = write(self.path("p.csv"), "x,y\n" + "".join(f"{x!r},{y!r}\n" for x, y in places))
        result = self.succeed("unproject", camera, "--pixels", pixels)
        rows = [line for line in result.stdout.splitlines() if not line.endswith(",,,")]
        write(pixels, "\n".join(rows))
        result = self.succeed(ISAAC_PEER, self.path(table), pixels, ahead, program=OPENCV)
        return json.loads(result.stdout)

    def test_lookups_lead_where_the_camera_does(self):
        """Within the error that is told. Half a pixel is found, and each wrong axis."""
        for model, bound_px in (("ahead", 0.05), ("behind", 0.5)):
            with self.subTest(model):
                told = self.export(self.camera, "--to", "isaac", "--model", model, "--max-fit-error-px",
                                   bound_px, out="i.exr")
                self.assertEqual(told["files"], [self.path("i_enter.exr"), self.path("i_exit.exr")])
                seen = self.looked_up(self.camera, "i", model)
                side = told["exit_side"]
                self.assertEqual((seen["enter_size"], seen["exit_size"], seen["enter_types"]),
                                 ([*self.SIZE], [side, side], ["float32"] * 2))
                self.assertEqual((told["pixels"], told["pixels_lost"]), (160 * 120, 0))
                self.assertLess(told["exit_max_px"], bound_px)
                self.assertLess(seen["worst_rad"], 2e-7)
                self.assertGreater(seen["between_rad"], seen["worst_rad"])
                self.assertLess(seen["exit_px"], 1.1 * told["exit_max_px"])
                self.assertLess(seen["both_px"], 1.1 * (told["exit_max_px"] + told["enter_max_px"]))
                for mistake, px in seen["mistakes"].items():
                    self.assertGreater(px, 0.5, mistake)

    def test_the_errors_are_told(self):
        result = self.succeed("export", self.camera, "--to", "isaac", "-o", self.path("t.exr"))
        for words in ("t_enter.exr: 160 x 120 rays", "t_exit.exr", "directions, error 0.00",
                      "px RMS", "nominalWidth 160, nominalHeight 120, opticalCenter (80, 60)"):
            self.assertIn(words, result.stdout)

    def test_what_the_camera_does_not_see(self):
        """Rays look backward, places lie beyond every image; the error is that of lit pixels."""
        camera = write(self.path("circle.yaml"), read(self.camera).decode() +
                       "image_circle: [80, 60, 50]\n")
        told = self.export(camera, "--to", "isaac", "--max-fit-error-px", 0.05, out="c.exr")
        lit = sum(math.dist((x, y), (80, 60)) <= 50 for x in range(160) for y in range(120))
        self.assertEqual(told["pixels"], lit)
        self.export(self.camera, "--to", "isaac", "--max-fit-error-px", 0.05, out="i.exr")
        self.assertEqual(self.looked_up(self.camera, "c")["none"]["enter"], 160 * 120 - lit)
        none = self.looked_up(self.camera, "i")["none"]
        self.assertEqual(none["enter"], 0)
        self.assertGreater(none["exit"], none["exit_inside"])

    def test_a_lens_beyond_the_hemisphere(self):
        """Where an octahedron's faces meet 90 degrees off the axis, places bend: more is left."""
        camera = self.simulated_camera("fisheye190")
        told = self.export(camera, "--to", "isaac", "--max-fit-error-px", 0.5, out="f.exr")
        self.assertGreater(told["exit_max_px"], 0.05)
        seen = self.looked_up(camera, "f")
        self.assertLess(seen["exit_px"], 1.5 * told["exit_max_px"])

    def test_lines_begin_in_one_point(self):
        lines = self.simulated_camera("noncentral")
        told = self.export(lines, "--to", "isaac", "--max-fit-error-px", 0.1, out="n.exr")
        self.assertGreater(told["offset_m"], 1e-5)
        result = run("export", lines, "--to", "isaac", "--max-fit-error-px", 0.1, "-o",
                     self.path("n.exr"))
        self.assertIn("mm from the camera's rays", result.stdout)

    def test_same_bytes_with_any_number_of_threads(self):
        for threads in (1, 2):
            self.export(self.camera, "--to", "isaac", "--max-fit-error-px", 0.05, "--threads", threads,
                        out=f"t{threads}.exr")
        for suffix in ("enter", "exit"):
            self.assertTrue(read(self.path(f"t1_{suffix}.exr")) == read(self.path(f"t2_{suffix}.exr")))

    def test_what_cannot_be(self):
        for more, code, words in ((("--max-fit-error-px", 1e-9), 6, ("isaac: the error exceeds 1e-09 px",)),
                                  (("--model", "x"), 1, ("--model x", "ahead, behind")),
                                  (("--hfov", 60), 1, ("--hfov", "isaac"))):
            with self.subTest(more):
                self.assert_refused(run("export", self.camera, "--to", "isaac", *more, "-o",
                                        self.path("never/i.exr")), code, *words)
        self.assert_refused(run("export", self.camera, "--to", "isaac", "-o",
                                self.path("never/i.png")), 1, ".exr")
        self.assert_nothing_in(self.path("never"))


@unittest.skipUnless(OPENCV, NO_OPENCV)
class StMaps(ImportTest):
    SIZE = ("--image-size", "160x120")
    # Both views show all pixels of the camera.
    VIEW = ("--projection", "equidistant", "--hfov", 105, "--rotate", "2,0,1")
    WIDE = ("--alpha", 1, "--size", "150x130")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.camera = cls.simulated_camera("wide")
        for command in (("export", cls.camera, "--to", "stmap", *cls.VIEW, "-o", cls.path("s.exr")),
                        ("export", cls.camera, "--to", "stmap", "--inverse", *cls.WIDE, "-o",
                         cls.path("r.exr")),
                        ("export", cls.camera, "--to", "opencv", "--rectified", *cls.WIDE, "-o",
                         cls.path("view.yml"))):
            cls.succeed(*command)
        cls.succeed(STMAP_PEER, cls.path("s.exr"), program=OPENCV)

    def test_import_after_export_is_nearly_the_camera(self):
        """In both directions, and with the view's words or its file. Half a pixel is found."""
        like = ("--inverse", "--view", self.path("view.yml"))
        for stmap, words, bound_px in (("s", (*self.SIZE, *self.VIEW), 0.001), ("r", like, 0.002)):
            with self.subTest(stmap):
                told, remarks = self.imported(stmap + ".exr", *words)
                self.assertEqual((told["model"], told["file_model"], told["image_size"], remarks),
                                 ("central-generic", "stmap", [160, 120], ""))
                self.assertLess(told["fit"]["rms_px"], bound_px)
                largest, rms = self.distance(self.camera)
                self.assertLess(rms, bound_px)
                self.assertLess(largest, 1.2 * told["fit"]["max_px"])
        self.imported("s_moved.exr", *self.SIZE, *self.VIEW)
        self.assertGreater(self.distance(self.camera)[1], 0.2)

    def test_pixels_that_tell_nothing_are_left_out(self):
        """Those that are no numbers, and black ones if alpha is 0 everywhere."""
        told, remarks = self.imported("s_nan.exr", *self.SIZE, *self.VIEW)
        self.assertLess(told["fit"]["rms_px"], 0.002)
        self.assertRegex(remarks, r"4\d\.\d % of the pixels have no ray")
        told, remarks = self.imported("s_black.exr", *self.SIZE, *self.VIEW)
        self.assertLess(told["fit"]["rms_px"], 0.001)
        self.assertEqual(remarks, "")

    def test_what_cannot_be(self):
        stmap, never = self.path("s.exr"), self.path("never/c.yaml")
        for more, code, words in (
                (self.VIEW, 1, ("--image-size", "s.exr", "--inverse")),
                (self.SIZE, 1, ("s.exr", "--view view.camera.yaml", "--hfov"))):
            with self.subTest(more):
                self.assert_refused(run("import", stmap, "-o", never, *more), code, *words)
        self.assert_refused(run("import", self.path("view.yml"), "-o", never, "--inverse"), 1,
                            "--inverse", "STMap", "view.yml")
        self.assert_refused(run("export", stmap, "--to", "ros", "-o", never), 2, "s.exr", "import")
        good = read(stmap)
        corner = good.index(b"displayWindow") + len(b"displayWindow\0box2i\0....") + 8
        for contents, word in (
                (good[:-40], "truncated"),
                (read(self.path("s_flipped.exr")), "t of an STMap increases upwards"),
                (good[:corner] + b"\xfe\x3f\0\0" * 2 + good[corner + 8:], "too few for 16383")):
            with self.subTest(word):
                self.assert_refused(run("import", write(self.path("bad.exr"), contents), "-o", never,
                                        *self.SIZE, *self.VIEW), 2, "bad.exr: ", word)
        self.assert_nothing_in(self.path("never"))


class Trajectories(TableTest):
    HEADER = "image,board,qw,qx,qy,qz,tx,ty,tz\n"
    POSES = ((0.6, 0.48, -0.64, 0.0, 0.1, -0.2, 0.75), (0.5, 0.5, 0.5, -0.5, 0.0, 0.3, 1.5),
             (1.0, 0.0, 0.0, 0.0, -0.125, 0.0, 2.0))

    def poses(self, names, more=""):
        return write(self.path("poses.csv"), self.HEADER + "".join(
            f"{name},0," + ",".join(map(str, pose)) + "\n" for name, pose in
            zip(names, self.POSES)) + more)

    @staticmethod
    def turned(point, w, x, y, z):
        """By the matrix of a quaternion."""
        rows = ((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
                (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
                (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))
        return [sum(a * b for a, b in zip(row, point)) for row in rows]

    def check_rows(self, rows):
        """A point in the camera's frame lies on the board where poses.csv has it."""
        point = (0.3, -0.2, 1.1)
        for (_, *camera, x, y, z, w), (qw, qx, qy, qz, *board) in zip(rows, self.POSES):
            on_board = [a + b for a, b in zip(self.turned(point, w, x, y, z), camera)]
            back = [a + b for a, b in zip(self.turned(on_board, qw, qx, qy, qz), board)]
            self.assertLess(math.dist(back, point), 1e-8)

    def trajectory(self, names):
        self.export(self.poses(names), "--to", "tum", out="t.txt")
        lines = read(self.path("t.txt")).decode().splitlines()
        self.assertIn("camera in the board's frame", lines[0])
        return [[line.split()[0], *map(float, line.split()[1:])] for line in lines[1:]]

    def test_the_camera_stands_in_the_boards_frame(self):
        """The other frame is found."""
        rows = self.trajectory(("b.png", "a.png", "c1.png"))
        self.assertEqual([row[0] for row in rows], ["0", "1", "2"])
        self.check_rows(rows)
        with self.assertRaises(AssertionError):
            self.check_rows([(0, *pose[4:], *pose[1:4], pose[0]) for pose in self.POSES])

    def test_import_after_export_is_the_poses(self):
        stamps = ("0007", "1305031102.175304", "1403636579763555584")
        self.assertEqual([row[0] for row in self.trajectory([s + ".png" for s in stamps])],
                         list(stamps))
        self.succeed("import", self.path("t.txt"), "-o", self.path("back.csv"))
        for line, stamp, pose in zip(read(self.path("back.csv")).decode().splitlines()[1:], stamps,
                                     self.POSES):
            image, board, *numbers = line.split(",")
            self.assertEqual((image, board), (stamp, "0"))
            self.assertLess(math.dist(map(float, numbers), pose), 1e-8)

    def test_time_stamps_of_other_programs_become_names_of_digits(self):
        text = "1.305031102175304e+09 0 0 0 0 0 0 1\n2.0e+00 0 0 0 0 0 0 1\n"
        self.succeed("import", write(self.path("evo.txt"), text), "-o",
                     self.path("evo.csv"))
        self.assertEqual([line.split(",")[0] for line in
                          read(self.path("evo.csv")).decode().splitlines()],
                         ["image", "1305031102.175304", "2"])

    def test_what_cannot_be(self):
        never = self.path("never/t.txt")
        names = ("1.png", "2.png", "3.png")
        self.trajectory(names)
        row = "4.png,{},1,0,0,0,0,0,1\n"
        for more, words in ((row.format(7), ("boards 0 and 7",)),
                            (row.replace("4", "1.0").format(0), ("duplicate timestamp 1",))):
            self.assert_refused(run("export", self.poses(names, more), "--to", "tum", "-o", never), 2,
                                "poses.csv: ", *words)
        poses = self.poses(names)
        for arguments, code, words in (
                (("export", poses, "--to", "colmap"), 2, ("--poses", "--to tum")),
                (("export", poses, "--to", "tum", "--poses", poses), 1, ("--poses", "alone")),
                (("inspect", self.path("t.txt")), 2, ("t.txt", "raygrid import"))):
            with self.subTest(arguments):
                out = ("-o", never) if arguments[0] != "inspect" else ()
                self.assert_refused(run(*arguments, *out), code, *words)
        good = read(self.path("t.txt")).decode()
        for text, word in ((good + "4 0 0 0 0 0 0\n", "line 5: has 7 fields"),
                           (good + "4 0 0 0 0 0 0 2\n", "line 5: qx qy qz qw"),
                           (good + "1.0 0 0 0 0 0 0 1\n", "line 5: duplicate timestamp 1.0")):
            with self.subTest(word):
                self.assert_refused(run("import", write(self.path("bad.txt"), text), "-o",
                                        self.path("never/poses.csv")), 2, "bad.txt", word)
        self.assert_nothing_in(self.path("never"))


if __name__ == "__main__":
    main(__name__)
