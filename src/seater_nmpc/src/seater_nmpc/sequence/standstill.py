"""Whether the chair stands, how long, and whether it is near enough to stop for good. Times are message time [s]."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.observe.odometry import Instant
from seater_nmpc.parameters import SequenceParameters

Array = NDArray[np.float64]


class Standstill:
    """Begins anew with every phase."""

    def __init__(self, parameters: SequenceParameters, now: float) -> None:
        self._parameters = parameters
        self._moved = self._left_release = now  # when that was seen last

    def stands(self, chair: Instant) -> bool:
        """Whether it stands now; every question about how long rests on this one being asked in each cycle."""
        still = max(abs(chair.v), abs(chair.omega)) <= self._parameters.standing_speed
        if not still:
            self._moved = chair.stamp
        return still

    def has_stood(self, chair: Instant) -> bool:
        """Whether it has stood for `standing_time`; to be asked in every cycle while it is asked to stand."""
        self.stands(chair)
        return chair.stamp - self._moved >= self._parameters.standing_time

    def stalled(self, chair: Instant) -> bool:
        """Whether it has stood for longer than `stall_time` though it was asked to drive."""
        return self.stands(chair) and chair.stamp - self._moved > self._parameters.stall_time

    def at_rest_in_place(self, chair: Instant, error: Array) -> bool:
        """In the hold zone, or in the release zone for `settle_time`: as near as it gets. `error` (3,): to the dock."""
        p, position, heading = self._parameters, math.hypot(error[0], error[1]), abs(error[2])
        if self.released(error):
            self._left_release = chair.stamp
        settled = chair.stamp - self._left_release >= p.settle_time
        return settled or (position <= p.hold_position and heading <= p.hold_heading)

    def released(self, error: Array) -> bool:
        """Whether the stopped chair is so far off that it has to drive on."""
        p = self._parameters
        return math.hypot(error[0], error[1]) > p.release_position or abs(error[2]) > p.release_heading
