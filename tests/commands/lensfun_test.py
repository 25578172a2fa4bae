#!/usr/bin/env python3
"""Lenses of Lensfun's database, against liblensfun, which computes in single precision."""
import ctypes
import ctypes.util
import math
import unittest

from command_test import CommandTest, main, read, run, write

LENSFUN = ctypes.util.find_library("lensfun")
SIZE = (640, 480)
SIDES_PX = (SIZE[0] - 1, SIZE[1] - 1)  # between the centres of the outer pixels
FULL_FRAME_MM = math.hypot(36, 24)

LENS = """<!DOCTYPE lensdatabase SYSTEM "lensfun-database.dtd">
<lensdatabase version="1"><mount><name>Generic</name></mount>
<lens><maker>a</maker><model>testlens</model><mount>Generic</mount>{type}
<cropfactor>1.5</cropfactor><aspect-ratio>4:3</aspect-ratio><center x="0.05" y="-0.03"/>
<calibration><distortion model="{model}" focal="20" {numbers}/>{real}</calibration></lens>
</lensdatabase>
"""
# A rectilinear target, as LF_RECTILINEAR, for LF_MODIFY_DISTORTION and LF_MODIFY_GEOMETRY.
RECTILINEAR, DISTORTION_AND_GEOMETRY = 1, 8 | 16


def load_library():
    library = ctypes.CDLL(LENSFUN)
    pointer, real, integer = ctypes.c_void_p, ctypes.c_float, ctypes.c_int
    for name, result, arguments in (
            ("lf_db_new", pointer, []),
            ("lf_db_load_file", integer, [pointer, ctypes.c_char_p]),
            ("lf_db_find_lenses_hd", ctypes.POINTER(pointer),
             [pointer, pointer, ctypes.c_char_p, ctypes.c_char_p, integer]),
            ("lf_modifier_new", pointer, [pointer, real, integer, integer]),
            ("lf_modifier_initialize", integer,
             [pointer, pointer, integer] + [real] * 4 + [integer] * 3),
            ("lf_modifier_apply_geometry_distortion", integer,
             [pointer, real, real, integer, integer, ctypes.POINTER(real)])):
        getattr(library, name).restype = result
        getattr(library, name).argtypes = arguments
    return library


def lensfun_pixels(path, model, crop, focal, pixels):
    """Where Lensfun looks pixels of the rectilinear image up in the camera's."""
    library = load_library()
    database = library.lf_db_new()
    assert library.lf_db_load_file(database, path.encode()) == 0
    lens = library.lf_db_find_lenses_hd(database, None, None, model.encode(), 0)[0]
    modifier = library.lf_modifier_new(lens, crop, *SIZE)
    library.lf_modifier_initialize(modifier, lens, 0, focal, 8, 10, 1, RECTILINEAR,
                                   DISTORTION_AND_GEOMETRY, 0)
    seen = []
    for x, y in pixels:
        place = (ctypes.c_float * 2)()
        assert library.lf_modifier_apply_geometry_distortion(modifier, x, y, 1, 1, place)
        seen.append((place[0], place[1]))
    return seen


@unittest.skipUnless(LENSFUN, "no liblensfun; 'apt-get install liblensfun1' installs it")
class Lensfun(CommandTest):
    def assert_seen_alike(self, file, model, camera, crop, focal, used_focal, center, tolerance):
        """Rays of a rectilinear image, whose focal length Lensfun uses, are seen where it says."""
        pixels_per_mm = math.hypot(*SIDES_PX) * crop / FULL_FRAME_MM
        middle = [side / 2 + shift * min(SIDES_PX) / 2 for side, shift in zip(SIDES_PX, center)]
        pixels = [(x, y) for x in range(20, SIZE[0], 85) for y in range(20, SIZE[1], 75)]
        points = write(self.path("rays.csv"), "x,y,z\n" + "".join(
            ",".join(repr((at - mid) / (used_focal * pixels_per_mm))
                     for at, mid in zip(pixel, middle)) + ",1\n" for pixel in pixels))
        result = self.succeed("project", camera, "--points", points)
        rows = [line.split(",") for line in result.stdout.split()[1:]]
        count = 0
        for (u, v), row in zip(lensfun_pixels(file, model, crop, focal, pixels), rows):
            if row[5] != "1":
                continue
            count += 1
            self.assertLess(math.hypot(u - float(row[3]), v - float(row[4])), tolerance)
        self.assertGreater(count, 30)

    def test_lenses_are_those_of_liblensfun(self):
        for model, numbers, scale in (("poly3", 'k1="-0.05"', 1.05),
                                      ("poly5", 'k1="-0.05" k2="0.01"', 1),
                                      ("ptlens", 'a="0.01" b="-0.03" c="-0.04"', 1.06)):
            for kind in ("", "fisheye", "equisolid", "stereographic", "orthographic",
                         "fisheye_thoby"):
                # It asks for the real focal length where it changes the projection alone.
                for real in (None, 17) if kind else (None,):
                    with self.subTest(model, kind=kind, real=real):
                        text = LENS.format(
                            model=model, numbers=numbers,
                            type=f"<type>{kind}</type>" if kind else "",
                            real=f'<real-focal-length focal="20" real-focal="{real}"/>'
                            if real else "")
                        source = write(self.path("typed.xml"), text)
                        camera = self.path("lens.yaml")
                        self.succeed("import", source, "--image-size", "640x480", "-o",
                                     camera)
                        exact = kind in ("", "fisheye") and model != "ptlens"
                        self.assert_seen_alike(source, "testlens", camera, 1.5, 20,
                                               real / scale if real else 20, (0.05, -0.03),
                                               2e-4 if exact else 0.02)

    def test_what_is_written_is_what_liblensfun_sees(self):
        pinhole = write(self.path("f.yaml"), "fx: 400\nfy: 400\ncx: 321.5\ncy: 238\nk1: -0.1\n"
                        "k2: 0.02\np1: 0\np2: 0\nwidth: 640\nheight: 480\n")
        camera, file = self.path("pinhole.yaml"), self.path("pinhole.xml")
        self.succeed("import", pinhole, "-o", camera)
        result = self.succeed("export", camera, "--to", "lensfun", "-o", file)
        self.assertIn("exact", result.stdout)
        focal = 400 * FULL_FRAME_MM / math.hypot(*SIDES_PX)
        center = ((321.5 - 319.5) * 2 / 479, (238 - 239.5) * 2 / 479)
        text = read(file).decode()
        model = text.split("<model>")[1].split("<")[0]
        self.assert_seen_alike(file, model, camera, 1, focal, focal, center, 2e-4)
        back = self.path("back.yaml")
        self.succeed("import", file, "--image-size", "640x480", "-o", back)
        self.assert_seen_alike(file, model, back, 1, focal, focal, center, 2e-4)
        self.assert_refused(run("import", file, "-o", back), 2, "--image-size")


if __name__ == "__main__":
    main(__name__)
