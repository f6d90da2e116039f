"""Making room for a turn on the spot: a short way straight on or back to where the chair can turn.

Beside a wall the front of a chair, farther from its axle than its rear, sweeps over the wall in most turns; a way of
some decimetres back, or a part of the turn and then a way, leaves place for the rest of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import wrap_angle

Array = NDArray[np.float64]
Clear = Callable[[Array], bool]  # of poses (k, 3), whether the chair may be at all of them
Aim = Callable[[Array], float]  # of a place (x, y), the heading that is wanted there [rad]

_WAYS = (-0.3, 0.3, -0.6, 0.6, -0.9, 0.9, -1.2, 1.2)  # [m] along the chair
_TURNS = (0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2, 1.6, -1.6)  # [rad] before that
_TURN_COSTS = 0.6  # [m/rad] of way, at the speeds of a search
_STEPS = 24
_BACKWARD = 1.2  # times a way forward: nothing is seen there


def clear_turn(pose: Array, heading: float, clear: Clear) -> float | None:
    """The turn [rad] on the spot at `pose` (3,) to a heading, the shorter one first; None: neither is clear."""
    short = wrap_angle(heading - float(pose[2]))
    ways = (short, short - math.copysign(2.0 * math.pi, short))
    return next((turn for turn in ways if clear(turned(pose, turn))), None)


def make_room(pose: Array, aim: Aim, clear: Clear) -> tuple[float, float] | None:
    """The cheapest turn [rad] and way [m] after it to where the chair can turn to the heading; None: there is none."""
    best, least = None, math.inf
    begins = [turn for turn in _TURNS if clear(turned(pose, turn))]
    for turn, way in sorted(product(begins, _WAYS), key=lambda move: _cost(*move)):
        poses, cost = driven(turned(pose, turn)[-1], way), _cost(turn, way)
        there = poses[-1]
        heading = aim(there[:2])
        short = abs(wrap_angle(heading - float(there[2])))  # at least so much is left
        if cost + _TURN_COSTS * short >= least or not clear(poses):
            continue
        rest = clear_turn(there, heading, clear)
        if rest is not None and cost + _TURN_COSTS * abs(rest) < least:
            best, least = (turn, way), cost + _TURN_COSTS * abs(rest)
    return best


def turned(pose: Array, turn: float) -> Array:
    """Poses (k, 3) of a turn on the spot."""
    return np.asarray(pose + np.linspace(0.0, 1.0, _STEPS)[:, None] * [0.0, 0.0, turn])


def driven(pose: Array, way: float) -> Array:
    """Poses (k, 3) of a straight way."""
    ahead = np.array([math.cos(pose[2]), math.sin(pose[2]), 0.0])
    return np.asarray(pose + np.linspace(0.0, way, _STEPS)[:, None] * ahead)


def _cost(turn: float, way: float) -> float:
    return _TURN_COSTS * abs(turn) + abs(way) * (1.0 if way > 0.0 else _BACKWARD)
