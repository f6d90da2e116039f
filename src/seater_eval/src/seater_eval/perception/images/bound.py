"""The Cramer-Rao bound of an image of one marker: no unbiased estimator of its pose has a smaller covariance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_eval.perception.images.degraded_camera import DegradedCamera
from seater_eval.perception.images.render import Print, box_of, moved, white_fraction

Array = NDArray[np.float64]
QUANTISATION_VARIANCE = 1.0 / 12.0  # of rounding to whole grey levels
PSF_SHIFT = 0.25  # [px] for second derivatives


@dataclass(frozen=True)
class Unknowns:
    """What is estimated beside pose, offset and gain."""

    psf: int  # parameters of the PSF: 0: known; 1: one width; 3: its covariance
    slope: bool  # two slopes of the brightness


def unknowns(parameters: Mapping[str, Any]) -> Unknowns:
    """Those of the estimator with these perception parameters."""
    photometric = parameters["photometric"]
    psf = {"given": 0, "estimated": 1, "directed": 3}[photometric["blur"]]
    return Unknowns(psf, bool(photometric["illumination_slope"]))


def cramer_rao(print_: Print, camera: DegradedCamera, *, psf: int = 1, slope: bool = True, samples: int = 5) -> Array:
    """(6, 6) smallest covariance of the pose error (d, w) as in `moved`: x y z [m], rotation [rad].

    Unknown beside the pose: brightness offset and gain; as asked the PSF (see Unknowns) and two slopes of the
    brightness. The derivative of the image by the covariance of a Gaussian PSF is half its second derivative by the
    pixel. The Fisher information is J^T J / variance with J the derivative of the noise-free image, by central
    differences of the renderer (Kay, "Fundamentals of Statistical Signal Processing: Estimation Theory", 3.9); the
    variance is that of noise and rounding. The paper is taken as endless: where the sheet ends tells an estimator
    nothing that knows only the print.
    """
    box = box_of(print_, camera, 1.0, 1.0)
    black, white, _ = camera.levels
    contrast = white - black

    def expose(p: Print, c: DegradedCamera = camera, shift: tuple[float, float] = (0.0, 0.0)) -> Array:
        return white_fraction(p, c, box, samples=samples, endless_paper=True, shift=shift)

    z = float(print_.pose[2, 3])
    # [m], [rad]: an edge moves by about a tenth of a pixel
    lateral = 0.1 * z / camera.focal_length
    turn = 0.2 * z / (camera.focal_length * print_.size)
    steps = [lateral, lateral, 2.0 * lateral * z / print_.size, min(0.05, 4.0 * turn), min(0.05, 4.0 * turn), turn]
    columns = []
    for i, step in enumerate(steps):
        change = np.zeros(6)
        change[i] = step
        columns.append(contrast * (expose(moved(print_, change)) - expose(moved(print_, -change))) / (2.0 * step))
    middle = expose(print_)
    columns += [np.ones_like(middle), middle]
    if psf == 1:
        wide, narrow = (expose(print_, replace(camera, blur_sd=camera.blur_sd + d)) for d in (0.03, -0.03))
        columns.append(contrast * (wide - narrow) / 0.06)
    elif psf == 3:
        h = PSF_SHIFT
        along = [
            expose(print_, shift=s) + expose(print_, shift=(-s[0], -s[1])) - 2.0 * middle for s in ((h, 0.0), (0.0, h))
        ]
        corners = [expose(print_, shift=(a * h, b * h)) for a, b in ((1, 1), (-1, -1), (1, -1), (-1, 1))]
        across = 0.25 * (corners[0] + corners[1] - corners[2] - corners[3])
        columns += [contrast * second / h**2 for second in (*along, across)]
    if slope:
        grey = black + contrast * middle
        h, w = middle.shape
        columns += [grey * np.linspace(-1.0, 1.0, w)[None, :], grey * np.linspace(-1.0, 1.0, h)[:, None]]
    J = np.column_stack([c.ravel() for c in columns])
    scale = 1.0 / np.linalg.norm(J, axis=0)
    inverse = np.linalg.inv((J * scale).T @ (J * scale)) * np.outer(scale, scale)
    variance = camera.noise_sd**2 + QUANTISATION_VARIANCE
    return np.asarray(variance * inverse[:6, :6])
