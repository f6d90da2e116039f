"""Whether a chair that stands before the dock drives on to it, steered as on the last stretch, instead of a small move.

A push that is over before odometry could steer it is no good for more than a centimetre or two, and each push of a
chair that rolls back, or that castors push back, is a to and fro. What it rolls back is way that it can be steered on.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.sequence.rest.roll import Roll

Array = NDArray[np.float64]

MOST = 2  # times in an attempt
_BEFORE, _WAY = 0.0045, 0.008  # [m] before the dock, and way to drive for it, from which on it is worth while
_TURNS = 0.004  # [rad] while it rolls, which only small moves reckon with


def next_overshoot(last: float | None, before: float, roll: Roll) -> float:
    """[m] of a stop after a short way, given how far beside its end the `last` stop was (None: it had none), or the one
    `before` it. A stop after a long way was faster, and ran on before the chair rolled back."""
    if roll.seen:
        return roll.way() if last is None else 0.5 * (last + roll.way())
    return before if last is None else last


def has_way_on(error: Array, overshoot: float, roll: Roll, parameters: SequenceParameters) -> bool:
    """Whether all that is wrong of a standing chair at `error` (3,) from the dock is that it stands before it.
    `overshoot` [m]: of the stop to come. A chair that rolls on by more than it has to drive cannot stop so early."""
    x, y, heading = map(float, error)
    aside = abs(y) > parameters.release_position or abs(heading) > parameters.release_heading
    way = -x - (overshoot if roll.seen else min(0.0, overshoot))
    return not aside and abs(roll.turn()) <= _TURNS and x < -_BEFORE and way > _WAY
