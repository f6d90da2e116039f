"""STAGING: to the predock point, to stand there; forward, or backing out where the chair is nearer to the dock."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.sequence.goal.results import GoalEnd, ResultCode
from seater_nmpc.sequence.phases.context import STANDING, Asked, Context
from seater_nmpc.sequence.phases.way_out import WayOut

_CLOSE = 0.02  # [m] from the predock point, where the chair is asked to stand: nothing is to be gained beyond that


class Staging:
    """The end of a goal with `staging`."""

    def __init__(self, context: Context, way_out: WayOut) -> None:
        self._context, self._way_out = context, way_out
        self.restart()

    def restart(self) -> None:
        """A phase begins."""
        self._stops = False  # as near as is of use
        self.backs_out = False  # towards the predock point, out of the bay

    def stage(self, chair: Instant) -> Asked:
        """Until the chair stands at the predock point. Raises GoalEnd."""
        c = self._context
        error, x = c.look(chair), c.dock.predock_x
        there = c.is_at(x, error, chair)
        if there and c.standstill.has_stood(chair.stamp, c.measured(chair)):
            raise GoalEnd(ResultCode.SUCCESS, "stands at the predock point")
        rest = c.rest_error(chair)
        self._stops = there and (self._stops or math.hypot(rest[0] - x, rest[1]) <= _CLOSE)
        if self._stops:
            return replace(STANDING, text="at the predock point")
        self.backs_out = error[0] > x + (0.0 if self.backs_out else c.parameters.predock_position)
        if self.backs_out:
            return self._way_out.back_out(chair, error, np.array([x, 0.0, 0.0]))
        if c.standstill.stalled(chair.stamp, c.measured(chair)):
            raise GoalEnd(ResultCode.FAILED_TO_STAGE, "stands short of the predock point")
        return c.drive(chair, "predock")
