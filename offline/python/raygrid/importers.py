"""Other programs' files: cameras and rigs of OpenCV, ROS, Kalibr, COLMAP, mrcal and others."""
from __future__ import annotations

import os
from typing import Any, NamedTuple, Optional

from . import _raygrid
from ._rig import Rig, _rig_of, _rows


class Format(NamedTuple):
    """A format: its name, what it holds, the names of its models, and what can be done."""
    name: str
    holds: str
    models: list[str]
    is_read: bool
    is_written: bool
    holds_rigs: bool


def formats() -> list[Format]:
    """All formats, in the order in which files are recognized."""
    return [Format(*row) for row in _raygrid.list_formats()]


def load(*paths: str | os.PathLike[str], format: str = "", model: str = "",
         size: Optional[tuple[int, int]] = None) -> _raygrid.Camera | Rig:
    """The camera in a file, or the rig in the files of its cameras, exactly.

    A file tells its format by what is in it. format, model and size (width, height) say what it
    does not tell. Warns of what is not taken as it stands.
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
    """The cameras in files, by name, with or without poses."""
    cameras = _raygrid.import_cameras(list(paths), format, model, size)
    return {name: camera for name, camera, _ in cameras}


def save(cameras: _raygrid.Camera | Rig, path: str | os.PathLike[str], format: str,
         model: str = "", max_fit_error: Optional[float] = None) -> list[dict[str, Any]]:
    """Writes a camera or a rig as another program's file: exactly, or as the nearest lens.

    Returns what the lens of each camera leaves: model, exact, and of one that is not exact rms_px,
    max_px and lens_from_camera (3, 3). Above max_fit_error, in pixels, nothing is written.
    """
    return _raygrid.export_cameras(_rows(cameras), path, format, model, max_fit_error)
