"""Whether a chair that is asked to drive gets anywhere."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import wrap_angle

Array = NDArray[np.float64]

_ANYWHERE, _ANYWHERE_TURN = 0.05, 0.15  # [m, rad] a chair that stays within these gets nowhere, however busy it is


class Progress:
    """Feed it poses (3,) of any frame that does not move, with their times [s]."""

    def __init__(self, patience: float) -> None:
        """`patience` [s]: so long it may get nowhere."""
        self._patience = patience
        self._place: Array | None = None  # where it was when it last had got somewhere
        self._since = 0.0

    def restart(self) -> None:
        """From now on anew."""
        self._place = None

    def stuck(self, stamp: float, pose: Array) -> bool:
        """Whether it has got nowhere for longer than that, standing or to and fro."""
        place = self._place
        if place is None or (
            math.dist(pose[:2], place[:2]) > _ANYWHERE or abs(wrap_angle(float(pose[2] - place[2]))) > _ANYWHERE_TURN
        ):
            self._place, self._since = pose, stamp
        return stamp - self._since > self._patience
