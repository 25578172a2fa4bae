"""Rigs: several cameras and their relative poses."""
from __future__ import annotations

import os
from typing import Mapping

import numpy as np
import numpy.typing as npt

from . import _raygrid


class Rig:
    """A rig: cameras by name and their poses.

    Attributes:
        cameras: dict of Camera by name.
        camera_from_rig: dict of (4, 4) by name: homogeneous transformation from the rig's frame
            to camera axes, in metres; read-only.
        covariances: dict of (6, 6) by (first, second): covariance of the relative pose
            second_from_first, if known, as the rotation vector r (rad) and the translation d (m)
            of exp(r) R, t + d.

    Args:
        cameras: the cameras by name.
        camera_from_rig: the pose of each.
        covariances: of some or all pairs.

    Raises:
        ValueError: the names differ, or a pose is not a finite (4, 4) matrix.
    """

    def __init__(self, cameras: Mapping[str, _raygrid.Camera],
                 camera_from_rig: Mapping[str, npt.ArrayLike],
                 covariances: Mapping[tuple[str, str], npt.ArrayLike] | None = None) -> None:
        if set(cameras) != set(camera_from_rig):
            raise ValueError("camera_from_rig: expected exactly one pose per camera")
        self.cameras = dict(cameras)
        self.camera_from_rig = {name: _pose(name, camera_from_rig[name]) for name in cameras}
        self.covariances = {pair: np.array(matrix, dtype=np.float64)
                            for pair, matrix in (covariances or {}).items()}

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Rig:
        """Load a rig.yaml and the camera files that it names.

        Raises:
            Error: a file cannot be read or is malformed.
        """
        rig = _rig_of(_raygrid.read_rig(path))
        rig.covariances = dict(_raygrid.read_rig_covariances(path))
        return rig

    @staticmethod
    def of(calibration: _raygrid.Calibration) -> Rig:
        """The rig of a calibration, in the frame of its first camera."""
        return Rig(calibration.cameras, calibration.camera_from_rig,
                   calibration.relative_pose_covariances)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a rig.yaml, and beside it NAME/camera.yaml of each camera: all files or none.

        Raises:
            Error: a file cannot be written, or covariances are not those of pairs of the rig.
            ValueError: a name has other characters than letters, digits, '-' and '_', or a pose
                is not a rotation and a translation.
        """
        _raygrid.write_rig(path, _rows(self), self.covariances)

    def project(self, points: npt.ArrayLike) -> dict[str, npt.NDArray[np.float64]]:
        """Project points (..., 3) in the rig's frame, in metres, into all cameras.

        Returns:
            Dict of pixels (..., 2) by camera name; NaN for points that are not visible.
        """
        given = np.asarray(points, dtype=np.float64)
        return {name: camera.project(given @ self.camera_from_rig[name][:3, :3].T
                                     + self.camera_from_rig[name][:3, 3])
                for name, camera in self.cameras.items()}

    def __repr__(self) -> str:
        return f"<raygrid.Rig of {', '.join(self.cameras)}>"


def _pose(name: str, given: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """A copy that cannot be written to."""
    pose = np.array(given, dtype=np.float64)
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise ValueError(f"camera_from_rig of '{name}': expected a finite matrix of the shape (4, 4)")
    pose.setflags(write=False)
    return pose


def _rows(cameras: Rig | _raygrid.Camera) -> list[_raygrid._NamedCamera]:
    if isinstance(cameras, Rig):
        return [(name, camera, cameras.camera_from_rig[name])
                for name, camera in cameras.cameras.items()]
    return [(cameras.name, cameras, None)]


def _rig_of(rows: list[_raygrid._NamedCamera]) -> Rig:
    return Rig({name: camera for name, camera, _ in rows},
               {name: np.eye(4) if pose is None else pose for name, _, pose in rows})
