/// Docstrings of the longer methods of Camera, for help() and the API
/// reference, with sections in Google style.
#ifndef RAYGRID_PYTHON_CAMERA_DOCSTRINGS_H
#define RAYGRID_PYTHON_CAMERA_DOCSTRINGS_H

namespace raygrid::docstring {

inline constexpr char kCamera[] =
    R"(A calibrated camera in double precision; immutable.

Pixels are (x, y), and (0, 0) is the centre of the top-left pixel. Camera axes
are x right, y down, z forward; lengths are metres. Results are NaN outside the
calibrated area and for points that are not visible. Arrays may have any number
of leading axes, any real dtype and any strides; contiguous doubles are not
copied. Non-finite input raises ValueError.)";

inline constexpr char kLoad[] =
    R"(Load a camera.yaml, or another program's file of one camera.

Warns (UserWarning) about contents that are ignored.

Args:
    path: the file; its format is recognized from its contents.

Raises:
    Error: the file cannot be read, is malformed, or is a blob (see Blob).)";

inline constexpr char kSave[] =
    R"(Write a camera.yaml, completely or not at all.

Args:
    path: the file to write.

Raises:
    Error: the file cannot be written.)";

inline constexpr char kAt[] =
    R"(Return the camera at an operating point.

For a camera that was calibrated over focus or temperature. Without at(), such a
camera is the one at the centre of its range.

Args:
    value: focus in dioptres or temperature in degrees Celsius, for a camera
        with one range.
    lens_position: focus in dioptres, for a camera with either or both ranges.
    temperature: in degrees Celsius, likewise. If only one of two is given, the
        result keeps the range of the other.

Raises:
    ValueError: the camera has no such range, or the value is outside it.)";

inline constexpr char kProject[] =
    R"(Project points into the image.

Args:
    points: (..., 3) points in camera axes, metres; for a central camera also
        directions of any length.
    jacobians: also return the Jacobian of the pixel with respect to the point.
    threads: number of threads; 0: one per core. Results do not depend on it.

Returns:
    Pixels (..., 2); with jacobians also (..., 2, 3), in pixels per metre. NaN
    for points that are not visible.)";

inline constexpr char kUnproject[] =
    R"(Unproject pixels to viewing directions.

The rays of a non-central camera do not start at the origin: see rays().

Args:
    pixels: (..., 2) pixels.
    jacobians: also return the Jacobian of the direction with respect to the
        pixel.
    threads: number of threads; 0: one per core. Results do not depend on it.

Returns:
    Unit directions (..., 3) in camera axes; with jacobians also (..., 3, 2), in
    radians per pixel. NaN outside the calibrated area.)";

inline constexpr char kRays[] =
    R"(Unproject pixels to rays, for central and non-central cameras.

Args:
    pixels: (..., 2) pixels.
    threads: number of threads; 0: one per core. Results do not depend on it.

Returns:
    Origins and unit directions, both (..., 3), in camera axes and metres. The
    origin of a central camera is (0, 0, 0). NaN outside the calibrated area.)";

inline constexpr char kUncertainty[] =
    R"(Predicted uncertainty of projection at pixels.

Args:
    pixels: (..., 2) pixels.

Returns:
    Standard deviations (...) of a coordinate (RMS of both axes), in pixels, of
    the projection of a far point that the pixel observes. NaN where unknown.

Raises:
    Error: the camera has no uncertainty, because it was imported or fitted.)";

inline constexpr char kIsValid[] =
    R"(Whether pixels are in the valid region of the calibration.

Args:
    pixels: (..., 2) pixels.

Returns:
    An array (...) of bool.

Raises:
    Error: the camera has no valid region, because it was imported or fitted.)";

inline constexpr char kUncertaintyFigures[] =
    R"(Summary of the predicted uncertainty, as calibrate prints it.

A dict of median_px, the median standard deviation; valid_limit_px and
valid_fraction, the limit of the valid region in pixels and the fraction of the
image inside it; and fraction_below_px, the fraction of the image below each of
several limits in pixels. Raises Error if the camera has no uncertainty.)";

inline constexpr char kView[] =
    R"(Define an output view: the virtual camera of undistorted images.

Arguments are the options of 'raygrid undistort'. At most one of hfov, vfov,
focal and alpha is needed. Without any argument it is the output view of the remap
table that calibrate packs.

Args:
    size: (width, height) in pixels; default: that of the camera's images.
    hfov: horizontal field of view in degrees.
    vfov: vertical field of view in degrees.
    focal: focal length in pixels.
    alpha: 0: the largest view of valid pixels only; 1: the smallest view of all
        pixels.
    center: principal point (x, y) in pixels; default: the image centre.
    rotate: (yaw, pitch, roll) to the right, up and clockwise, in degrees.
    projection: 'pinhole' (default), 'cylindrical', 'equirectangular',
        'stereographic' or 'equidistant'.

Raises:
    ValueError: an argument is invalid.
    Error: no such output view of this camera exists.)";

inline constexpr char kMaps[] =
    R"(Compute the maps of cv2.remap() that undistort images.

Args:
    view: the output view (undistorted images); default: view().
    reverse: compute the inverse maps, which map undistorted images back to the
        camera image.
    threads: number of threads; 0: one per core. Results do not depend on it.

Returns:
    map1 and map2, float32 (height, width) of the output, with x and y of the
    source pixel, -1 where there is none.)";

inline constexpr char kPack[] =
    R"(Pack the camera into a blob for devices, which Blob() evaluates.

Warns (UserWarning) about contents that the blob cannot contain.

Args:
    views: output views, each with a remap table; default: view().
    max_error_px: largest error of the remap tables, in pixels.
    threads: number of threads; 0: one per core. Results do not depend on it.

Returns:
    The bytes of the blob (formats/SPEC.md).

Raises:
    Error: the camera or an output view cannot be packed.)";

}  // namespace raygrid::docstring

#endif  // RAYGRID_PYTHON_CAMERA_DOCSTRINGS_H
