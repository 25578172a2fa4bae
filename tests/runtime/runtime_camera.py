"""The runtime's cameras by ctypes, in integers, for tests of bits."""
import ctypes
import os

EXTRAPOLATED = -64
Pixel, Vector = ctypes.c_int32 * 2, ctypes.c_int32 * 3

library = ctypes.CDLL(os.environ["RAYGRID_LIBRARY"])


class Line(ctypes.Structure):
    _fields_ = [("point", Vector), ("direction", Vector)]


class PixelValue(ctypes.Structure):
    _fields_ = [("x", ctypes.c_int32), ("y", ctypes.c_int32)]


class Camera:
    """Of a blob's bytes; with a stack at a condition in q16."""

    def __init__(self, data, condition=None):
        self._memory = (ctypes.c_uint32 * (len(data) // 4)).from_buffer_copy(data)
        self._camera = (ctypes.c_uint64 * 8)()
        status = library.rg_camera_open(self._camera, self._memory, len(data))
        assert status == 0, status
        if condition is not None:
            status = library.rg_set_operating_point(self._camera, ctypes.c_int32(condition))
            assert status in (0, EXTRAPOLATED), status

    def line(self, pixel):
        line = Line()
        status = library.rg_unproject_line(self._camera, PixelValue(*pixel), ctypes.byref(line))
        return None if status else (tuple(line.point), tuple(line.direction))

    def ray(self, pixel):
        ray = Vector()
        status = library.rg_unproject(self._camera, PixelValue(*pixel), ray)
        return None if status else tuple(ray)

    def pixel_of(self, direction):
        pixel = Pixel()
        return None if library.rg_project(self._camera, Vector(*direction), pixel) else tuple(pixel)

    def pixel_of_point(self, point, fraction_bits):
        pixel = Pixel()
        status = library.rg_project_point(self._camera, Vector(*point),
                                          ctypes.c_uint32(fraction_bits), pixel)
        return None if status else tuple(pixel)

    def is_valid(self, pixel):
        return library.rg_is_valid(self._camera, PixelValue(*pixel)) != 0

    def uncertainty(self, pixel):
        value = ctypes.c_uint16()
        status = library.rg_uncertainty(self._camera, PixelValue(*pixel), ctypes.byref(value))
        return None if status else value.value
