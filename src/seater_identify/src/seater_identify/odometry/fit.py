"""Scale, heading scale and heading drift of the odometry from a dock that does not move.

Odometry measures way' = (1 + e_s) way and turn' = (1 + e_t) turn + e_d way (the model of the docking observer). All
images are fitted at once: the three errors, the dock in odom, an error of the camera mount, and for each piece of the
way a random error of way and turn (slip), whose size is the one that makes the images likeliest (restricted maximum
likelihood over a few sizes). Images that do not fit (flips, outliers) are left out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import wrap_angle
from seater_identify.record.recording import Recording, increments

Array = NDArray[np.float64]

NAMES = ("scale", "heading_scale", "heading_drift")
PRIOR_SD = np.array([0.05, 0.05, 0.05])  # far wider than any chair: the images decide
MOUNT_SD = np.array([0.002, 0.002, 0.003])  # [m, m, rad] of the camera mount, as the observer's calibration errors
PIECE = (0.08, 0.15)  # [m], [rad] of way or turn that have one random error
SIZES = (1.0, 3.0, 8.0)  # times NOISE
NOISE = (0.002, 0.002, 0.004)  # [m/sqrt(m)], [rad/sqrt(m)], [rad/sqrt(rad)]
OUTLIER = 4.0  # standard deviations, robust, of an image that is left out
FEWEST = 20  # images
MOST = 240  # images that are used, evenly over the drive


@dataclass(frozen=True)
class OdometryFit:
    """Errors e = (e_s [-], e_t [-], e_d [rad/m]) with covariance (3, 3), and how many images said so."""

    errors: Array
    covariance: Array
    images: int


def fit_odometry(recording: Recording) -> OdometryFit | None:
    """None when the dock was seen in too few images."""
    path = _Path(recording)
    chosen = _inliers(recording, path)
    if len(chosen) < FEWEST:
        return None
    chosen = chosen[np.unique(np.linspace(0, len(chosen) - 1, min(MOST, len(chosen))).astype(int))]
    best: tuple[float, Array, Array] | None = None
    for size in SIZES:
        state, covariance, likelihood, chosen = _solve(recording, path, chosen, size)
        if best is None or likelihood > best[0]:
            best = likelihood, state, covariance
    assert best is not None
    return OdometryFit(best[1][:3], best[2][:3, :3], len(chosen))


class _Path:
    """The odometry as increments, cut into pieces."""

    def __init__(self, recording: Recording) -> None:
        steps = increments(recording)
        self.times = np.concatenate([steps.begin[:1], steps.end])
        self.way, self.turn = steps.way, steps.turn
        progress = np.cumsum(np.abs(steps.way) / PIECE[0] + np.abs(steps.turn) / PIECE[1])
        self.piece = np.floor(progress).astype(int)
        self.count = int(self.piece[-1]) + 1

    def poses(self, errors: Array, slips: Array) -> Array:
        """(n + 1, 3) corrected poses in odom, from the first; `slips` (count, 2): share of way, of turn added."""
        way = self.way / (1.0 + errors[0]) + slips[self.piece, 0] * self.share_way
        turn = (self.turn - errors[2] * self.way) / (1.0 + errors[1]) + slips[self.piece, 1] * self.share_turn
        heading = np.concatenate([[0.0], np.cumsum(turn)])
        middle = heading[:-1] + 0.5 * turn
        x = np.concatenate([[0.0], np.cumsum(way * np.cos(middle))])
        y = np.concatenate([[0.0], np.cumsum(way * np.sin(middle))])
        return np.column_stack([x, y, heading])

    @property
    def share_way(self) -> Array:
        """(n,) of a piece's way error that falls into each increment."""
        return self._share(np.abs(self.way))

    @property
    def share_turn(self) -> Array:
        """(n,) the same of a turn error."""
        return self._share(np.abs(self.way) / PIECE[0] + np.abs(self.turn) / PIECE[1])

    def _share(self, size: Array) -> Array:
        total = np.bincount(self.piece, size, self.count)
        return size / np.maximum(total[self.piece], 1e-12)

    def noise(self) -> Array:
        """(count, 2) standard deviations of the pieces' way [m] and turn [rad]."""
        way = np.bincount(self.piece, np.abs(self.way), self.count)
        turn = np.bincount(self.piece, np.abs(self.turn), self.count)
        return np.column_stack(
            [NOISE[0] * np.sqrt(way) + 1e-5, np.sqrt(NOISE[1] ** 2 * way + NOISE[2] ** 2 * turn) + 1e-5]
        )

    def at(self, poses: Array, times: Array) -> Array:
        """Poses (k, 3) at times, interpolated."""
        return np.column_stack([np.interp(times, self.times, poses[:, i]) for i in range(3)])


def _inliers(recording: Recording, path: _Path) -> NDArray[np.intp]:
    """Images within the odometry's time whose dock in odom is near the median of all."""
    times = recording.dock[:, 0]
    inside = np.flatnonzero((times >= path.times[0]) & (times <= path.times[-1]))
    if not len(inside):
        return inside
    poses = path.at(path.poses(np.zeros(3), np.zeros((path.count, 2))), times[inside])
    docks = np.array([_compose(p, d) for p, d in zip(poses, recording.dock[inside, 1:], strict=True)])
    middle = np.median(docks, axis=0)
    off = np.hypot(docks[:, 0] - middle[0], docks[:, 1] - middle[1])
    turned = np.abs([wrap_angle(float(a)) for a in docks[:, 2] - middle[2]])
    return inside[(off < 0.4) & (turned < 0.3)]


def _compose(pose: Array, local: Array) -> Array:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    heading = wrap_angle(pose[2] + local[2])
    return np.array([pose[0] + c * local[0] - s * local[1], pose[1] + s * local[0] + c * local[1], heading])


def _predict(path: _Path, state: Array, times: Array) -> Array:
    """(k, 3) the dock in base_link as the camera reports it. State: errors, dock in odom, mount, slips."""
    poses = path.at(path.poses(state[:3], state[9:].reshape(-1, 2)), times)
    dx, dy = state[3] - poses[:, 0], state[4] - poses[:, 1]
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    x, y = c * dx + s * dy, -s * dx + c * dy
    off = state[8]  # the camera reports what it sees turned by the mount's error
    return np.column_stack([x - off * y + state[6], y + off * x + state[7], state[5] - poses[:, 2] + off])


def _solve(
    recording: Recording, path: _Path, chosen: NDArray[np.intp], size: float
) -> tuple[Array, Array, float, NDArray[np.intp]]:
    """State, covariance, log likelihood, images that were used; Gauss-Newton with outliers left out on the way."""
    prior_sd = np.concatenate([PRIOR_SD, [10.0, 10.0, 10.0], MOUNT_SD, (size * path.noise()).ravel()])
    first = recording.dock[chosen[0], 1:]
    start = path.at(path.poses(np.zeros(3), np.zeros((path.count, 2))), recording.dock[chosen[:1], 0])[0]
    state = np.zeros(len(prior_sd))
    state[3:6] = _compose(start, first)
    inflation = 1.0
    for iteration in range(5):
        times, seen = recording.dock[chosen, 0], recording.dock[chosen, 1:]
        root = np.linalg.cholesky(np.linalg.inv(recording.dock_covariance[chosen] * inflation))
        r = seen - _predict(path, state, times)
        r[:, 2] = [wrap_angle(float(a)) for a in r[:, 2]]
        J = _jacobian(path, state, times)
        white = np.einsum("kij,ki->kj", root, r)
        A = np.einsum("kij,kil->kjl", root, J).reshape(-1, len(state))
        information = A.T @ A + np.diag(prior_sd**-2)
        step = np.linalg.solve(information, A.T @ white.ravel() - state * prior_sd**-2 * _is_prior(state))
        state = state + step
        if iteration in (1, 2):
            distance = np.sqrt(np.sum((white.ravel() - A @ step).reshape(-1, 3) ** 2, axis=1) / 3.0)
            scale = max(float(np.median(distance)) / 0.9, 1.0)
            chosen = chosen[distance < OUTLIER * scale]
            inflation = max(inflation, scale**2)
    weight = prior_sd**-2 * _is_prior(state)
    left = white.ravel() - A @ step
    cost = float(left @ left + np.sum(weight * state**2))
    determinant = float(np.linalg.slogdet(information)[1]) + 2.0 * float(np.sum(np.log(prior_sd[9:])))
    likelihood = -0.5 * (cost + determinant + 3.0 * len(chosen) * math.log(inflation))
    return state, np.linalg.inv(information), likelihood, chosen


def _is_prior(state: Array) -> Array:
    """1 where a state has a prior mean of zero; the dock in odom has none."""
    mask = np.ones(len(state))
    mask[3:6] = 0.0
    return mask


def _jacobian(path: _Path, state: Array, times: Array) -> Array:
    """(k, 3, n) by differences."""
    before = _predict(path, state, times)
    J = np.empty((*before.shape, len(state)))
    for index in range(len(state)):
        moved = state.copy()
        moved[index] += 1e-6
        J[:, :, index] = (_predict(path, moved, times) - before) / 1e-6
    return J
