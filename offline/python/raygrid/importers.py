"""Exchange with other tools: cameras and rigs of OpenCV, ROS, Kalibr, COLMAP, mrcal and others."""
from __future__ import annotations

import os
from typing import Any, NamedTuple, Optional

from . import _raygrid
from ._rig import Rig, _rig_of, _rows


class Format(NamedTuple):
    """A file format, of formats()."""
    #: Name of the format, as load() and save() take it.
    name: str
    #: What its files contain.
    holds: str
    #: Names of its camera models, as load() and save() take them.
    models: list[str]
    #: Whether load() reads it.
    is_read: bool
    #: Whether save() writes it.
    is_written: bool
    #: Whether a file can contain a rig.
    holds_rigs: bool


def formats() -> list[Format]:
    """List all formats, in the order in which files are recognized."""
    return [Format(*row) for row in _raygrid.list_formats()]


def load(*paths: str | os.PathLike[str], format: str = "", model: str = "",
         size: Optional[tuple[int, int]] = None) -> _raygrid.Camera | Rig:
    """Load the camera in a file, or the rig in one file or in those of its cameras.

    Camera models are converted exactly. Warns (UserWarning) of contents that are ignored.

    Args:
        paths: the files.
        format: name of the format; default: recognized from the contents.
        model: name of the camera model, if the file does not state it.
        size: (width, height) of the images in pixels, if the file does not state it.

    Returns:
        A Camera; for several cameras with poses a Rig.

    Raises:
        raygrid.Error: a file cannot be read, is malformed or incomplete.
        ValueError: there are several cameras without poses; see load_all().
    """
    cameras = _raygrid.import_cameras(list(paths), format, model, size)
    if len(cameras) == 1:
        return cameras[0][1]
    if any(pose is None for _, _, pose in cameras):
        raise ValueError(f"{os.fspath(paths[0])}: the cameras have no poses relative to each other; "
                         "use load_all() to get them by name")
    return _rig_of(cameras)


def load_all(*paths: str | os.PathLike[str], format: str = "", model: str = "",
             size: Optional[tuple[int, int]] = None) -> dict[str, _raygrid.Camera]:
    """Load all cameras in files, by name; poses are ignored. Arguments and errors are those of
    load()."""
    cameras = _raygrid.import_cameras(list(paths), format, model, size)
    return {name: camera for name, camera, _ in cameras}


def save(cameras: _raygrid.Camera | Rig, path: str | os.PathLike[str], format: str,
         model: str = "", max_fit_error: Optional[float] = None) -> list[dict[str, Any]]:
    """Write a camera or a rig as another program's file, completely or not at all.

    Camera models that the format has are converted exactly; otherwise the nearest one is fitted.

    Args:
        cameras: a Camera, or a Rig if the format holds_rigs.
        path: the file to write.
        format: name of the format.
        model: name of the camera model; default: the one that fits best.
        max_fit_error: largest fit error to accept, in pixels; default: any.

    Returns:
        A dict for each camera of model, exact and, if it was fitted, the fit error rms_px and
        max_px in pixels, and the rotation lens_from_camera (3, 3) from camera axes to those of the
        file.

    Raises:
        raygrid.Error: max_fit_error is exceeded (code 6), the format cannot hold the cameras, or
            the file cannot be written.
    """
    return _raygrid.export_cameras(_rows(cameras), path, format, model, max_fit_error)
