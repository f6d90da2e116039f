"""Whether the chair stands, how long, and whether it is near enough to stop. Times are message time [s]."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.drive.progress import Progress
from seater_nmpc.parameters import SequenceParameters

Array = NDArray[np.float64]

_PATIENCE_NEAR = 0.25  # fraction of `stall_time`
_AT_THE_DOCK = 0.001  # [m] distance at which no more is to be gained by driving


class Standstill:
    """Begins anew with every phase."""

    def __init__(self, parameters: SequenceParameters, now: float) -> None:
        self._parameters = parameters
        self._moved = self._left_release = now  # when that was seen last
        self._progress = Progress(parameters.stall_time)

    def stands(self, stamp: float, speeds: tuple[float, float]) -> bool:
        """Whether it stands now; every question about how long rests on this one being asked in each cycle."""
        still = max(abs(speeds[0]), abs(speeds[1])) <= self._parameters.standing_speed
        if not still:
            self._moved = stamp
        return still

    def has_stood(self, stamp: float, speeds: tuple[float, float]) -> bool:
        """Whether it has stood for `standing_time`; to be asked in every cycle while it is asked to stand."""
        self.stands(stamp, speeds)
        return stamp - self._moved >= self._parameters.standing_time

    @property
    def since(self) -> float:
        """Since when it has stood [s]."""
        return self._moved

    def stalled(self, stamp: float, speeds: tuple[float, float], *, near: bool = False) -> bool:
        """Whether it has stood for longer than `stall_time` though it was asked to drive; `near` the dock, a quarter of
        that will do."""
        patience = self._parameters.stall_time * (_PATIENCE_NEAR if near else 1.0)
        return self.stands(stamp, speeds) and stamp - self._moved > patience

    def stuck(self, stamp: float, pose: Array) -> bool:
        """Whether it has got nowhere for longer than `stall_time`, standing or to and fro. `pose` (3,), of any frame
        that does not move."""
        return self._progress.stuck(stamp, pose)

    def in_place(self, stamp: float, rest_error: Array) -> bool:
        """Whether it would come to rest at the dock, or has hovered in the release zone for `settle_time`: as near as
        it gets. `rest_error` (3,): where it would come to rest."""
        p, position = self._parameters, math.hypot(rest_error[0], rest_error[1])
        if position > p.release_position or abs(rest_error[2]) > p.release_heading:
            self._left_release = stamp
        settled = stamp - self._left_release >= p.settle_time
        return settled or (position <= _AT_THE_DOCK and abs(rest_error[2]) <= p.hold_heading)
