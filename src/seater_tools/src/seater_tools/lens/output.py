"""The calibration as a file of camera_info, and as a picture."""

from __future__ import annotations

import io
from collections.abc import Sequence

import cv2
import matplotlib
import numpy as np
from numpy.typing import NDArray

from seater_tools.lens.file import calibration_text, with_projection
from seater_tools.lens.find import View
from seater_tools.lens.result import LensResult

matplotlib.use("Agg")
from matplotlib import pyplot as plt

Array = NDArray[np.float64]


def camera_yaml(result: LensResult, name: str, note: str) -> str:
    """The first lines say where it comes from and how certain it is."""
    fit = result.fit
    focal = 100 * float(np.max(result.sds[:2] / fit.unknowns[:2]))
    comments = [
        note,
        f"{len(fit.residuals)} views, corners off by {fit.rms:.3f} px (held out: {result.held_out:.3f})",
        f"Focal length +- {focal:.3f} %, directions +- {result.direction_sd:.2f} px (1 sd, worst in the image)",
    ]
    return calibration_text(with_projection(fit.camera), name, comments)


def draw(result: LensResult, views: Sequence[View]) -> bytes:
    """A PNG: which parts of the image the board has been in, and what is left over."""
    fit = result.fit
    figure, (seen, left) = plt.subplots(1, 2, figsize=(13.0, 5.0), constrained_layout=True)
    for view in views:
        hull = cv2.convexHull(view.corners.astype(np.float32)).reshape(-1, 2)
        seen.fill(*hull.T, color="C0", alpha=0.06)
        seen.plot(*view.corners.T, "k.", markersize=1.5)
    seen.set(xlim=(0, fit.size[0]), ylim=(fit.size[1], 0), aspect="equal", xlabel="x [px]", ylabel="y [px]")
    seen.set_title(f"{len(views)} views of the board")
    off = np.concatenate(fit.residuals)
    left.plot(*off.T, ".", markersize=2.0, alpha=0.5)
    reach = 1.1 * float(np.percentile(np.abs(off), 99.5))
    left.set(xlim=(-reach, reach), ylim=(reach, -reach), aspect="equal", xlabel="x [px]", ylabel="y [px]")
    left.set_title(f"corners less model: {fit.rms:.3f} px; held out {result.held_out:.3f} px")
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    plt.close(figure)
    return buffer.getvalue()
