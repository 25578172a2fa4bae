"""The module raygrid, run by MicroPython: module_test.py FOLDER, which write_golden.py made."""
import binascii
import json
import sys
from array import array

import micropython
import raygrid

FOLDER = sys.argv[1]


def read(name):
    with open(FOLDER + "/" + name, "rb") as file:
        return file.read()


EXPECTED = json.loads(read("expected.json"))
NO_PIXEL = -2**31


def flat(rows):
    return [value for row in rows for value in row]


def assert_close(values, expected, delta):
    for value, other in zip(values, flat(expected)):
        assert abs(value - other) <= delta, (list(values), expected)


def assert_refused(kind, text, call, *arguments):
    try:
        call(*arguments)
    except kind as error:
        assert text in str(error), error
    else:
        raise AssertionError(text + " was expected")


def test_rays():
    camera = raygrid.Camera(read("lens.raygrid"))
    assert camera.calibrated_size() == (160, 120)
    pixels, rays = array("f", flat(EXPECTED["pixels"])), array("f", [0] * 9)
    assert camera.unproject(pixels, rays) == 3
    assert_close(rays, EXPECTED["rays"], 2e-7)
    fixed, fixed_rays = array("i", [int(v * 65536) for v in pixels]), array("i", [0] * 9)
    assert camera.unproject(fixed, fixed_rays) == 3
    assert_close([v / 2**30 for v in fixed_rays], EXPECTED["rays"], 1e-7)
    outside = array("f", [-1, 0, float("nan"), 3, 1e30, float("-inf")])
    assert camera.unproject(outside, rays) == 0
    assert list(rays) == [0] * 9


def test_projection():
    camera = raygrid.Camera(read("wide.raygrid"))
    pixels = array("f", [0] * 6)
    points = array("f", [7e5 * v for v in flat(EXPECTED["wide_rays"])])
    assert camera.project(points, pixels) == 3
    assert_close(pixels, EXPECTED["pixels"], 0.003)
    none = array("f", [0, 0, 0, 0, 0, -1, float("nan"), 0, 1])
    fixed = array("i", [0] * 6)
    assert camera.project(none, fixed) == 0
    assert list(fixed) == [NO_PIXEL] * 6


def test_lines():
    camera = raygrid.Camera(read("lines.raygrid"))
    pixels = array("f", [0] * 6)
    for metres in (0.3, 7, 1e5, 1e12):
        points = [o + metres * d for o, d in zip(flat(EXPECTED["line_points"]),
                                                 flat(EXPECTED["line_rays"]))]
        assert camera.project(array("f", points), pixels) == 3
        assert_close(pixels, EXPECTED["pixels"], 0.003)
    points = [round((o + 7 * d) * 2**20) for o, d in zip(flat(EXPECTED["line_points"]),
                                                         flat(EXPECTED["line_rays"]))]
    assert camera.project(array("i", points), pixels) == 3
    assert_close(pixels, EXPECTED["pixels"], 0.003)


def test_conditions():
    camera = raygrid.Camera(read("stack.raygrid"))
    pixels, rays = array("f", flat(EXPECTED["pixels"])), array("f", [0] * 9)
    for k, value in enumerate(EXPECTED["stack_values"]):
        assert camera.set_condition(value) == EXPECTED["stack_inside"][k]
        assert camera.unproject(pixels, rays) == 3
        assert_close(rays, EXPECTED["stack_rays"][k], 2e-7)
    assert not camera.set_condition(1e30)
    assert_refused(ValueError, "single operating point", raygrid.Camera(read("wide.raygrid")).set_condition, 1)
    assert_refused(TypeError, "", camera.set_condition, "near")


def test_frames():
    camera = raygrid.Camera(read("lens.raygrid"))
    width, height = camera.remap_size()
    assert [width, height] == EXPECTED["size"] and camera.frame_size() == (160, 120)
    frame, out = read("frame"), bytearray(width * height)
    camera.undistort(image=frame, out=out, format=raygrid.GREY8, border=EXPECTED["border"])
    crc = binascii.crc32(out)
    print("remap CRC %08x" % crc)
    assert crc == EXPECTED["crc"]
    bands = b""
    for first in range(0, height, 7):
        rows = min(7, height - first)
        band = bytearray(width * rows)
        camera.undistort(frame, band, border=EXPECTED["border"], first_row=first, num_rows=rows)
        bands += band
    assert bands == out
    assert camera.view()[0] == 0


def test_nothing_is_allocated():
    camera = raygrid.Camera(read("wide.raygrid"))
    width, height = camera.remap_size()
    frame, out = bytes(320 * 240 * 3 // 2), bytearray(width * height * 3 // 2)
    pixels, rays = array("f", [100, 100]), array("f", [0] * 3)
    nv12 = raygrid.NV12
    micropython.heap_lock()
    camera.unproject(pixels, rays)
    camera.project(rays, pixels)
    camera.undistort_points(pixels, pixels)
    camera.undistort(frame, out, nv12)
    micropython.heap_unlock()


def test_refusals():
    blob = read("lens.raygrid")
    camera = raygrid.Camera(blob)
    damaged = bytearray(blob)
    damaged[-1] ^= 1
    assert_refused(ValueError, "corrupt", raygrid.Camera, damaged)
    assert_refused(ValueError, "", raygrid.Camera, b"")
    assert_refused(TypeError, "", raygrid.Camera, 7)
    assert_refused(ValueError, "inverse", camera.project, array("f", [0, 0, 1]), array("f", [0, 0]))
    frame, out = read("frame"), bytearray(EXPECTED["size"][0] * EXPECTED["size"][1])
    assert_refused(ValueError, "expected 19200 bytes, not 3", camera.undistort, b"abc", out)
    assert_refused(ValueError, " bytes, not ", camera.undistort, frame, bytearray(3))
    assert_refused(TypeError, "", camera.undistort, frame, bytes(len(out)))
    assert_refused(ValueError, "15 is out of range (0 to 14)", camera.undistort, frame, out, 15)
    assert_refused(ValueError, "is out of range", camera.undistort, frame, out, 0, 0, 200)
    assert_refused(ValueError, "remap", camera.select_remap, 1)
    assert_refused(ValueError, "remap", camera.select_remap, -1)
    assert_refused(TypeError, "array", camera.unproject, b"12345678", array("f", [0] * 3))
    assert_refused(ValueError, "wrong length", camera.unproject, array("f", [1, 2]), array("f", [0] * 6))
    assert_refused(ValueError, "expected 2", camera.unproject, array("f", [1]), array("f", [0] * 3))


for test in (test_rays, test_projection, test_lines, test_conditions, test_frames,
             test_nothing_is_allocated, test_refusals):
    test()
    print(test.__name__, "passed")
