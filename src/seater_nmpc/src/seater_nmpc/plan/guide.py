"""Along a planned way: which pose to drive to next. Poses are (x, y, heading) in the dock's frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.se2 import relative, wrap_angle, wrap_angles
from seater_nmpc.parameters import PlannerParameters
from seater_nmpc.plan.path import Path

Array = NDArray[np.float64]

_WINDOW = 1.0  # [m] how far ahead along the way the chair's place on it is looked for
# A chair that moves less than this (turns reckoned in) during so many calls [control cycles] stands. Next to a wall the
# controller's plan may put off a small correction sideways for ever: 13 cm short of a turning point were seen.
_STANDING_WAY, _STANDING_CALLS = 0.02, 40
_ASIDE = 2.0  # times `reached_position`, beside the turning point
_NEAR_ENOUGH = 0.75  # [m] from the turning point, turns reckoned in: there a standing chair may turn round


class Guide:
    """Follows one path. A place along a leg counts metres driven plus `turn_length` for each radian turned.

    The legs are the parts between two changes of driving direction; the chair has to come to the end of each, and the
    pose to drive to is never beyond the leg's end.
    """

    def __init__(self, path: Path, parameters: PlannerParameters) -> None:
        self._parameters = parameters
        self._legs = _legs(path, parameters.turn_length)
        self._leg, self._place = 0, 0.0
        self._stood_at: Array | None = None
        self._stood = 0  # calls

    @property
    def single(self) -> bool:
        """Whether the path is driven in one direction all along."""
        return len(self._legs) == 1

    @property
    def last_leg(self) -> bool:
        """Whether the direction does not change any more."""
        return self._leg == len(self._legs) - 1

    def target(self, pose: ArrayLike, lookahead: float) -> Array:
        """The pose to drive to from the chair's pose, at most `lookahead` [m] along the way."""
        pose = np.asarray(pose, dtype=float)
        self._watch(pose)
        while not self.last_leg and self._reached(self._legs[self._leg][0][-1], pose):
            self._leg, self._place, self._stood = self._leg + 1, 0.0, 0
        poses, places = self._legs[self._leg]
        window = (places >= self._place - 1e-9) & (places <= self._place + _WINDOW)
        near = np.flatnonzero(window)
        self._place = float(places[near[np.argmin(self._away(poses[near], pose))]])
        return _at(poses, places, self._place + lookahead)

    def rest(self) -> Array:
        """Poses (n, 3) of the way from the chair's last place on."""
        poses, places = self._legs[self._leg]
        ahead = poses[np.searchsorted(places, self._place) :]
        return np.vstack([ahead, *(later for later, _ in self._legs[self._leg + 1 :])])

    def away(self, pose: ArrayLike) -> float:
        """Distance from the leg that is being driven, turns reckoned in [m]."""
        return float(np.min(self._away(self._legs[self._leg][0], np.asarray(pose, dtype=float))))

    def _away(self, poses: Array, pose: Array) -> Array:
        turn = wrap_angles(poses[:, 2] - pose[2])
        return np.asarray(np.hypot(*(poses[:, :2] - pose[:2]).T) + self._parameters.turn_length * np.abs(turn))

    def _watch(self, pose: Array) -> None:
        """Counts for how many calls the chair has stood."""
        if self._stood_at is not None and float(self._away(self._stood_at[None], pose)[0]) <= _STANDING_WAY:
            self._stood += 1
        else:
            self._stood_at, self._stood = pose, 0

    def _reached(self, end: Array, pose: Array) -> bool:
        p, error = self._parameters, relative(end, pose)
        if self._stood >= _STANDING_CALLS and float(self._away(end[None], pose)[0]) <= _NEAR_ENOUGH:
            return True
        # Where it turns round matters along the way; to shift it aside there takes another to and fro.
        near = abs(error[0]) <= p.reached_position and abs(error[1]) <= _ASIDE * p.reached_position
        return near and abs(error[2]) <= p.reached_heading


def _legs(path: Path, turn_length: float) -> list[tuple[Array, Array]]:
    """(poses, places) of each leg. The way from the start onto the lattice belongs to the first one."""
    legs, begin = [], 0
    changes = [i for i in range(2, len(path.backward)) if path.backward[i] != path.backward[i - 1]]
    for end in [*(i - 1 for i in changes), len(path.poses) - 1]:
        poses = path.poses[begin : end + 1]
        step = np.hypot(*np.diff(poses[:, :2], axis=0).T)
        turn = np.abs(wrap_angles(np.diff(poses[:, 2])))
        legs.append((poses, np.concatenate([[0.0], np.cumsum(step + turn_length * turn)])))
        begin = end
    return legs


def _at(poses: Array, places: Array, place: float) -> Array:
    """The pose at a place along a leg, interpolated."""
    i = int(np.clip(np.searchsorted(places, place) - 1, 0, len(places) - 2)) if len(places) > 1 else 0
    if len(places) == 1 or place >= places[-1]:
        return np.asarray(poses[-1])
    fraction = (place - places[i]) / max(places[i + 1] - places[i], 1e-9)
    turn = wrap_angle(float(poses[i + 1, 2] - poses[i, 2]))
    xy = poses[i, :2] + fraction * (poses[i + 1, :2] - poses[i, :2])
    return np.array([xy[0], xy[1], wrap_angle(float(poses[i, 2] + fraction * turn))])
