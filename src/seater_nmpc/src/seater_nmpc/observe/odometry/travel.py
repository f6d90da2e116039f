"""How a chair had driven by some time, as sums over short steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import arc_length, relative

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Travel:
    """Sums over everything driven since the buffer began: what the drift of the odometry between two times depends on.

    ds and dt are the way (negative backward) and the turn of a short step that takes dtime, q = (1, x, y) with the
    chair's place in odom, c the unit vector of its direction there. All sums stand in one array: they are added up with
    every message and every estimate.
    """

    sums: Array  # (31,)

    def plus(self, other: Travel, fraction: float = 1.0) -> Travel:
        """This, and `fraction` of the other."""
        return Travel(self.sums + fraction * other.sums)

    @property
    def rows(self) -> Array:
        """(3, 3): the sums of q dt, of q ds and of q dtime."""
        return self.sums[:9].reshape(3, 3)

    @property
    def along(self) -> Array:
        """(2, 2) of c c' |ds|."""
        return self.sums[9:13].reshape(2, 2)

    @property
    def by_way(self) -> Array:
        """(3, 3) of q q' |ds|."""
        return self.sums[13:22].reshape(3, 3)

    @property
    def by_turn(self) -> Array:
        """(3, 3) of q q' |dt|."""
        return self.sums[22:31].reshape(3, 3)

    @property
    def driven(self) -> float:
        """Way driven, both ways added up [m]."""
        return float(self.sums[13])

    @property
    def turned(self) -> float:
        """Angle turned, both ways added up [rad]."""
        return float(self.sums[22])


NO_TRAVEL = Travel(np.zeros(31))


def step(before: Array, after: Array, duration: float) -> Travel:
    """Of one short step from pose to pose (3,) in `duration` [s], with the middle of the chord as its place."""
    chord_x, chord_y, turn = relative(before, after).tolist()
    way, (x, y) = arc_length(chord_x, chord_y, turn), (0.5 * (before[:2] + after[:2])).tolist()
    direction, size, turned = float(before[2]) + 0.5 * turn, abs(way), abs(turn)
    c, s = math.cos(direction), math.sin(direction)
    square = (1.0, x, y, x, x * x, x * y, y, y * x, y * y)  # q q'
    sums = [turn, turn * x, turn * y, way, way * x, way * y, duration, duration * x, duration * y]
    sums += [size * (c * c), size * (c * s), size * (s * c), size * (s * s)]
    return Travel(np.array(sums + [size * value for value in square] + [turned * value for value in square]))
