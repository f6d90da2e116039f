"""How fast the chair has driven since the last cycle, by its poses where these go on evenly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import arc_length, relative
from seater_nmpc.control.pace import LONGEST_PERIOD

Array = NDArray[np.float64]

_FARTHEST = 1000.0  # [m] from the origin that a pose on a floor can be
_JUMP = (0.1, 0.2)  # [m/s, rad/s] by which speeds from poses may differ from the measured ones


class Driven:
    """Tell it the pose of each cycle."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """The next pose is the first."""
        self._last: tuple[float, Array] | None = None

    def speeds(self, stamp: float, pose: Array, measured: tuple[float, float]) -> tuple[float, float]:
        """Mean (v [m/s], omega [rad/s]) since the last pose (3,), or the `measured` ones where it jumped."""
        before, self._last = self._last, (stamp, pose)
        if before is None or not 0.0 < stamp - before[0] <= LONGEST_PERIOD or not _near(before[1], pose):
            return measured
        x, y, turn = relative(before[1], pose).tolist()
        driven = arc_length(x, y, turn) / (stamp - before[0]), turn / (stamp - before[0])
        even = all(abs(d - v) <= most for d, v, most in zip(driven, measured, _JUMP, strict=True))
        return driven if even else measured


def _near(a: Array, b: Array) -> bool:
    """Whether both are places on a floor, not far apart."""
    return bool(np.max(np.abs(a)) < _FARTHEST and np.max(np.abs(b)) < _FARTHEST)
