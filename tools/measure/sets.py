"""The sets that are measured: of the shared folder, and of OpenCV's photographs."""
import os

import datasets

# Folder, what it is, size, for mrcal a rough focal length and the width of its splines' field of view, and
# whether a few models do: these are the photographs that others calibrate from.
SHARED = (
    ("photo_carnd_wide", "photo_carnd_wide: GoPro, photographs of a course by Udacity", (1280, 960), 566, 130, False),
    ("photo_carnd_cal", "photo_carnd_cal: dash camera, photographs of a course by Udacity", (1280, 720), 1175, 65,
     False),
    ("photo_camodocal", "photo_camodocal: research camera, the example of camodocal", (1280, 960), 384, 190, False),
    ("photo_vins", "photo_vins: research camera, the example of VINS-Fusion", (752, 480), 470, 92, False),
    ("stereo_left", "stereo_left: OpenCV's photographs, left camera, with published corners", (640, 480), 535, 70,
     True),
    ("stereo_right", "stereo_right: OpenCV's photographs, right camera, with published corners", (640, 480), 535, 70,
     True),
    ("picamera_chessboard", "picamera_chessboard: Raspberry Pi camera", (640, 480), 535, 70, False),
    ("webcam_charuco", "webcam_charuco: webcam, ChArUco corners interpolated between markers", (1280, 720), 1140, 65,
     False),
    ("fisheye_190", "fisheye_190: fisheye of 190°, deltille board", (1280, 800), 356, 200, False),
)
# Name, what finds it, which is raygrid or a KIND of corner_finders.py.
CORNERS = (
    ("cornerSubPix, window of 11 px", "sub-pix-5"),
    ("cornerSubPix, window of 23 px", "sub-pix-11"),
    ("findChessboardCornersSB", "sector"),
    ("raygrid detect", "raygrid"),
)
REFERENCE_CORNERS = "sub-pix-5"  # those of which all models are measured
HELD_OUT = ("04", "08", "13")  # numbers in the photographs' names, as in tools/quickstart
SIDES = ("left", "right")
PHOTOGRAPHS_PATTERN = """raygrid_pattern: 1
boards:
  - {id: 0, kind: chessboard, columns: 9, rows: 6, square_m: 0.025}
"""


def make_job(work, name, title, folder, size, focal_px=None, fov_deg=None, few=False):
    """Without a focal length, that of the camera that poses start from."""
    job = {"name": name, "title": title, "folder": folder, "work": os.path.join(work, name),
           "image_size": size, "focal_px": focal_px, "fov_deg": fov_deg, "few": few}
    os.makedirs(job["work"], exist_ok=True)
    return job


def shared_jobs(data, work):
    """Jobs of the sets that are there, and names of those that are not."""
    jobs, absent = [], []
    for name, title, size, focal_px, fov_deg, few in SHARED:
        folder = os.path.join(data, name)
        if os.path.exists(os.path.join(folder, "split.csv")):
            jobs.append(make_job(work, name, title, folder, size, focal_px, fov_deg, few))
        else:
            absent.append(name)
    return jobs, absent


def photograph_jobs(work):
    """One for each camera and kind of corners."""
    jobs = []
    for side in SIDES:
        for corners, kind in CORNERS:
            name = f"{side}-{kind}"
            job = make_job(work, name, f"OpenCV's photographs, {side} camera, {corners}",
                           os.path.join(work, name), (640, 480), 535, 70, kind != REFERENCE_CORNERS)
            jobs.append({**job, "side": side, "corners": corners, "kind": kind})
    return jobs


def write_photograph_folder(job, photographs):
    """pattern.yaml and split.csv beside the corners."""
    with open(os.path.join(job["folder"], "pattern.yaml"), "w", encoding="utf-8") as file:
        file.write(PHOTOGRAPHS_PATTERN)
    with open(os.path.join(job["folder"], "split.csv"), "w", encoding="utf-8") as file:
        file.write("image,part\n")
        for name in sorted(os.listdir(os.path.join(photographs, job["side"]))):
            part = "test" if any(number in name for number in HELD_OUT) else "train"
            file.write(f"{name},{part}\n")


def save(job):
    path = os.path.join(job["work"], "job.json")
    datasets.write_json(path, job)
    return path
