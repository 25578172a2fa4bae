"""OpenCV's calibrations of one set: opencv_peer.py JOB.json RESULT.json"""
import cv2
import numpy as np

import peer

cv2.setNumThreads(1)

# The other four combinations of these flags are the best of no published set.
TERMS = {5: 0, 8: cv2.CALIB_RATIONAL_MODEL, 12: cv2.CALIB_RATIONAL_MODEL | cv2.CALIB_THIN_PRISM_MODEL,
         14: cv2.CALIB_RATIONAL_MODEL | cv2.CALIB_THIN_PRISM_MODEL | cv2.CALIB_TILTED_MODEL}
CRITERIA = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-9)
GOOD_PX = 1  # better than that, no other start is tried


def pixels_of(views):
    return [v.pixels.astype(np.float32) for v in views]


def points_of(data, views):
    return [data.flat_board()[v.places].astype(np.float32) for v in views]


def guess(data):
    focal = data.focal_px
    width, height = data.image_size
    return np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])


def best_start(data, run):
    """The result (RMS first) of the library's own start, or where that is bad of a rough focal length too."""
    results = []
    for matrix in (None, guess(data)):
        try:
            results.append(run(matrix))
        except cv2.error:
            continue
        if results[-1][0] < GOOD_PX:
            break
    results = [r for r in results if np.isfinite(r[0])]
    if not results:
        raise peer.NotPossible("ends in an error from every start")
    return min(results, key=lambda r: r[0])


def perspective(matrix, terms):
    def project(points):
        pixels, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix, terms)
        return np.where(points[:, 2:] > 0, pixels.reshape(-1, 2), np.nan)
    return project


def writer(data, matrix, terms, is_fisheye=False):
    """What writes the camera as OpenCV's own samples do."""
    def write(path):
        file = cv2.FileStorage(path, cv2.FILE_STORAGE_WRITE)
        file.write("image_width", data.image_size[0])
        file.write("image_height", data.image_size[1])
        if is_fisheye:
            file.write("fisheye_model", 1)
        file.write("camera_matrix", matrix)
        file.write("distortion_coefficients", terms.reshape(-1, 1))
        file.release()
    return write


def calibrate(data, flags):
    def run(matrix):
        start = 0 if matrix is None else cv2.CALIB_USE_INTRINSIC_GUESS
        return cv2.calibrateCamera(points_of(data, data.train), pixels_of(data.train), data.image_size, matrix, None,
                                   flags=flags | start, criteria=CRITERIA)[:3]
    _, matrix, terms = best_start(data, run)
    return matrix, terms


def flat(data, number):
    matrix, terms = calibrate(data, TERMS[number])
    return peer.Camera(perspective(matrix, terms), data.flat_board(), 4 + number, writer(data, matrix, terms))


def released(data, number):
    """calibrateCameraRO, from the views that show the whole board: it takes no others. The fixed corner is the
    one its documentation names; any other is the same gauge and gives the same result within 0.0001 px."""
    views = [v for v in data.train if len(v.places) == len(data.flat_board())]
    if len(views) < len(data.train) / 2:
        raise peer.NotPossible(f"takes only views that show the whole board: {len(views)} of {len(data.train)}")

    def run(matrix):
        start = 0 if matrix is None else cv2.CALIB_USE_INTRINSIC_GUESS
        out = cv2.calibrateCameraRO(points_of(data, views), pixels_of(views), data.image_size, data.columns - 1,
                                    matrix, None, flags=TERMS[number] | start, criteria=CRITERIA)
        return out[0], out[1], out[2], out[5]
    _, matrix, terms, points = best_start(data, run)
    return peer.Camera(perspective(matrix, terms), points.reshape(-1, 3), 4 + number, writer(data, matrix, terms))


# ---- cv::fisheye -------------------------------------------------------------

def equidistant(matrix, terms):
    """cv::fisheye's model, beyond 90 degrees from the axis too."""
    def project(points):
        r = np.hypot(points[:, 0], points[:, 1])
        angle = np.arctan2(r, points[:, 2])
        bent = angle * (1 + sum(k * angle ** (2 * i + 2) for i, k in enumerate(terms.ravel())))
        ratio = bent / np.maximum(r, 1e-12)
        x, y = points[:, 0] * ratio, points[:, 1] * ratio
        return np.stack([matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2],
                         matrix[1, 1] * y + matrix[1, 2]], axis=1)
    return project


def fisheye_flag(name):
    """OpenCV 5 has these flags among all others."""
    return getattr(cv2.fisheye, "CALIB_" + name, None) or getattr(cv2, "CALIB_" + name)


def fisheye(data, has_skew):
    """From two starts, with and without its check of each view, and then without the views that it
    calls ill-conditioned. Of these, what leaves out the fewest views, and then has the least RMS."""
    points = [p.reshape(1, -1, 3).astype(np.float64) for p in points_of(data, data.train)]  # OpenCV 5 takes rows only
    pixels = [p.reshape(1, -1, 2).astype(np.float64) for p in pixels_of(data.train)]
    criteria = (CRITERIA[0], 200, 1e-9)

    def run(matrix, flags):
        kept = list(range(len(points)))
        while len(kept) > len(points) // 2:
            try:
                return (-len(kept),) + cv2.fisheye.calibrate(
                    [points[i] for i in kept], [pixels[i] for i in kept], data.image_size,
                    None if matrix is None else matrix.copy(), np.zeros((4, 1)), flags=flags,
                    criteria=criteria)[:3]
            except cv2.error as error:
                words = str(error).split("input array ")
                if len(words) < 2:
                    raise
                del kept[int(words[1].split()[0].rstrip(")"))]
        raise cv2.error("too many views are left out")

    base = fisheye_flag("RECOMPUTE_EXTRINSIC") | (0 if has_skew else fisheye_flag("FIX_SKEW"))
    results = []
    for check in (0, fisheye_flag("CHECK_COND")):
        for matrix in (None, guess(data)):
            start = 0 if matrix is None else fisheye_flag("USE_INTRINSIC_GUESS")
            try:
                results.append(run(matrix, base | check | start))
            except cv2.error:
                pass
    results = [r for r in results if np.isfinite(r[1]) and np.all(np.isfinite(r[3]))]
    if not results:
        raise peer.NotPossible("ends in an error from every start")
    _, _, matrix, terms = min(results, key=lambda r: r[:2])
    return peer.Camera(equidistant(matrix, terms), data.flat_board(), 8 + has_skew, writer(data, matrix, terms, True))


def rows_of(data):
    version = {"peer": "OpenCV", "version": cv2.__version__}
    terms = (5, 12) if data.few else tuple(TERMS)
    if data.both_ways:
        terms = (5, 8)  # which raygrid takes as they are
    for number in terms:
        yield peer.row_of(data, {**version, "model": f"calibrateCamera, {number} terms", "target": "nominal"},
                          lambda n=number: flat(data, n))
    for number in terms:
        yield peer.row_of(data, {**version, "model": f"calibrateCameraRO, {number} terms",
                                 "target": "estimated"}, lambda n=number: released(data, n))
    skews = (False,) if data.both_ways else () if data.few else (False, True)
    for has_skew in skews:
        yield peer.row_of(data, {**version, "model": "fisheye::calibrate" + ", skew" * has_skew, "target": "nominal"},
                          lambda s=has_skew: fisheye(data, s))


if __name__ == "__main__":
    peer.main(rows_of)
