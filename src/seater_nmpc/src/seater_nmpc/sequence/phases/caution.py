"""What comes before every phase that drives: stand while too little is known, and drive no faster than images allow."""

from __future__ import annotations

import math
from dataclasses import replace

from seater_common.se2 import relative
from seater_common.separation import edge_distances, footprints
from seater_nmpc.control.command import Command
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.plan.corridor import Corridor
from seater_nmpc.sequence.goal.results import GoalEnd, Phase, ResultCode
from seater_nmpc.sequence.phases.context import IMAGES_THAT_MAY_FAIL, STANDING, Asked, Context
from seater_nmpc.sequence.phases.finding import Finding

_BY_SIGHT = (Phase.APPROACH, Phase.FINAL, Phase.RETRY, Phase.CORRECTING, Phase.STAGING, Phase.CHECK_INSTALLATION)
_DRIVING = (*_BY_SIGHT, Phase.UNDOCKING, Phase.SEARCHING)
_NEAR, _FAR = 0.15, 0.6  # [m] before the dock
_GROWTH = 6.0  # [1/m] of `arrival_way` with the distance between them
_CORE = 0.5  # times the footprint: hulls of what stands close by may reach as far into it
_BRAKING = 0.5  # of `a_max`, farther away


class Caution:
    """Ask it in each cycle before the phase."""

    def __init__(self, context: Context, finding: Finding) -> None:
        self._context, self._finding = context, finding
        self._corridor = Corridor(context.chair, context.dock, context.parameters)
        middle = context.chair.corners().mean(axis=0)
        self._core = middle + _CORE * (context.chair.corners() - middle)
        self.begin()

    def begin(self) -> None:
        """A goal begins, or goes on after a pause."""
        self._blind_since: float | None = None
        self._unsure_since: float | None = None

    def wait(self, chair: Instant) -> Asked | None:
        """Stand while it is not known what is in the way, or the dock is out of sight; None: go on. Raises GoalEnd."""
        unsure = self._wait_to_be_sure(chair)
        if unsure is not None or self._context.goal.phase not in _BY_SIGHT:
            return unsure
        return self._wait_for_sight(chair)

    def limit_speed(self, backs_out: bool) -> None:
        """So that a few images may fail before the chair has driven `max_blind_distance`; backing out is slow, and so
        are the last centimetres before the dock.

        Undocking goes by odometry alone.
        """
        phase, period = self._context.goal.phase, self._context.observer.images.period
        if phase not in _BY_SIGHT and not backs_out:
            return
        p = self._context.parameters
        v, why = math.inf, f"images come only every {period:.2f} s"
        if phase is not Phase.UNDOCKING:
            v = p.max_blind_distance / max(IMAGES_THAT_MAY_FAIL * period, 1e-3)
        if backs_out and p.back_out_speed <= v:
            v, why = p.back_out_speed, ""  # as it should be: nothing to warn of
        if phase is Phase.FINAL and (arrival := self._arrival_speed()) <= v:
            v, why = arrival, ""
        self._context.controller.pace.limit(v=v, why=why)

    def _arrival_speed(self) -> float:
        """[m/s] at which what turns the chair aside (a wet spot, a castor) is seen and mended while there is way left
        to mend it: `arrival_way` is driven until images have shown it and the motors have answered. So ahead of the
        bay, too, where the chair would not pass into it yet."""
        c = self._context
        if c.goal.error is None:
            return math.inf
        drive, distance = c.controller.history, max(0.0, -float(c.goal.error[0]))
        reaction = drive.delay + drive.drive.lag_v + c.observer.images.period
        way = c.parameters.arrival_way * (1.0 + _GROWTH * max(0.0, min(distance, _FAR) - _NEAR))
        braking = 2.0 * _BRAKING * c.chair.limits.a_max * max(0.0, distance - _FAR)
        arrival = math.hypot(way / max(reaction, 1e-3), math.sqrt(braking))
        return min(arrival, self._corridor.speed(c.goal.error, reaction))

    def _wait_to_be_sure(self, chair: Instant) -> Command | None:
        """Stand while it is not known what is in the way; not for ever."""
        c = self._context
        unsure = c.goal.unsure or self._stood_on(chair)
        if not unsure or c.goal.phase not in _DRIVING:
            self._unsure_since = None
            return None
        if self._unsure_since is None:
            self._unsure_since = chair.stamp
        longest = c.parameters.obstacle_wait
        if chair.stamp - self._unsure_since > longest:
            raise GoalEnd(ResultCode.BLOCKED, f"waited for {longest:.0f} s to know what is in the way: {unsure}")
        c.controller.reset()
        c.stand_patiently()
        return replace(STANDING, text=f"waits to know what is in the way: {unsure}")

    def _stood_on(self, chair: Instant) -> str:
        """An outline that reaches far into the chair is none (another frame, millimetres, the chair itself seen): to
        get out of it would be to drive away blind, as far as it goes."""
        c, estimate = self._context, self._context.observer.estimate(chair.stamp)
        if estimate is None or not c.controller.obstacles:
            return ""
        core = footprints(self._core, relative(estimate.pose, chair.pose)[None])
        if all(edge_distances(core, outline)[0] >= 0.0 for outline in c.controller.obstacles):
            return ""
        return "an obstacle is told where the chair itself stands"

    def _wait_for_sight(self, chair: Instant) -> Asked | None:
        """Stand while the dock has not been seen for too long; not for ever."""
        c, p = self._context, self._context.parameters
        estimate = c.estimate(chair)
        if not c.blind(estimate):
            self._blind_since = None
            return None
        if self._blind_since is None:
            self._blind_since = chair.stamp
            c.controller.reset()
        waited = chair.stamp - self._blind_since
        if self._finding.turned_away(chair, estimate) and waited > p.search_after:
            return self._finding.turn_back(estimate.pose)
        if waited > p.max_blind_wait:
            how = f"no marker used for {estimate.blind_distance:.2f} m and {estimate.age:.1f} s"
            raise GoalEnd(ResultCode.MARKER_LOST, f"{how}: {c.observer.images.why_unseen}")
        return replace(STANDING, text=f"waits to see the dock: {c.observer.images.why_unseen}")
