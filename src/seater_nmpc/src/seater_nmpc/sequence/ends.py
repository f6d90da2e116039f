"""What ends a goal whatever its phase: a cancel, lost odometry, time that ran out, a contradiction."""

from __future__ import annotations

import math

from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.plausibility.watch import Watch
from seater_nmpc.sequence.goal.results import GoalEnd, Phase, ResultCode
from seater_nmpc.sequence.phases.context import Context

_AWAY = 0.3  # [m] from the docking pose: nothing closes there, however roughly the dock is known
_STUCK = 0.5  # [s] closed there without a break: no spike on the line
_UNSEEN = 1.0  # [s] without a used image, from which on a text says why


class Ends:
    """Asked in each cycle before the phases."""

    def __init__(self, context: Context, watch: Watch) -> None:
        self._context, self._watch = context, watch
        self.cancelled = False
        self._away_from = math.inf  # [s] since when the contact is closed though the chair is away from the dock

    def check_inputs(self, now: float) -> None:
        """What ends every goal, paused or not; `now` [s] becomes the goal's time. Raises GoalEnd."""
        goal, newest = self._context.goal, self._context.observer.odometry.newest
        if self.cancelled:
            raise GoalEnd(ResultCode.CANCELED, "cancelled")
        if not math.isfinite(now) or now < goal.now or newest is None:
            raise GoalEnd(ResultCode.ODOMETRY_LOST, "no odometry, or its time went backward")
        goal.now = now
        if now - newest.stamp > self._context.parameters.odometry_timeout:
            raise GoalEnd(ResultCode.ODOMETRY_LOST, f"newest odometry is {now - newest.stamp:.2f} s old")

    def check(self, now: float) -> Instant | None:
        """What ends every phase, too; the chair at `now` [s], None while it has to stand: the odometry is late but not
        lost yet, or images are to say what the matter is.

        Raises GoalEnd.
        """
        self.check_inputs(now)
        goal, observer = self._context.goal, self._context.observer
        late = goal.deadlines.missed(now, goal.phase)
        if late is not None:
            code, text = late
            unseen = code is ResultCode.FAILED_TO_DETECT_DOCK
            raise GoalEnd(code, f"{text}: {observer.images.why_unseen}" if unseen else self._with_reason(text))
        self._check_contact(now)
        found = self._watch.check(now)
        if found is not None:
            raise GoalEnd(ResultCode[found.kind.name], found.text)
        return None if self._watch.waits else observer.odometry.at(now)

    def _check_contact(self, now: float) -> None:
        """A contact that is closed out there would be closed at the dock, too, and prove nothing. Raises GoalEnd."""
        goal = self._context.goal
        way = 0.0 if goal.error is None else math.hypot(goal.error[0], goal.error[1])
        if not goal.contact or way < _AWAY or goal.phase not in (Phase.APPROACH, Phase.FINAL):
            self._away_from = math.inf
            return
        self._away_from = min(self._away_from, now)
        if now - self._away_from > _STUCK:
            text = f"the charging contact is closed {way:.1f} m before the dock: does it stick, is its line bridged?"
            raise GoalEnd(ResultCode.INCONSISTENT, text)

    def _with_reason(self, text: str) -> str:
        """The text, and why there is no way into the bay or no image is used, if that is so."""
        observer = self._context.observer
        estimate = observer.estimate()
        unseen = estimate is not None and estimate.age > _UNSEEN
        reason = self._context.goal.no_way or (observer.images.why_unseen if unseen else "")
        return f"{text}: {reason}" if reason else text
