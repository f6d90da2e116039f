"""No way to and fro that is too short to turn the castors round for."""

from __future__ import annotations

import numpy as np

from seater_nmpc.programme import Plan

_SHORTEST = 0.03  # [m]
_PATIENCE = 2.0  # [s] after which it is driven all the same: a corner close to a wall may ask for it


class ToAndFro:
    """Ask it for the speed in each cycle."""

    def __init__(self) -> None:
        self._since: float | None = None  # when such a way was left out first [s]

    def speed(self, stamp: float, plan: Plan, v: float, before: float) -> float:
        """`v` [m/s] of this plan, or zero where it begins a mere to and fro: then the chair turns, but stays. `before`:
        the speed of the last cycle."""
        if not is_mere(plan, v, before):
            self._since = None
            return v
        self._since = stamp if self._since is None else self._since
        return 0.0 if stamp - self._since < _PATIENCE else v


def is_mere(plan: Plan, v: float, before: float) -> bool:
    """Whether driving at `v` [m/s], another way than `before`, begins a stretch of the plan that is not worth while:
    short, and followed by a longer one the other way."""
    if v == 0.0 or v * before > 0.0:
        return False
    speeds = plan.states[:, 3]
    ways = np.sign(v) * 0.5 * (speeds[1:] + speeds[:-1]) * np.diff(plan.times)
    begins = int(np.argmax(ways > 0.0))  # before it, the chair still brakes
    ends = begins + int(np.argmax(ways[begins:] < 0.0))
    if not ways[begins] > 0.0 or not ways[ends] < 0.0:
        return False
    there = float(ways[begins:ends].sum())
    return there < min(_SHORTEST, -float(np.minimum(ways[ends:], 0.0).sum()))
