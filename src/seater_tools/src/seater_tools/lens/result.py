"""Whether a lens is constrained by its views, in numbers and words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_tools.board.board import Board
from seater_tools.lens.coverage import missing_views
from seater_tools.lens.find import View
from seater_tools.lens.fit import LensFit, fit_lens, held_out_rms
from seater_tools.lens.model import LensError, names, project

Array = NDArray[np.float64]

FOCAL_LIMIT = 0.002  # largest relative standard deviation of the focal length: 2 mm at 1 m
DIRECTION_LIMIT = 1.0  # [px] largest standard deviation of where a direction is seen, anywhere in the image
HELD_OUT = (1.3, 0.05)  # views that were held out may be so many times, and so many px, worse than those fitted
WORST_VIEW = 3.0  # times the rms of all: a view that was blurred, or of a board that was bent
GRID = 9  # points across the image where the standard deviation is taken
STEP = 1e-6


@dataclass(frozen=True, eq=False)
class LensResult:
    """`refused`: why it is not constrained; empty: use it. `direction_sd`: [px], largest in the image."""

    fit: LensFit
    sds: Array
    held_out: float
    direction_sd: float
    refused: list[str]
    notes: list[str]


def calibrate(views: Sequence[View], board: Board, model: str, size: tuple[int, int]) -> LensResult:
    """Raises LensError: no lens explains the views."""
    fit = fit_lens(views, board, model, size)
    held_out = held_out_rms(views, board, model, size)
    sds, direction = np.sqrt(np.diag(fit.covariance)), direction_sd(fit)
    refused = [f"missing: {words}" for words in missing_views(views, board, size, fit.camera)]
    focal = float(np.max(sds[:2] / fit.unknowns[:2]))
    if not focal <= FOCAL_LIMIT:
        refused.append(
            f"the focal length is uncertain by {100 * focal:.2f} % (at most {100 * FOCAL_LIMIT:g} %): tilt more"
        )
    if not direction <= DIRECTION_LIMIT:
        refused.append(
            f"a direction in the image is uncertain by {direction:.2f} px (at most {DIRECTION_LIMIT:g}): more views, "
            "at the image's edges too"
        )
    if held_out > HELD_OUT[0] * fit.rms + HELD_OUT[1]:
        refused.append(
            f"views that were held out are off by {held_out:.3f} px, those fitted by {fit.rms:.3f} px: more views, or "
            "a lens model with fewer coefficients"
        )
    return LensResult(fit, sds, held_out, direction, refused, _notes(fit, views))


def describe(result: LensResult) -> str:
    """For the terminal."""
    fit = result.fit
    lines = [
        f"{fit.model}, {len(fit.residuals)} views; corners off by {fit.rms:.3f} px (held out: {result.held_out:.3f})"
    ]
    for name, value, sd in zip(names(fit.model), fit.unknowns, result.sds, strict=True):
        digits, unit = (2, " px") if name in ("fx", "fy", "cx", "cy") else (5, "")
        lines.append(f"  {name:<3} {value:11.{digits}f} +- {sd:.{digits}f}{unit}")
    lines.append(f"  a direction is seen where it says within {result.direction_sd:.2f} px (1 sd, worst in the image)")
    return "\n".join([*lines, *result.notes])


def direction_sd(fit: LensFit) -> float:
    """[px] largest standard deviation, along any axis, of the pixel in which a direction is seen, over the image; inf:
    the lens has no inverse everywhere in it.

    A turn of the camera that fits best is taken out first: a principal point that is off looks like a camera that is
    turned, and where the camera looks is calibrated with its mount (as in mrcal's projection uncertainty).
    """
    u, v = np.meshgrid(*(np.linspace(0.0, side - 1.0, GRID) for side in fit.size))
    rays = fit.camera.ray(np.stack([u, v], axis=-1).reshape(-1, 2))
    if not np.all(np.isfinite(rays)):
        return float("inf")
    points = np.column_stack([rays, np.ones(len(rays))])

    def slopes(count: int, vary: Callable[[Array], Array]) -> Array:
        """(2 points, count) of vary(step (count,)), pixels (points, 2)."""
        columns = [(vary(step) - vary(-step)).ravel() / (2.0 * STEP) for step in STEP * np.eye(count)]
        return np.column_stack(columns)

    scale, still = np.maximum(1.0, np.abs(fit.unknowns)), np.zeros(6)
    lens = slopes(len(scale), lambda step: project(points, still, fit.unknowns + step * scale, fit.model)) / scale
    turn = slopes(3, lambda step: project(points, np.append(step, np.zeros(3)), fit.unknowns, fit.model))
    left = lens - turn @ np.linalg.lstsq(turn, lens, rcond=None)[0]
    J = left.reshape(len(points), 2, -1)
    covariance = J @ fit.covariance @ np.swapaxes(J, 1, 2)
    return float(np.sqrt(np.max(np.linalg.eigvalsh(covariance))))


def _notes(fit: LensFit, views: Sequence[View]) -> list[str]:
    found = []
    for view, off in zip(views, fit.residuals, strict=True):
        rms = float(np.sqrt(np.mean(np.sum(off**2, axis=1))))
        if rms > WORST_VIEW * fit.rms:
            found.append(f"{view.name}: is off by {rms:.2f} px: blurred, or the board was bent? Leave it out")
    return found


__all__ = ["LensError", "LensResult", "calibrate", "describe", "direction_sd"]
