"""The runtime of devices, with numpy arrays."""
from __future__ import annotations

import os
from typing import Any, Optional, Sequence

import numpy as np
import numpy.typing as npt

from . import _runtime

#: An error of the runtime; its attribute status is the number of the rg_status.
BlobError = _runtime.Error


class Blob(_runtime.Camera):
    """A blob, evaluated by the fixed-point code of devices.

    The methods are those of the module for devices, but take and return numpy arrays, with NaN
    for None. The first remap table is selected, if there is any. Pixels are (x, y), and (0, 0) is
    the centre of the top-left pixel; camera axes are x right, y down, z forward.

    Args:
        blob: path of a file, or its bytes.

    Raises:
        BlobError: the blob is malformed or its version not supported.
    """

    def __init__(self, blob: str | os.PathLike[str] | bytes | bytearray | memoryview) -> None:
        super().__init__(blob)

    def unproject(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Unproject pixels (N, 2) to unit directions (N, 3) in camera axes.

        NaN outside the calibrated area. The rays of a non-central camera do not start at the
        origin: see rays().
        """
        return _rows(super().unproject(_vectors(points, 2)), 3)

    def rays(self, points: npt.ArrayLike) -> tuple[npt.NDArray[np.float64],
                                                   npt.NDArray[np.float64]]:
        """Unproject pixels (N, 2) to rays, for central and non-central cameras.

        Returns:
            Origins and unit directions, both (N, 3), in camera axes and metres. The origin of a
            central camera is (0, 0, 0). NaN outside the calibrated area.
        """
        if self.is_central:
            directions = self.unproject(points)
            return np.where(np.isnan(directions), np.nan, 0.0), directions
        lines = super().unproject_lines(_vectors(points, 2))
        return (_rows([line and line[0] for line in lines], 3),
                _rows([line and line[1] for line in lines], 3))

    def project(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Project points (N, 3) in camera axes, in metres, to pixels (N, 2).

        NaN for points that are not visible. Raises BlobError if the blob has no inverse grid.
        """
        return _rows(super().project(_vectors(points, 3)), 2)

    def is_valid(self, points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Whether pixels (N, 2) are in the valid region: (N,) bool."""
        return np.array(super().is_valid(_vectors(points, 2)), dtype=bool)

    def uncertainty(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Predicted uncertainty (N,) of projection at pixels (N, 2).

        Standard deviation of a coordinate (RMS of both axes), in pixels; NaN where unknown.
        """
        values = super().uncertainty(_vectors(points, 2))
        return np.array([np.nan if value is None else value for value in values])

    def undistort_points(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Undistort pixels (N, 2) to positions (N, 2) in the undistorted image.

        NaN for pixels that the output view cannot show. Raises BlobError without a selected table.
        """
        return _rows(super().undistort_points(_vectors(points, 2)), 2)

    def undistort(self, frame: Any, pixel_format: Optional[str] = None, border: str = "value",
                  border_values: Sequence[int] = (0, 0, 0, 0),
                  sampling: str = "bilinear", out: Any = None) -> Any:
        """Undistort a frame with the selected remap table.

        Args:
            frame: an array of uint8 or uint16 (height, width), or of uint8 (height, width, 3);
                with pixel_format bytes.
            pixel_format: a format of the module for devices (its FORMATS), such as 'NV12'.
            border: what fills pixels without a source: 'value', 'clamp' (the nearest calibrated
                pixel) or 'keep' (the contents of out).
            border_values: value of each channel, in units of the samples.
            sampling: 'bilinear' or 'nearest'.
            out: memory for the result, of its size and type and not the frame itself.

        Returns:
            The undistorted frame, of the type of frame; out, if given.

        Raises:
            BlobError: there is no remap table, or the size does not match.
            ValueError: the shape, dtype or an argument is invalid.
        """
        if pixel_format is not None:
            return super().undistort(frame, pixel_format, border, border_values, sampling, out)
        image = np.ascontiguousarray(frame)
        name = _format_of(image)
        width, height = self.remap_size()
        shape = (height, width) + image.shape[2:]
        if out is None:
            out = np.empty(shape, image.dtype)
        elif not (isinstance(out, np.ndarray) and out.shape == shape and out.dtype == image.dtype):
            raise ValueError(f"out: expected an array of {image.dtype} of the shape {shape}")
        return super().undistort(image, name, border, border_values, sampling, out)


def _format_of(image: npt.NDArray[Any]) -> str:
    if image.ndim == 2 and image.dtype == np.uint8:
        return "GREY8"
    if image.ndim == 2 and image.dtype == np.uint16:
        return "GREY16"
    if image.ndim == 3 and image.shape[2] == 3 and image.dtype == np.uint8:
        return "RGB24"
    raise ValueError("frame: expected uint8 or uint16 of the shape (height, width), or uint8 of "
                     f"(height, width, 3), not {image.dtype} of {image.shape}")


def _vectors(points: npt.ArrayLike, length: int) -> list[list[float]]:
    """Rows of numbers, as the module for boards takes them; what is not finite lies outside."""
    array = np.asarray(points)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"points: expected an array of real numbers, not of dtype {array.dtype}")
    if array.ndim != 2 or array.shape[1] != length:
        raise ValueError(f"points: expected an array of the shape (N, {length}), not {array.shape}")
    rows: list[list[float]] = array.tolist()
    return rows


def _rows(rows: Sequence[Any], length: int) -> npt.NDArray[np.float64]:
    none = (np.nan,) * length
    return np.array([none if row is None else row for row in rows],
                    dtype=np.float64).reshape(-1, length)
