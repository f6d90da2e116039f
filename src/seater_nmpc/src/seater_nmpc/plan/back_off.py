"""Straight back from where the optimisation sees no way on: a corner of a wall close ahead, say.

Where that got nowhere, as a wall is close behind, the next one leads straight ahead.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import compose

Array = NDArray[np.float64]

_WAY, _TIME = 0.6, 8.0  # [m, s] that the chair backs off
_NOWHERE = 0.1  # [m] from where the last one began


class BackOff:
    """One at a time; poses (3,) in the dock's frame."""

    _target: Array | None
    _began: Array | None  # where the last one did
    _way: float  # [m] ahead

    def __init__(self, near: float) -> None:
        """`near` [m]: so near to its end it is over."""
        self._near = near
        self.forget()

    @property
    def goes_on(self) -> bool:
        """Whether the chair backs off."""
        return self._target is not None

    def begin(self, stamp: float, pose: Array) -> None:
        """From `pose`, at `stamp` [s]."""
        again = self._began is not None and math.dist(pose[:2], self._began[:2]) < _NOWHERE
        self._way, self._began = -self._way if again else -_WAY, pose
        self._target, self._until = compose(pose, [self._way, 0.0, 0.0]), stamp + _TIME

    def forget(self) -> None:
        """It is over, wherever the chair is, and so is where the last ones led."""
        self._target = self._began = None
        self._until, self._way = 0.0, -_WAY  # [s, m]

    def target(self, stamp: float, pose: Array) -> Array | None:
        """Where to (3,); None: it is over, as the chair has arrived or its time is up."""
        if self._target is not None and (math.dist(pose[:2], self._target[:2]) <= self._near or stamp >= self._until):
            self._target = None
        return self._target
