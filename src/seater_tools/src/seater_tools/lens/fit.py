"""The lens with its covariance, and the noise of corners: robust least squares over it and all poses of the board."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.sparse import csr_matrix, lil_matrix

from seater_common.camera_model import CameraModel
from seater_tools.adjust.jacobian import Jacobian
from seater_tools.adjust.robust import NoMinimumError, minimise
from seater_tools.board.board import Board
from seater_tools.lens.find import View
from seater_tools.lens.model import LensError, board_pose, camera_of, first_guess, project

Array = NDArray[np.float64]

SCALE = np.array([1e3, 1e3, 1e3, 1e3])  # [px] of the first four unknowns, so that all are about one
LEAST_NOISE = 0.01  # [px]
# Standard deviation of a coefficient about 0 before anything is seen. Numerator and denominator of the rational model
# nearly cancel: without this, both may grow without end at the same curve.
LIKELY = {"plumb_bob": 10.0, "rational_polynomial": 1.0, "equidistant": 10.0}
FOLDS = 4  # every fourth view is held out in turn


@dataclass(frozen=True, eq=False)
class LensFit:
    """unknowns, covariance: as model.names; noise: sd of a corner [px]; residuals: (n, 2) [px] of each view."""

    model: str
    size: tuple[int, int]
    unknowns: Array
    covariance: Array
    noise: float
    residuals: list[Array]

    @property
    def camera(self) -> CameraModel:
        """With its covariance."""
        return replace(camera_of(self.unknowns, self.model, self.size), covariance=self.covariance)

    @property
    def rms(self) -> float:
        """Of a corner's distance [px], as OpenCV's and ROS' tools say it."""
        return float(np.sqrt(np.mean(np.sum(np.concatenate(self.residuals) ** 2, axis=1))))


def fit_lens(views: Sequence[View], board: Board, model: str, size: tuple[int, int]) -> LensFit:
    """Raises LensError: no lens explains the views."""
    unknowns, poses = first_guess(views, board, model, size)
    count, points = len(unknowns), [board.points()[view.ids] for view in views]
    scale = np.ones(count + poses.size)
    scale[:4] = SCALE
    state = np.concatenate([unknowns, poses.ravel()]) / scale
    seen = np.concatenate([view.corners for view in views])

    def residuals(vector: Array) -> Array:
        values = vector * scale
        at = values[count:].reshape(-1, 6)
        drawn = [project(p, pose, values[:count], model) for p, pose in zip(points, at, strict=True)]
        return (seen - np.concatenate(drawn)).ravel()

    def white(vector: Array, noise: float) -> Array:
        return np.concatenate([residuals(vector) / noise, vector[4:count] / spread])

    jacobian, noise, spread = Jacobian(_pattern([len(p) for p in points], count)), 1.0, LIKELY[model]
    freedom = seen.size - len(state)
    if freedom <= 0:
        raise LensError(f"{len(views)} views with {len(seen)} corners are too few for a {model} lens")
    try:
        for _ in range(2):
            minimum = minimise(partial(white, noise=noise), jacobian, state, count)
            state = minimum.state
            weighted = minimum.weights[: seen.size] * residuals(state) ** 2
            noise = max(LEAST_NOISE, float(np.sqrt(weighted.sum() / max(freedom, 1))))
        minimum = minimise(partial(white, noise=noise), jacobian, state, count)
    except (NoMinimumError, np.linalg.LinAlgError) as error:
        raise LensError(f"no {model} lens explains these views: {error}") from error
    off = residuals(minimum.state).reshape(-1, 2)
    ends = np.cumsum([len(p) for p in points])[:-1]
    covariance = minimum.covariance * np.outer(scale[:count], scale[:count])
    return LensFit(model, size, (minimum.state * scale)[:count], covariance, noise, np.split(off, ends))


def held_out_rms(views: Sequence[View], board: Board, model: str, size: tuple[int, int]) -> float:
    """[px] as LensFit.rms, of views that the lens was not fitted to: each in one of FOLDS groups, its pose alone
    fitted. Raises LensError."""
    squares, count = 0.0, 0
    for fold in range(FOLDS):
        others = [view for i, view in enumerate(views) if i % FOLDS != fold]
        lens = fit_lens(others, board, model, size)
        for view in views[fold::FOLDS]:
            off = _posed(view, board, lens)
            squares, count = squares + float(np.sum(off**2)), count + len(off)
    return float(np.sqrt(squares / count))


def _posed(view: View, board: Board, lens: LensFit) -> Array:
    """(n, 2) [px] residuals of the view at its best pose."""
    points = board.points()[view.ids]

    def off(pose: Array) -> Array:
        return (view.corners - project(points, pose, lens.unknowns, lens.model)).ravel()

    best = least_squares(off, board_pose(view, board, lens.camera), x_scale="jac", method="lm")
    return np.asarray(off(best.x).reshape(-1, 2))


def _pattern(counts: Sequence[int], lens: int) -> csr_matrix:
    """(2 corners + distortion, lens + 6 views): a corner depends on the lens and its own pose."""
    rows = 2 * sum(counts)
    S = lil_matrix((rows + lens - 4, lens + 6 * len(counts)), dtype=np.int8)
    S[:rows, :lens] = 1
    S[rows:, 4:lens] = np.eye(lens - 4)
    row = 0
    for i, count in enumerate(counts):
        S[row : row + 2 * count, lens + 6 * i : lens + 6 * i + 6] = 1
        row += 2 * count
    return csr_matrix(S)
