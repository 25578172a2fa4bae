"""mrcal's calibrations of one set, with its outlier rejection, regularisation and warped board, in the
passes of its command mrcal-calibrate-cameras: mrcal_peer.py JOB.json RESULT.json"""
import importlib.metadata
import subprocess

import mrcal
import numpy as np

import peer

# Poses of cameras and boards, as mrcal 2.5 names them and as earlier ones do.
CAMERAS, FRAMES = (("rt_cam_ref", "rt_ref_frame") if "rt_ref_frame" in mrcal.optimize.__doc__ else
                   ("extrinsics_rt_fromref", "frames_rt_toref"))


def version():
    try:
        return importlib.metadata.version("mrcal")
    except importlib.metadata.PackageNotFoundError:
        text = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", "python3-mrcal"],
                              capture_output=True, text=True, check=True).stdout
        return text.split("-")[0]


def observations(data):
    """Pixels and weights of all views, row by row; corners that are not seen have a negative weight."""
    found = np.full((len(data.train), data.rows * data.columns, 3), -1.0)
    for view, corners in zip(data.train, found):
        corners[view.places, :2] = view.pixels
        corners[view.places, 2] = 1
    return found.reshape(len(data.train), data.rows, data.columns, 3)


def start_poses(data):
    """Poses of the boards in the camera's frame, from those that all programs localise from. mrcal's own
    start fails on some sets."""
    return np.array([np.concatenate([mrcal.r_from_R(rotation), translation])
                     for rotation, translation in (data.starts[v.image] for v in data.train)])


class Problem:
    """Arrays that mrcal.optimize() works on in place."""

    def __init__(self, data):
        width, height = data.image_size
        self.values = np.array([[data.focal_px, data.focal_px, (width - 1) / 2, (height - 1) / 2]])
        self.frames = start_poses(data)
        self.observations = observations(data)
        self.warp = None
        self.sizes = np.array([data.image_size], dtype=np.int32)
        self.square_m = data.square_m
        count = len(data.train)
        self.indices = np.stack([np.arange(count), np.zeros(count), -np.ones(count)], axis=1).astype(np.int32)

    def optimize(self, lens, core, distortions, is_final=False):
        mrcal.optimize(intrinsics=self.values, **{CAMERAS: np.zeros((0, 6)), FRAMES: self.frames}, points=None,
                       observations_board=self.observations,
                       indices_frame_camintrinsics_camextrinsics=self.indices, observations_point=None,
                       indices_point_camintrinsics_camextrinsics=None, lensmodel=lens, imagersizes=self.sizes,
                       calobject_warp=self.warp, do_optimize_intrinsics_core=core,
                       do_optimize_intrinsics_distortions=distortions,
                       do_optimize_calobject_warp=self.warp is not None,
                       calibration_object_spacing=self.square_m, do_apply_outlier_rejection=is_final,
                       do_apply_regularization=distortions, verbose=False)

    def expand(self, lens):
        """More parameters, which must not be quite zero."""
        count = mrcal.lensmodel_num_params(lens) - self.values.shape[1]
        more = (np.random.default_rng(0).random((1, count)) - 0.5) * 2e-6
        if "OPENCV" in lens:
            more[:, 5:8] *= 1e-3
        self.values = np.concatenate([self.values, more], axis=1)


def calibrate(data, lens, is_flat):
    problem = Problem(data)
    problem.optimize("LENSMODEL_STEREOGRAPHIC", core=False, distortions=False)
    problem.optimize("LENSMODEL_STEREOGRAPHIC", core=True, distortions=False)
    problem.expand(lens)
    core = "SPLINED" not in lens  # which say the same with and without
    problem.optimize(lens, core, distortions=True)
    problem.warp = None if is_flat else np.zeros(2)
    problem.optimize(lens, core, distortions=True, is_final=True)
    board = mrcal.ref_calibration_object(data.columns, data.rows, data.square_m, calobject_warp=problem.warp)
    values = problem.values[0]

    def project(points):
        return mrcal.project(np.ascontiguousarray(points), lens, values)

    def write(path):
        mrcal.cameramodel(intrinsics=(lens, values), imagersize=problem.sizes[0]).write(path)
    return peer.Camera(project, np.ascontiguousarray(board.reshape(-1, 3)), len(values), write, ".cameramodel")


def lenses(data):
    """Splined ones of about 80, 120 and 40 px between control points, and its usual ones."""
    if data.few and not data.both_ways:
        return ["LENSMODEL_OPENCV8"]
    names = []
    width, height = data.image_size
    for cell_px in (80,) if data.both_ways else (80, 120, 40):
        columns, rows = round(width / cell_px) + 2, round(height / cell_px) + 2
        names.append(f"LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx={columns}_Ny={rows}"
                     f"_fov_x_deg={data.fov_deg}")
    return names + ["LENSMODEL_OPENCV8"] + ["LENSMODEL_OPENCV12"] * (not data.both_ways)


def short(lens):
    words = lens.replace("LENSMODEL_", "").split("_")
    if words[0] != "SPLINED":
        return words[0]
    size = {w.split("=")[0]: w.split("=")[1] for w in words if "=" in w}
    return f"splined {size['Nx']} × {size['Ny']}"


def rows_of(data):
    for lens in lenses(data):
        for is_flat in (False, True):
            label = {"peer": "mrcal", "version": version(), "model": short(lens),
                     "target": "nominal" if is_flat else "warp"}
            yield peer.row_of(data, label, lambda m=lens, f=is_flat: calibrate(data, m, f))


if __name__ == "__main__":
    peer.main(rows_of)
