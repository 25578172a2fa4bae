"""Times cv::remap of this Python's OpenCV on what remap_bench wrote: remap_rival.py FOLDER RESULT.json
views.json there has the frames' size and the views' names, which those of the maps begin with."""
import os
import statistics
import sys
import time

import cv2
import numpy as np

import datasets

cv2.setNumThreads(1)


def seconds(work):
    """Median of runs, each right after another, as remap_bench has it."""
    times, begin = [], time.thread_time()
    while len(times) < 7 or (time.thread_time() - begin < 0.4 and len(times) < 400):
        work()
        start = time.thread_time()
        work()
        times.append(time.thread_time() - start)
    return statistics.median(times)


def load(folder, name, rows, columns, channels, kind):
    """A raw file of remap_bench's; one channel has no axis."""
    values = np.fromfile(os.path.join(folder, name), kind)
    return values.reshape((rows, columns) if channels == 1 else (rows, columns, channels))


class Maps:
    """The source positions of one plane's pixels: as floats, and as OpenCV's fixed-point numbers."""

    def __init__(self, folder, prefix, rows, columns):
        self.positions = load(folder, prefix + ".positions", rows, columns, 2, np.float32)
        self.fixed = cv2.convertMaps(self.positions, None, cv2.CV_16SC2)
        self.nearest = cv2.convertMaps(self.positions, None, cv2.CV_16SC2, nninterpolation=True)[0]

    def bilinear(self, image, output, is_fixed):
        first, second = self.fixed if is_fixed else (self.positions, None)
        cv2.remap(image, first, second, cv2.INTER_LINEAR, dst=output)


def speeds(folder, view, rows, columns):
    luma, chroma = Maps(folder, view + ".luma", rows, columns), Maps(folder, view + ".chroma", rows // 2, columns // 2)
    grey = load(folder, "grey", rows, columns, 1, np.uint8)
    pairs = load(folder, "pairs", rows // 2, columns // 2, 2, np.uint8)
    rgb = load(folder, "rgb", rows, columns, 3, np.uint8)
    outputs = [image.copy() for image in (grey, pairs, rgb)]

    def faster(work):
        return min(seconds(lambda: work(True)), seconds(lambda: work(False)))

    def nv12(is_fixed):
        luma.bilinear(grey, outputs[0], is_fixed)
        chroma.bilinear(pairs, outputs[1], is_fixed)
    times = {"GREY": faster(lambda f: luma.bilinear(grey, outputs[0], f)),
             "GREY nearest": seconds(lambda: cv2.remap(grey, luma.nearest, None, cv2.INTER_NEAREST, dst=outputs[0])),
             "NV12": faster(nv12), "RGB24": faster(lambda f: luma.bilinear(rgb, outputs[2], f))}
    program = "cv::remap " + cv2.__version__
    return {name: {program: rows * columns / 1e6 / s} for name, s in times.items()}


def main(folder, path):
    found = datasets.read_json(os.path.join(folder, "views.json"))
    datasets.write_json(path, {view: speeds(folder, view, found["rows"], found["columns"])
                               for view in found["views"]})


if __name__ == "__main__":
    main(*sys.argv[1:])
