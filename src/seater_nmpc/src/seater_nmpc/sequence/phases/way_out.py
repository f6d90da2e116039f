"""RETRY and UNDOCKING: backing out of the bay, for another attempt or to leave."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import relative
from seater_nmpc.control.command import Command
from seater_nmpc.control.target import Target
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.plan.way_back import WayBack
from seater_nmpc.sequence.goal.results import GoalEnd, ResultCode
from seater_nmpc.sequence.phases.context import ARRIVED_SPEED, STANDING, Context

Array = NDArray[np.float64]

_LANE = (0.3, 0.5)  # [m, rad] beside the dock's axis and ahead of the predock point, where a chair may back out


class WayOut:
    """No sensor looks there as a rule: slowly, and by what was seen there last."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._way_back = WayBack(context.chair, context.dock, context.controller.parameters.stop_margin)

    def restart(self) -> None:
        """A phase begins."""
        self._way_back.restart()

    def retry(self, chair: Instant) -> Command | None:
        """RETRY: back out by `retry_distance` where little is to be mended, else to the predock point; None: there.

        A goal that is given up ends at the predock point. Raises GoalEnd.
        """
        c, p = self._context, self._context.parameters
        error = c.look(chair)
        small = abs(error[1]) <= p.corridor_half_width and abs(error[2]) <= p.corridor_heading
        near = small and c.goal.failure is None
        x = max(c.dock.predock_x, -p.retry_distance) if near else c.dock.predock_x
        if c.is_at(x, error, chair):
            return None if c.goal.failure is None else self._end(chair, c.goal.failure)
        return self.back_out(chair, error, np.array([x, 0.0, 0.0]))

    def _end(self, chair: Instant, failure: GoalEnd) -> Command:
        c = self._context
        if c.standstill.has_stood(chair.stamp, c.measured(chair)):
            raise GoalEnd(failure.code, f"{failure.text}; backed out to the predock point")
        return STANDING

    def undock(self, chair: Instant) -> Command:
        """UNDOCKING: to the predock point, by odometry alone. Raises GoalEnd."""
        c, goal = self._context, self._context.goal
        if goal.T_odom_dock is None:
            goal.T_odom_dock = self._dock_to_leave(chair)
        goal.error = relative(goal.T_odom_dock, chair.pose)
        to_go = goal.error - [c.dock.predock_x, 0.0, 0.0]
        arrived = to_go[0] <= 0.0 or math.hypot(to_go[0], to_go[1]) <= c.parameters.predock_position
        if not arrived or abs(chair.v) > ARRIVED_SPEED:
            return self.back_out(chair, goal.error, "predock")
        if c.standstill.has_stood(chair.stamp, c.measured(chair)):
            raise GoalEnd(ResultCode.SUCCESS, "undocked")
        return STANDING

    def back_out(self, chair: Instant, error: Array, target: Target) -> Command:
        """Out of the bay; something in the way, or so near that the chair gets nowhere, is waited for, not for ever."""
        c = self._context
        outlines, longest = c.controller.obstacles, c.parameters.back_out_wait
        obstacle, waited = self._way_back.obstacle(error, outlines), self._way_back.update(chair.stamp, error)
        cause = obstacle or c.goal.held_by or self._way_back.cause(error, outlines)
        if cause and waited > longest:
            raise GoalEnd(ResultCode.BLOCKED, f"waited for {longest:.0f} s to back out: {cause}")
        if obstacle:
            c.controller.reset()
            return replace(STANDING, text=f"waits to back out: {obstacle}")
        return c.drive(chair, target)

    def _dock_to_leave(self, chair: Instant) -> Array:
        """The dock in odom (3,): as known, however long ago it was seen, if the chair stands in it or on its way in or
        out; else where it is if the chair stands docked."""
        c, goal = self._context, self._context.goal
        estimate = c.observer.estimate(chair.stamp)
        if estimate is not None and estimate.blind_distance <= c.parameters.max_blind_distance:
            x, y, heading = relative(estimate.pose, chair.pose).tolist()
            if x >= c.dock.predock_x - _LANE[0] and abs(y) <= _LANE[0] and abs(heading) <= _LANE[1]:
                return estimate.pose
        if goal.contact or goal.force:
            return chair.pose
        why = "no dock is known here" if estimate is None else "the dock is known elsewhere"
        closed = "is not known" if goal.contact is None else "is open"
        raise GoalEnd(
            ResultCode.NOT_DOCKED, f"{why}, and the contact {closed}: undock with `force` if it stands docked"
        )
