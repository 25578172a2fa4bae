"""Undistorts one frame again and again, in memory:

    frame_loop.py opencv|raygrid FOLDER FORMAT FRAMES THREADS OUT [fixed|float]

FOLDER is one that frame_paths.py made. The last result is written to OUT.
"""
import os
import sys


def opencv(folder, name, frames, threads, kind):
    import cv2  # of whichever Python runs this
    import numpy as np

    cv2.setNumThreads(threads)
    with np.load(os.path.join(folder, "maps.npz")) as maps:
        luma = np.dstack([maps["map1"], maps["map2"]])
    height, width = luma.shape[:2]
    # A pixel of the chroma lies in the middle of four.
    chroma = ((luma[::2, ::2] + luma[1::2, ::2] + luma[::2, 1::2] + luma[1::2, 1::2]) / 4 - 0.5) / 2

    def prepared(positions):
        return cv2.convertMaps(positions, None, cv2.CV_16SC2) if kind == "fixed" else (positions, None)

    with open(os.path.join(folder, name + ".raw"), "rb") as file:
        data = np.frombuffer(file.read(), np.uint8)
    if name == "NV12":
        planes = [(data[:width * height].reshape(height, width), prepared(luma)),
                  (data[width * height:].reshape(height // 2, width // 2, 2), prepared(chroma))]
    else:
        planes = [(data.reshape((height, width, 3) if name == "RGB" else (height, width)), prepared(luma))]
    results = [np.empty_like(plane) for plane, _ in planes]
    for _ in range(frames):
        for (plane, maps), result in zip(planes, results):
            cv2.remap(plane, maps[0], maps[1], cv2.INTER_LINEAR, dst=result)
    return b"".join(result.tobytes() for result in results)


def raygrid(folder, name, frames, *_):
    import raygrid as runtime

    camera = runtime.Camera(os.path.join(folder, "view.raygrid"))
    with open(os.path.join(folder, name + ".raw"), "rb") as file:
        frame = file.read()
    result = bytearray(len(frame))
    pixel_format = {"GREY": "GREY8", "RGB": "RGB24"}.get(name, name)
    for _ in range(frames):
        camera.undistort(frame, pixel_format, out=result)
    return result


def main(program, folder, name, frames, threads, out, kind="fixed"):
    result = {"opencv": opencv, "raygrid": raygrid}[program](folder, name, int(frames), int(threads), kind)
    with open(out, "wb") as file:
        file.write(result)


if __name__ == "__main__":
    main(*sys.argv[1:])
