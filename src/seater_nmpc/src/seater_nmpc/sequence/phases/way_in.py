"""APPROACH and FINAL: along the planned way to the front of the bay, then straight in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.control.command import Command
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.plan.back_off import BackOff
from seater_nmpc.plan.corridor import Corridor, room_beyond, straight_in
from seater_nmpc.sequence.goal.results import GoalEnd, Phase, ResultCode
from seater_nmpc.sequence.phases.context import STANDING, Asked, Context
from seater_nmpc.sequence.phases.installation_check import InstallationCheck

Array = NDArray[np.float64]

_NEAR = 0.03  # [m] from the dock, where a chair that does not drive on is helped by a small move
_STOPPING_MARGIN = 0.001  # [m] short of the dock at which it may come to rest


class WayIn:
    """Errors (3,): the chair in the dock's frame."""

    def __init__(self, context: Context, check: InstallationCheck) -> None:
        self._context, self._check = context, check
        self._corridor = Corridor(context.chair, context.dock, context.parameters)
        self._mouth = context.dock.bay.entrance_x - context.chair.length_front  # [m] its front is there
        self._room_beyond = room_beyond(context.chair, context.dock)
        self._back_off = BackOff(context.parameters.predock_position)
        self.restart()

    def restart(self) -> None:
        """A phase begins: plan and count standing anew."""
        self._back_off.forget()
        self._plan_anew()
        if self._context.goal.phase is not Phase.APPROACH:
            self._context.navigator.as_usual()

    def _plan_anew(self) -> None:
        self._context.stand_patiently()
        self._context.navigator.restart()

    @property
    def backs_off(self) -> bool:
        """Whether the chair backs away from where it got stuck."""
        return self._back_off.goes_on

    def first_phase(self, error: Array) -> Phase:
        """APPROACH, until the rest is a matter of driving straight in."""
        straight = self._is_straight(error)
        if self._check.wanted(error, straight=straight):
            return Phase.CHECK_INSTALLATION
        return self._straight if straight else Phase.APPROACH

    def approach(self, chair: Instant) -> Asked:
        """APPROACH: until the chair is, or would come to rest, in the corridor, or has arrived at the predock point."""
        c = self._context
        error = c.look(chair)
        self._look_at_the_walls(error)
        if self._is_straight(error) or self._is_straight(c.rest_error(chair)):
            return self._on(error)
        if c.is_at(c.dock.predock_x, error, chair) and c.navigator.straight_way_clear(error):
            return self._on(error)
        backing = self._away_from_where_it_is_stuck(chair, error)
        return self._along_the_way(chair, error) if backing is None else backing

    def final(self, chair: Instant) -> Asked:
        """FINAL: straight in, until the chair would come to rest at the dock."""
        c = self._context
        error = c.look(chair)
        self._look_at_the_walls(error)
        rest, speeds = c.rest_error(chair), c.speeds(chair)
        c.goal.expected_rest = None
        if self._corridor.missed(error) and self._corridor.missed(rest):
            return c.try_again(ResultCode.FAILED_TO_STAGE, "outside the corridor at the bay")
        short = max(-self._room_beyond, c.goal.overshoot)  # beyond the dock: from there it will roll back
        if rest[0] + short >= -self._stopping_margin(speeds):
            c.goal.expected_rest = float(rest[0]), float(rest[2])
            return Phase.STOPPING
        if c.standstill.in_place(chair.stamp, rest + np.array([short, 0.0, 0.0])):
            c.goal.expected_rest = -short, float(rest[2])  # what is missing is left out by the next one
            return Phase.STOPPING
        near, hovers = bool(abs(error[0]) <= _NEAR), c.standstill.stuck(chair.stamp, error)
        if near and hovers:  # to and fro: castors that swing round push it away again each time
            return Phase.STOPPING
        if c.standstill.stalled(chair.stamp, c.measured(chair), near=near):
            return Phase.STOPPING if near else c.try_again(ResultCode.NOT_WITHIN_TOLERANCE, "stands short of the dock")
        return c.drive(chair, straight_in(error, short, -c.goal.overturn))

    def _look_at_the_walls(self, error: Array) -> None:
        """A chair ahead of the bay does not go in where the walls surely are elsewhere. Raises GoalEnd."""
        c = self._context
        if c.goal.staging or error[0] > self._mouth:
            return
        wrong = c.watch.installation.walls()
        if wrong is not None:
            raise GoalEnd(ResultCode[wrong.kind.name], f"in front of the bay: {wrong.text}")

    def _on(self, error: Array) -> Phase:
        return Phase.CHECK_INSTALLATION if self._check.wanted(error, straight=True) else self._straight

    @property
    def _straight(self) -> Phase:
        """The phase that drives straight."""
        return Phase.STAGING if self._context.goal.staging else Phase.FINAL

    def _is_straight(self, error: Array) -> bool:
        """Whether the rest is a matter of driving straight in."""
        c = self._context
        c.navigator.see(c.controller.obstacles)
        return self._corridor.contains(error) and c.navigator.straight_way_clear(error)

    def _away_from_where_it_is_stuck(self, chair: Instant, error: Array) -> Command | None:
        """Where the optimisation sees no way on from (a corner of a wall close ahead), the chair backs off and plans
        anew with more room; None: it is not stuck, or has backed off."""
        c = self._context
        stalled = c.standstill.stalled(chair.stamp, c.measured(chair))
        if not self._back_off.goes_on and (c.standstill.stuck(chair.stamp, error) or stalled):
            self._back_off.begin(chair.stamp, error)
            c.navigator.give_room()
        if not self._back_off.goes_on:
            return None
        target = self._back_off.target(chair.stamp, error)
        if target is not None:
            return c.drive(chair, target)
        self._plan_anew()
        return None

    def _along_the_way(self, chair: Instant, error: Array) -> Command:
        """As planned; where no way is found, straight for the predock point unless the bay is blocked."""
        c = self._context
        target, c.goal.no_way = c.navigator.target(error), ""
        if target is not None:
            return c.drive(chair, target)
        if c.navigator.blocked():
            c.controller.reset()
            c.goal.no_way = c.navigator.reason or "obstacles leave no way into the bay"
            return replace(STANDING, text=c.goal.no_way)
        return c.drive(chair, "predock")

    def _stopping_margin(self, speeds: tuple[float, float]) -> float:
        """Half of what is driven until the next cycle: stopping then would be worse."""
        return _STOPPING_MARGIN + 0.5 * abs(speeds[0]) * self._context.controller.period
