#!/usr/bin/env python3
"""README.md's figures of raygrid's own corners, as a picture: held-out errors of OpenCV's photographs.

    tools/fetch_photographs build/photographs
    PYTHONPATH=build/host/python offline/python/examples/photographs_figure.py \\
        build/photographs/left figure.png

Ten photographs of the left camera calibrate, and three are held out. The version at hand measures
their errors anew, so the last digit may differ from README.md's. Wants python3-matplotlib.
"""
# %% Which photographs calibrate
import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import raygrid

BOARD = "chessboard:9x6:25mm"
HELD_OUT = ["left04.jpg", "left08.jpg", "left13.jpg"]
if len(sys.argv) != 3:
    sys.exit(__doc__)
paths = sorted(Path(sys.argv[1]).glob("*.jpg"))

# %% Find the corners
features = [raygrid.detect(path, BOARD) for path in paths]
print(f"{sum(map(len, features))} corners in {len(features)} photographs")

# %% Calibrate: two models, with the board as it is drawn and with its shape found
results = {}
for model in ("opencv", "central-generic"):
    for flat in (True, False):
        name = f"{model}, {'board as drawn' if flat else 'its shape found'}"
        results[name] = raygrid.calibrate(
            features, BOARD, model=model, fix_target_geometry=flat, hold_out=HELD_OUT,
            progress=lambda stage, done, left: print(f"\r{100 * done:3.0f} % {stage:<24}", end="",
                                                     file=sys.stderr))
        errors = np.hypot(*results[name].held_out()[1].T)
        print(f"\r{name}: held-out median {np.median(errors):.3f} px, {len(errors)} corners")

# %% Draw the errors, what the camera knows, and a photograph before and after
figure, axes = plt.subplots(2, 2, figsize=(11, 8), layout="constrained")
for name, result in results.items():
    errors = np.sort(np.hypot(*result.held_out()[1].T))
    axes[0, 0].plot(errors, np.arange(1, len(errors) + 1) / len(errors),
                    label=f"{name}: {np.median(errors):.3f} px")
axes[0, 0].axhline(0.5, color="0.8", linewidth=1, zorder=0)
axes[0, 0].set(xlim=(0, 0.4), ylim=(0, 1), xlabel="held-out error, px", ylabel="part of the corners",
               title="Held-out corners, and their median")
axes[0, 0].legend(loc="lower right", fontsize=8)

camera = results["central-generic, its shape found"].camera
width, height = camera.size
pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
edges = (-0.5, width - 0.5, height - 0.5, -0.5)
known = axes[0, 1].imshow(camera.uncertainty(pixels), extent=edges, vmin=0, vmax=0.3)
axes[0, 1].contour(camera.is_valid(pixels), levels=[0.5], colors="white", linewidths=1)
axes[0, 1].set_title("Predicted uncertainty, px; valid region inside the line")
figure.colorbar(known, ax=axes[0, 1], shrink=0.8)

photograph = plt.imread(paths[0])
blob = raygrid.Blob(camera.pack([camera.view(alpha=0)]))
for place, image, title in ((axes[1, 0], photograph, paths[0].name),
                            (axes[1, 1], blob.undistort(photograph), "undistorted by the runtime")):
    place.imshow(image, cmap="gray", extent=edges)
    place.set_title(title)
figure.savefig(sys.argv[2], dpi=100)
print(sys.argv[2])
