"""raygrid's runtime for devices: unprojection, projection and undistortion from a blob.

Example::

    import raygrid
    camera = raygrid.Camera("camera.raygrid")
    direction = camera.unproject([(320, 240)])[0]

Pixels are (x, y), and (0, 0) is the centre of the top-left pixel. Camera axes are x right, y down,
z forward. Lengths are metres.

The module needs Python 3.7 and the shared library: the one that RAYGRID_LIBRARY names, or one
beside this file, in its installation or build folder, or known to the system. Points may be numpy
arrays (N, 2) or (N, 3), and frames arrays; results are lists of tuples, which numpy.array() takes.
"""
import ctypes
import ctypes.util
import math
import operator
import os
import sysconfig
from pathlib import Path
from typing import NamedTuple

#: The number of the rg_status of this name, which Error.status may be.
OK, OUTSIDE_AREA, NO_REMAP, NOT_SEEN, NONCENTRAL, UNKNOWN, NO_INVERSE, EXTRAPOLATED = (
    0, -50, -51, -54, -57, -58, -60, -64)
#: RG_NO_PIXEL of raygrid.h.
NO_PIXEL = -2**31
#: Factor of a fixed-point format of raygrid.h.
Q12, Q16, Q28, Q30 = 2**12, 2**16, 2**28, 2**30
#: Factor of q10 nanoseconds, from seconds.
Q10_NS = 2**10 * 1e9
#: RG_POINT_MAX_BITS of raygrid.h.
POINT_MAX_BITS = 27

#: Pixel formats of undistort(), those of rg_format. By name the number, bits per sample, and of
#: each plane the bytes per row as a multiple of the width and the rows as a multiple of the height.
FORMATS = {
    "GREY8": (0, 8, ((1, 1),)),
    "GREY16": (1, 16, ((2, 1),)),
    "GREY10P": (2, 10, ((1.25, 1),)),
    "GREY12P": (3, 12, ((1.5, 1),)),
    "RGB24": (4, 8, ((3, 1),)),
    "RGB32": (5, 8, ((4, 1),)),
    "YUYV": (6, 8, ((2, 1),)),
    "UYVY": (7, 8, ((2, 1),)),
    "NV12": (8, 8, ((1, 1), (1, 0.5))),
    "YUV420": (9, 8, ((1, 1), (0.5, 0.5), (0.5, 0.5))),
    "BAYER8": (10, 8, ((1, 1),)),
    "BAYER16": (11, 16, ((2, 1),)),
    "BAYER10P": (12, 10, ((1.25, 1),)),
    "BAYER12P": (13, 12, ((1.5, 1),)),
    "RGB565": (14, 16, ((2, 1),)),
}
#: Projections of a View, those of rg_projection.
PROJECTIONS = ("pinhole", "cylindrical", "equirectangular", "stereographic", "equidistant")
#: What undistort() fills pixels without a source with. By name border_values, the nearest
#: calibrated pixel, or the contents of out.
BORDERS = {"value": 0, "clamp": 1, "keep": 2}
#: Interpolations of undistort(), by name.
SAMPLINGS = {"bilinear": 0, "nearest": 1}


class Error(Exception):
    """An error of the runtime; its attribute status is the number of the rg_status."""

    def __init__(self, status):
        super().__init__(_library.rg_status_text(status).decode())
        self.status = status


# rg_camera: 64 bytes at most, whose fields are the library's alone.
_Camera = ctypes.c_uint64 * 8


# The structures of raygrid.h, by their names and those of their fields.
class _Pixel(ctypes.Structure):
    _fields_ = [("x_q16", ctypes.c_int32), ("y_q16", ctypes.c_int32)]


class _Ray(ctypes.Structure):
    _fields_ = [("x_q30", ctypes.c_int32), ("y_q30", ctypes.c_int32), ("z_q30", ctypes.c_int32)]


class _Line(ctypes.Structure):
    _fields_ = [("point_q28", ctypes.c_int32 * 3), ("direction", _Ray)]


class _Plane(ctypes.Structure):  # of an image, or a target
    _fields_ = [("data", ctypes.c_void_p), ("stride", ctypes.c_uint32)]


class _Image(ctypes.Structure):
    _fields_ = [("format", ctypes.c_int), ("width", ctypes.c_uint16),
                ("height", ctypes.c_uint16), ("ring_rows", ctypes.c_uint16),
                ("first_row", ctypes.c_uint16), ("num_rows", ctypes.c_uint16),
                ("planes", _Plane * 3)]


class _Target(ctypes.Structure):
    _fields_ = [("planes", _Plane * 3), ("first_row", ctypes.c_uint16),
                ("num_rows", ctypes.c_uint16), ("border", ctypes.c_int),
                ("sampling", ctypes.c_int), ("border_values", ctypes.c_uint16 * 4),
                ("kernels", ctypes.c_void_p)]


class _View(ctypes.Structure):
    _fields_ = [("width", ctypes.c_uint16), ("height", ctypes.c_uint16),
                ("projection", ctypes.c_int), ("fx_q16", ctypes.c_uint32),
                ("fy_q16", ctypes.c_uint32), ("cx_q16", ctypes.c_int32),
                ("cy_q16", ctypes.c_int32), ("rotation_q30", ctypes.c_int32 * 9),
                ("distorts", ctypes.c_uint8)]


class _Mode(ctypes.Structure):
    _fields_ = [("width", ctypes.c_uint16), ("height", ctypes.c_uint16),
                ("offset_x_q16", ctypes.c_int32), ("offset_y_q16", ctypes.c_int32),
                ("scale_x_q16", ctypes.c_uint32), ("scale_y_q16", ctypes.c_uint32),
                ("flip_x", ctypes.c_uint8), ("flip_y", ctypes.c_uint8)]


class Mode(NamedTuple):
    """A sensor mode: how its frames map to the calibrated images.

    Pixel i, counted from the opposite side if flipped, covers the calibrated pixels from
    offset + scale * i on, scale of them; in x and in y.
    """
    #: Of the mode's frames, in pixels.
    width: int
    #: Of the mode's frames, in pixels.
    height: int
    #: (x, y) in calibrated pixels.
    offset: tuple
    #: (x, y) in calibrated pixels per pixel.
    scale: tuple
    #: Whether frames are mirrored in (x, y).
    flips: tuple


class View(NamedTuple):
    """An output view: the virtual camera of undistorted images."""
    #: One of PROJECTIONS.
    projection: str
    #: Of the undistorted image, in pixels.
    width: int
    #: Of the undistorted image, in pixels.
    height: int
    #: Focal length in pixels (per radian at the centre, if not pinhole).
    fx: float
    #: Focal length in pixels (per radian at the centre, if not pinhole).
    fy: float
    #: Principal point in pixels.
    cx: float
    #: Principal point in pixels.
    cy: float
    #: camera_from_view, (3, 3), row-major.
    rotation: tuple
    #: Whether it belongs to an inverse remap table, which maps undistorted images back to frames
    #: of the camera.
    distorts: bool = False

    @property
    def K(self):
        """Camera matrix (3, 3), row-major, in pixels."""
        return (self.fx, 0.0, self.cx), (0.0, self.fy, self.cy), (0.0, 0.0, 1.0)


def _library_places():
    """Paths that the library may have: beside this file, also as a part of the host's package; in
    PREFIX/lib*, of PREFIX/share/raygrid/python; in the host's build folder, of the sources."""
    here = Path(__file__).resolve().parent
    folders = [here]
    if here.parts[-3:] == ("share", "raygrid", "python"):
        names = ("lib", f"lib/{sysconfig.get_config_var('MULTIARCH')}", "lib64")
        folders += [here.parents[2] / name for name in names]
    if here.parts[-2:] == ("runtime", "python"):
        folders.append(here.parents[1] / "build" / "host" / "runtime")
    return [*here.glob("_raygrid.*.so"), *(folder / "libraygrid.so" for folder in folders)]


def _find_library():
    named = os.environ.get("RAYGRID_LIBRARY")
    if named:
        return named
    places = _library_places()
    for place in places:
        if place.exists():
            return str(place)
    found = ctypes.util.find_library("raygrid")
    if not found:
        raise ImportError("libraygrid.so not found at " + " or ".join(map(str, places))
                          + " nor by the dynamic linker; set RAYGRID_LIBRARY to its path")
    return found


def _load_library():
    path = _find_library()
    try:
        library = ctypes.CDLL(path)
    except OSError as error:
        raise ImportError(f"raygrid's library {path} cannot be loaded: {error}") from error
    library.rg_status_text.restype = ctypes.c_char_p
    library.rg_find_kernels.restype = ctypes.c_void_p
    for name in ("rg_unproject_batch", "rg_project_batch", "rg_undistort_points"):
        getattr(library, name).restype = ctypes.c_uint32
    return library


_library = _load_library()


def _check(status):
    if status != OK:
        raise Error(status)


def _pixels(points):
    """Positions as the library wants them; those too distant, and what is no number, become ones
    that are in no camera's area."""
    array = (_Pixel * len(points))()
    for pixel, (x, y) in zip(array, points):
        pixel.x_q16, pixel.y_q16 = _fixed(x), _fixed(y)
    return array


def _fixed(value):
    scaled = float(value) * Q16
    if math.isnan(scaled):
        return 1 - 2**31
    return round(max(1 - 2**31, min(2**31 - 1, scaled)))


def _direction(point):
    """Q30, of a length that the library takes; (0, 0, 0), which no pixel sees, where a coordinate
    is not finite."""
    values = [float(v) for v in point]
    largest = max(map(abs, values))
    if largest == 0 or not all(map(math.isfinite, values)):
        return [0, 0, 0]
    return [round(v / largest * Q30) for v in values]


def _in_metres(point):
    """Fixed point below 2^30, and its fraction bits; (0, 0, 0), which no pixel sees, where a
    coordinate is not finite."""
    values = [float(v) for v in point]
    if not all(map(math.isfinite, values)):
        return [0, 0, 0], 0
    bits = min(30 - math.frexp(max(map(abs, values)))[1], POINT_MAX_BITS)
    return [round(math.ldexp(v, bits)) for v in values], max(bits, 0)


def _positions(array):
    return [None if p.x_q16 == NO_PIXEL else (p.x_q16 / Q16, p.y_q16 / Q16) for p in array]


def _xyz(ray):
    return ray.x_q30 / Q30, ray.y_q30 / Q30, ray.z_q30 / Q30


class Camera:
    """A blob, whose first remap table is selected, if there is any.

    Attributes:
        width: of the calibrated images, in pixels.
        height: of the calibrated images, in pixels.
        is_central: whether all rays start at the origin.
        num_remaps: number of remap tables.

    Args:
        blob: path of a file, or its bytes.

    Raises:
        Error: the blob is malformed or its version not supported.
    """

    def __init__(self, blob):
        data = blob if isinstance(blob, (bytes, bytearray, memoryview)) else Path(blob).read_bytes()
        self._blob = (ctypes.c_uint32 * (len(data) // 4 + 1))()  # a multiple of 4
        ctypes.memmove(self._blob, bytes(data), len(data))
        self._camera = _Camera()
        _check(_library.rg_camera_open(ctypes.byref(self._camera), self._blob,
                                       ctypes.c_uint32(len(data))))
        _, (self.width, self.height) = self._size(_library.rg_calibrated_size)
        self.is_central = _library.rg_unproject(ctypes.byref(self._camera), _Pixel(0, 0),
                                                ctypes.byref(_Ray())) != NONCENTRAL
        self._has_inverse = self._project_ahead() != NO_INVERSE
        self.num_remaps = self._count_remaps()
        if self.num_remaps != 0:
            self.select_remap(0)

    def _size(self, function):
        """The status and the size that a function of the library gives."""
        width, height = ctypes.c_uint16(), ctypes.c_uint16()
        status = function(ctypes.byref(self._camera), ctypes.byref(width), ctypes.byref(height))
        return status, (width.value, height.value)

    def _project_ahead(self):
        """The status of a point in front of the camera."""
        return _library.rg_project_point(ctypes.byref(self._camera), (ctypes.c_int32 * 3)(0, 0, 1),
                                         ctypes.c_uint32(0), ctypes.byref(_Pixel()))

    def _count_remaps(self):
        """Remap tables of the blob, faulty ones too."""
        count = 0
        while _library.rg_select_remap(ctypes.byref(self._camera),
                                       ctypes.c_uint32(count)) != NO_REMAP:
            count += 1
        return count

    def unproject(self, points):
        """Unproject pixels (x, y) to unit directions (x, y, z) in camera axes.

        A list of tuples, with None outside the calibrated area. The rays of a non-central camera
        do not start at the origin: see unproject_lines().
        """
        if not self.is_central:
            return [line and line[1] for line in self.unproject_lines(points)]
        rays = (_Ray * len(points))()
        _library.rg_unproject_batch(ctypes.byref(self._camera), _pixels(points), rays,
                                    ctypes.c_uint32(len(points)))
        return [_xyz(ray) if any(_xyz(ray)) else None for ray in rays]

    def unproject_lines(self, points):
        """Unproject pixels (x, y) to observation lines, for central and non-central cameras.

        A list of (point, direction), two tuples (x, y, z) in camera axes, in metres and of unit
        length; None outside the calibrated area.
        """
        lines = []
        for pixel in _pixels(points):
            line = _Line()
            status = _library.rg_unproject_line(ctypes.byref(self._camera), pixel,
                                                ctypes.byref(line))
            if status not in (OK, OUTSIDE_AREA):
                raise Error(status)
            lines.append((tuple(v / Q28 for v in line.point_q28), _xyz(line.direction))
                         if status == OK else None)
        return lines

    def project(self, points):
        """Project points (x, y, z) in camera axes to pixels (x, y).

        Points are in metres; for a central camera in any unit, so directions too. A list of
        tuples, with None for points that are not visible. Raises Error if the blob has no inverse
        grid.
        """
        if not self._has_inverse:
            raise Error(NO_INVERSE)
        if not self.is_central:
            return _positions(self._project_point(point) for point in points)
        rays = (_Ray * len(points))(*(_Ray(*_direction(point)) for point in points))
        pixels = (_Pixel * len(points))()
        _library.rg_project_batch(ctypes.byref(self._camera), rays, pixels,
                                  ctypes.c_uint32(len(points)))
        return _positions(pixels)

    def _project_point(self, point):
        """A pixel of a camera of lines."""
        values, bits = _in_metres(point)
        pixel = _Pixel()
        if _library.rg_project_point(ctypes.byref(self._camera), (ctypes.c_int32 * 3)(*values),
                                     ctypes.c_uint32(bits), ctypes.byref(pixel)) != OK:
            return _Pixel(NO_PIXEL, NO_PIXEL)
        return pixel

    def is_valid(self, points):
        """Whether pixels (x, y) are in the valid region: a list of bool."""
        return [bool(_library.rg_is_valid(ctypes.byref(self._camera), pixel))
                for pixel in _pixels(points)]

    def uncertainty(self, points):
        """Predicted uncertainty of projection at pixels (x, y).

        A list of standard deviations of a coordinate, in pixels; None where unknown.
        """
        values = []
        for pixel in _pixels(points):
            sigma = ctypes.c_uint16()
            status = _library.rg_uncertainty(ctypes.byref(self._camera), pixel,
                                             ctypes.byref(sigma))
            if status not in (OK, OUTSIDE_AREA, UNKNOWN):
                raise Error(status)
            values.append(sigma.value / Q12 if status == OK else None)
        return values

    def row_time(self):
        """Line delay of a rolling shutter, and its standard deviation, in seconds.

        The readout time per row of calibrated frames: row r is read
        row_time * (r - (height - 1) / 2) after the middle of the frame. A standard deviation of 0
        means unknown. None if the blob has no line delay.
        """
        row_time, deviation = ctypes.c_int32(), ctypes.c_uint32()
        status = _library.rg_line_delay(ctypes.byref(self._camera), ctypes.byref(row_time),
                                      ctypes.byref(deviation))
        if status == UNKNOWN:
            return None
        _check(status)
        return row_time.value / Q10_NS, deviation.value / Q10_NS

    def select_remap(self, index):
        """Select a remap table by its index, from 0 to num_remaps - 1.

        It is used by undistort(), undistort_points(), view() and so on. Open two cameras to use
        two tables at a time. Raises Error if there is no such table, or it is malformed.
        """
        if not 0 <= index < 2**32:
            raise Error(NO_REMAP)
        _check(_library.rg_select_remap(ctypes.byref(self._camera), ctypes.c_uint32(index)))

    def set_condition(self, value):
        """Set the operating point of a camera that was calibrated over focus or temperature.

        Args:
            value: focus in dioptres, or temperature in degrees Celsius.

        Returns:
            False if the value is outside the calibrated range and was clamped to it.

        Raises:
            Error: the blob has no stack of operating points, or it is malformed.
        """
        value_q16 = round(max(-32767.0, min(value, 32767.0)) * Q16)
        status = _library.rg_set_operating_point(ctypes.byref(self._camera), ctypes.c_int32(value_q16))
        if status != EXTRAPOLATED:
            _check(status)
        return status == OK

    def frame_size(self):
        """Width and height of the frames that undistort() takes, in pixels."""
        return self._size(_library.rg_frame_size)[1]

    def mode(self):
        """Sensor mode of the selected remap table, a Mode. Raises Error without a table."""
        mode = _Mode()
        _check(_library.rg_remap_mode(ctypes.byref(self._camera), ctypes.byref(mode)))
        return Mode(mode.width, mode.height, (mode.offset_x_q16 / Q16, mode.offset_y_q16 / Q16),
                    (mode.scale_x_q16 / Q16, mode.scale_y_q16 / Q16),
                    (bool(mode.flip_x), bool(mode.flip_y)))

    def remap_size(self):
        """Width and height of the undistorted image, in pixels. Raises Error without a table."""
        status, size = self._size(_library.rg_remap_size)
        _check(status)
        return size

    def view(self):
        """Output view of the selected table, a View. Raises Error without a table."""
        view = _View()
        _check(_library.rg_remap_view(ctypes.byref(self._camera), ctypes.byref(view)))
        numbers = [value / Q30 for value in view.rotation_q30]
        return View(PROJECTIONS[view.projection], view.width, view.height, view.fx_q16 / Q16,
                    view.fy_q16 / Q16, view.cx_q16 / Q16, view.cy_q16 / Q16,
                    tuple(tuple(numbers[k:k + 3]) for k in (0, 3, 6)), bool(view.distorts))

    def undistort_points(self, points):
        """Undistort pixels (x, y) to positions (x, y) in the undistorted image.

        A list of tuples, with None for pixels that the output view cannot show. Raises Error
        without a selected table.
        """
        self.remap_size()
        result = (_Pixel * len(points))()
        _library.rg_undistort_points(ctypes.byref(self._camera), _pixels(points), result,
                                     ctypes.c_uint32(len(points)))
        return _positions(result)

    def undistort(self, frame, pixel_format="GREY8", border="value", border_values=(0, 0, 0, 0),
                  sampling="bilinear", out=None):
        """Undistort a frame with the selected remap table.

        Args:
            frame: bytes or an array: planes after each other, rows without padding.
            pixel_format: one of FORMATS.
            border: one of BORDERS, for pixels without a source.
            border_values: up to 4 integers, by channel, in units of the samples; with chroma Y,
                then the chroma that is first in memory, then the other.
            sampling: one of SAMPLINGS.
            out: memory for the result, such as a bytearray, other than the frame; it saves a copy.

        Returns:
            The undistorted frame as bytes, laid out like the frame; out, if given.

        Raises:
            Error: there is no remap table, or the size or alignment does not fit.
            ValueError: an argument is invalid, or the frame has not the number of bytes of its
                format.
        """
        number, bits, planes = _named(pixel_format, FORMATS)
        values = _border_values(border_values, bits)
        width, height = self.remap_size()
        size = self.frame_size()
        source = _readable(frame)
        needed = _frame_size(planes, *size)
        if len(source) != needed:
            raise ValueError(f"a frame of {size[0]} x {size[1]} has {needed} bytes in "
                             f"{pixel_format}, not {len(source)}")
        output = _writable(out, _frame_size(planes, width, height))
        image = _Image(number, *size, 0, 0, 0, _planes(_address(source), planes, *size))
        target = _Target(_planes(_address(output), planes, width, height), 0, height,
                         _named(border, BORDERS), _named(sampling, SAMPLINGS), values, None)
        _check(_library.rg_remap(ctypes.byref(self._camera), ctypes.byref(image),
                                 ctypes.byref(target)))
        return output.raw if out is None else out


def _named(name, values):
    if name not in values:
        raise ValueError(f"{name!r}: expected one of {', '.join(values)}")
    return values[name]


def _border_values(values, bits):
    """Those of all channels; 0 where none is given."""
    values = tuple(map(operator.index, values))
    if len(values) > 4 or not all(0 <= value < 2**bits for value in values):
        raise ValueError(f"border values must be up to 4 integers below {2**bits}, not {values}")
    return values + (0,) * (4 - len(values))


def _frame_size(planes, width, height):
    return sum(int(width * across) * int(height * down) for across, down in planes)


def _readable(frame):
    """A frame's bytes; a copy of them where the library cannot read the frame's own."""
    if isinstance(frame, bytes):
        return frame
    try:
        view = memoryview(frame)
    except TypeError:
        return bytes(frame)
    if view.readonly or not view.c_contiguous:
        return bytes(frame)
    return (ctypes.c_char * view.nbytes).from_buffer(view)


def _writable(out, size):
    """The memory of out, or new memory for None."""
    if out is None:
        return ctypes.create_string_buffer(size)
    view = memoryview(out)
    if view.readonly or not view.c_contiguous or view.nbytes != size:
        raise ValueError(f"out must be a contiguous, writable buffer of {size} bytes")
    return (ctypes.c_char * size).from_buffer(view)


def _address(memory):
    """The place of bytes, or of an array of ctypes."""
    return ctypes.cast(memory, ctypes.c_void_p).value or 0


def _planes(address, planes, width, height):
    result = (_Plane * 3)()
    for plane, (across, down) in zip(result, planes):
        plane.data, plane.stride = address, int(width * across)
        address += plane.stride * int(height * down)
    return result


#: The name of Camera in the host's package: programs that use Blob run with either.
Blob = Camera
