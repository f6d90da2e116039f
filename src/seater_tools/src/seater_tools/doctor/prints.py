"""Sizes and places of the prints, from images of a standing chair: each print shows its size, and the distances between
them in the dock's file say how long a metre is.

Least squares over the dock's pose, all sizes and all places, each with a prior about the file's value. A single print
that is smaller looks much as one that hangs farther away, so the explanations compete: nothing is wrong; one size, all
sizes, or one place is. Each has a wide prior for what it accuses and narrow ones for the rest. The largest posterior
answers: residuals, what it takes from the priors, and twice the logarithm of how much wider they are (the Occam factor
of Bayesian model comparison: MacKay, Information Theory, Inference, and Learning Algorithms, ch. 28).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from seater_common.camera_model import CameraModel
from seater_common.geometry import Dock, Marker
from seater_tools.doctor.observations import Sight

Array = NDArray[np.float64]

NOISE = 0.1  # [px] of a corner's mean over several images: what prints and lens models leave
FEWEST = 5  # images with a marker
# Standard deviations of sizes (share) and places [m] where they are right, by ruler and tape, and where they are wrong.
RIGHT, WRONG = (0.005, 0.002), (0.06, 0.03)
LARGEST = 1.0  # of a logarithm: no print is off by more
NEAREST = 0.01  # [m] before the lens: a step that is far too long must not divide by zero


@dataclass(frozen=True)
class PrintFit:
    """`ratio`: of each print's true size over the file's, with standard deviation `sd`. `moved`: the marker whose place
    is accused, and how far [m] it is off; None: no place is."""

    ratio: dict[int, float]
    sd: dict[int, float]
    moved: tuple[int, float] | None


def fit_prints(sights: Sequence[Sight], camera: CameraModel, dock: Dock) -> PrintFit | None:
    """None: fewer than two markers are seen often enough, or no image says where the dock is."""
    corners = mean_corners(sights)
    markers = [marker for marker in dock.markers if marker.id in corners]
    start = next((sight.docks[0].T_optical_dock for sight in sights if sight.docks), None)
    if len(markers) < 2 or start is None or not np.all(np.isfinite(start)):
        return None
    measured = np.array([corners[marker.id] for marker in markers])
    fits = [_fit(prior, start, markers, camera, measured) for prior in _explanations(len(markers))]
    best = int(np.argmin([score for score, _, _ in fits]))
    _, errors, sds = fits[best]
    n, ids = len(markers), [marker.id for marker in markers]
    accused = best - (n + 2)
    moved = (ids[accused], float(np.linalg.norm(errors[n + 3 * accused :][:3]))) if accused >= 0 else None
    ratio, sd = np.exp(errors[:n]).tolist(), sds[:n].tolist()
    return PrintFit(dict(zip(ids, ratio, strict=True)), dict(zip(ids, sd, strict=True)), moved)


def _explanations(n: int) -> list[Array]:
    """Prior standard deviations (4 n,), n sizes and n times three coordinates: nothing, all sizes, each size, each
    place is wrong, in this order."""
    nothing = np.repeat(RIGHT, (n, 3 * n))
    sizes = [np.where(np.isin(np.arange(4 * n), wrong), WRONG[0], nothing) for wrong in (list(range(n)), *range(n))]
    places = [np.where((np.arange(4 * n) - n) // 3 == i, WRONG[1], nothing) for i in range(n)]
    return [nothing, *sizes, *places]


def mean_corners(sights: Sequence[Sight]) -> dict[int, Array]:
    """(4, 2) [px] of each marker that FEWEST images show: medians, as single images may be wrong."""
    seen: dict[int, list[Array]] = {}
    for sight in sights:
        for marker in sight.markers:
            if np.all(np.isfinite(marker.corners)):
                seen.setdefault(marker.id, []).append(marker.corners)
    return {id: np.median(rows, axis=0) for id, rows in seen.items() if len(rows) >= FEWEST}


def _fit(
    prior: Array, start: Array, markers: list[Marker], camera: CameraModel, measured: Array
) -> tuple[float, Array, Array]:
    """Score (smaller: better), errors (4 n,) of sizes (logarithms) and places [m], and their standard deviations."""

    def residuals(state: Array) -> Array:
        off = (_project(state[:6], state[6:], start, markers, camera) - measured).ravel() / NOISE
        return np.concatenate([off, state[6:] / prior])

    solved = least_squares(residuals, np.zeros(6 + len(prior)), x_scale=0.01, max_nfev=60)
    covariance = np.linalg.pinv(solved.jac.T @ solved.jac)
    score = float(np.sum(solved.fun**2)) + 2.0 * float(np.sum(np.log(prior)))
    return score, solved.x[6:], np.sqrt(np.diag(covariance)[6:])


def _project(state: Array, errors: Array, start: Array, markers: list[Marker], camera: CameraModel) -> Array:
    """(n, 4, 2) [px]; state: rotation vector and shift of the dock against `start`."""
    import cv2

    turned, moved, n = cv2.Rodrigues(state[:3])[0], state[3:], len(markers)
    places, points = errors[n:].reshape(n, 3), []
    for marker, log_size, place in zip(markers, np.clip(errors[:n], -LARGEST, LARGEST), places, strict=True):
        T = marker.T_dock_marker()
        in_dock = np.exp(log_size) * marker.corners() @ T[:3, :3].T + T[:3, 3] + place
        points.append((in_dock @ start[:3, :3].T + start[:3, 3]) @ turned.T + moved)
    flat = np.concatenate(points)
    flat[:, 2] = np.maximum(flat[:, 2], NEAREST)
    return camera.project(flat).reshape(-1, 4, 2)
