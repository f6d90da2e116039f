"""The calibration as a file of camera_info, and as a picture."""

from __future__ import annotations

import io
from collections.abc import Sequence

import cv2
import matplotlib
import numpy as np
from numpy.typing import NDArray

from seater_tools.lens.find import View
from seater_tools.lens.fit import LensFit
from seater_tools.lens.result import LensResult

matplotlib.use("Agg")
from matplotlib import pyplot as plt

Array = NDArray[np.float64]


def camera_yaml(result: LensResult, name: str, note: str) -> str:
    """As camera_calibration writes it; the first lines say where it comes from and how certain it is."""
    fit = result.fit
    K, P = fit.camera.K, projection(fit)
    focal = 100 * float(np.max(result.sds[:2] / fit.unknowns[:2]))
    lines = [
        f"# {note}",
        f"# {len(fit.residuals)} views, corners off by {fit.rms:.3f} px (held out: {result.held_out:.3f})",
        f"# Focal length +- {focal:.3f} %, directions +- {result.direction_sd:.2f} px (1 sd, worst in the image)",
        f"image_width: {fit.size[0]}",
        f"image_height: {fit.size[1]}",
        f"camera_name: {name}",
        *_matrix("camera_matrix", K),
        f"distortion_model: {fit.model}",
        *_matrix("distortion_coefficients", fit.unknowns[None, 4:]),
        *_matrix("rectification_matrix", np.eye(3)),
        *_matrix("projection_matrix", P),
    ]
    return "\n".join(lines) + "\n"


def projection(fit: LensFit) -> Array:
    """(3, 4) P of the rectified image without black edges."""
    K, D = fit.camera.K, fit.unknowns[4:]
    if fit.model == "equidistant":
        new = cv2.fisheye.estimateNewCameraMatrixForUndistortRectify(K, D, fit.size, np.eye(3), balance=0.0)
    else:
        new, _ = cv2.getOptimalNewCameraMatrix(K, D, fit.size, 0.0)
    return np.column_stack([new, np.zeros(3)])


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


def _matrix(name: str, values: Array) -> list[str]:
    data = ", ".join(f"{value:.9g}" for value in np.ravel(values))
    return [f"{name}:", f"  rows: {values.shape[0]}", f"  cols: {values.shape[1]}", f"  data: [{data}]"]
