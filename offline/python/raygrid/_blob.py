"""The runtime of processor boards, with numpy in and out."""
from __future__ import annotations

import os
from typing import Any, Optional, Sequence

import numpy as np
import numpy.typing as npt

from . import _runtime

BlobError = _runtime.Error


class Blob(_runtime.Camera):
    """A blob: the path of a file, or its bytes, evaluated by the runtime's own code in fixed point.

    The methods are those of the module for boards. They take arrays, and answer arrays, with NaN
    for None. Its first remap table is in use, if it has any. Refusals raise BlobError.
    """

    def __init__(self, blob: str | os.PathLike[str] | bytes | bytearray | memoryview) -> None:
        super().__init__(blob)

    def unproject(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Unit directions (N, 3) of pixels (N, 2); NaN outside the calibrated area."""
        return _rows(super().unproject(_vectors(points, 2)), 3)

    def rays(self, points: npt.ArrayLike) -> tuple[npt.NDArray[np.float64],
                                                   npt.NDArray[np.float64]]:
        """(origins, directions) of pixels (N, 2), both (N, 3), in metres."""
        if self.is_central:
            directions = self.unproject(points)
            return np.where(np.isnan(directions), np.nan, 0.0), directions
        lines = super().unproject_lines(_vectors(points, 2))
        return (_rows([line and line[0] for line in lines], 3),
                _rows([line and line[1] for line in lines], 3))

    def project(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Pixels (N, 2) of points (N, 3), in metres; NaN where nothing is seen."""
        return _rows(super().project(_vectors(points, 3)), 2)

    def is_valid(self, points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Whether the camera may be trusted at pixels (N, 2): (N,)."""
        return np.array(super().is_valid(_vectors(points, 2)), dtype=bool)

    def uncertainty(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Standard deviations (N,), in pixels, at pixels (N, 2); NaN where the blob does not say."""
        values = super().uncertainty(_vectors(points, 2))
        return np.array([np.nan if value is None else value for value in values])

    def undistort_points(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Places (N, 2) of pixels (N, 2) in the undistorted image; NaN for those without any."""
        return _rows(super().undistort_points(_vectors(points, 2)), 2)

    def undistort(self, frame: Any, pixel_format: Optional[str] = None, border: str = "value",
                  border_values: Sequence[int] = (0, 0, 0, 0),
                  sampling: str = "bilinear", out: Any = None) -> Any:
        """The undistorted frame.

        An array of uint8 or uint16, (height, width) or of uint8 (height, width, 3), becomes an array
        of its kind. With pixel_format, one of those of the module for boards, bytes become bytes.
        With out, memory of the result's size other than the frame, that is filled and returned.
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
