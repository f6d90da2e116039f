"""STOPPING, CORRECTING and VERIFY: coming to rest at the dock, the small move if one is needed, the verification."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import inverse
from seater_nmpc.control.command import Command
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.sequence.goal.results import GoalEnd, Phase, ResultCode
from seater_nmpc.sequence.phases.context import STANDING, Asked, Context
from seater_nmpc.sequence.rest import way_on
from seater_nmpc.sequence.rest.correction import Correction, standing_dock
from seater_nmpc.sequence.rest.small_moves import SmallMoves
from seater_nmpc.sequence.rest.stops import Stops
from seater_nmpc.sequence.rest.verification import Verdict, Verification, within

Array = NDArray[np.float64]

_UNSEEN_IMAGES = 6  # times between two images
_OVERSHOT = np.array([0.008, 0.006])  # [m, rad] beside where a stop was to end, from which on the next allows for it
_UNSEEN = 2.0  # [s] that a standing chair waits at least for images before verification decides
_OPENED = 0.5  # [s] without contact: no mere bounce of it
_VERDICTS = {
    Verdict.DOCKED: ResultCode.SUCCESS,
    Verdict.UNSEEN: ResultCode.MARKER_LOST,
}


class AtDock:
    """Errors (3,): the standing chair in the dock's frame."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._phase, self._stops = context.goal.phase, Stops()
        self._moves = SmallMoves(context.chair.limits, context.controller.history, context.parameters)
        self._driven_on = 0
        self.restart(context.goal.phase)

    def restart(self, phase: Phase) -> None:
        """This phase begins; moves are counted, and learned from, until the chair leaves the dock."""
        self._verification: Verification | None = None
        self._begun_by, self._phase = self._phase, phase
        self._stops.restart(moved=phase is Phase.STOPPING and self._begun_by is Phase.CORRECTING)
        if phase is Phase.WAITING_FOR_DOCK:
            goal = self._context.goal
            goal.overshoot, goal.overturn = self._stops.begin_docking().tolist()
        self._closed = self._context.goal.now  # the contact, when it was so last
        if phase not in (Phase.STOPPING, Phase.CORRECTING, Phase.VERIFY):
            self._driven_on = self._driven_on if phase is Phase.FINAL else 0
            self._moves.leave(back_soon=self._driven_on > 0)

    def stop(self, chair: Instant) -> Asked:
        """STOPPING: stand until enough images were taken at rest, then decide what is to be done."""
        c, p = self._context, self._context.parameters
        c.look(chair)
        motors_stand = self._stops.stand(chair, c.goal.deadlines.entered, c.controller.history)
        # Before the motors stand, one that they hold against its roll only seems to.
        if not c.standstill.has_stood(chair.stamp, c.measured(chair)) or chair.stamp < motors_stand:
            return STANDING
        since = max(c.standstill.since, motors_stand)
        fresh = c.observer.measurements_since(since)
        if len(fresh) < p.move_measurements:
            late = chair.stamp - since > max(_UNSEEN, _UNSEEN_IMAGES * c.observer.images.period)
            return Phase.VERIFY if late else STANDING
        c.goal.error = inverse(standing_dock(fresh))
        self._learn(c.goal.error)
        return self._decide(c.goal.error)

    def correct(self, chair: Instant) -> Asked:
        """CORRECTING: the small move, to its end."""
        c = self._context
        c.look(chair)
        move = self._moves.move
        assert move is not None  # set with the phase
        asked = move.speeds()
        if asked is None:
            return Phase.STOPPING
        self._stops.push(chair, asked[move.turning])
        return c.controller.move(chair.stamp, c.speeds(chair), *asked)

    def verify(self, chair: Instant) -> Asked:
        """VERIFY: stand until the images, and the contact if it is required, give the result. Raises GoalEnd."""
        c = self._context
        c.look(chair)
        if self._verification is None:
            self._verification = Verification(c.dock, c.parameters, c.require_contact, chair.stamp)
        unknown = self._verification.error is None
        v, verdict = self._verification.update(chair.stamp, chair, c.observer, c.goal.contact)
        creeps = not c.standstill.stands(chair.stamp, c.measured(chair)) and not self._verification.nudged
        if creeps or verdict is Verdict.MOVED:
            return Phase.STOPPING  # what the images said so far is of another place
        if self._verification.error is not None:
            c.goal.error, c.goal.covariance = self._verification.error, self._verification.covariance
            if unknown and self._needs_move():
                return Phase.CORRECTING
        if verdict is Verdict.PENDING:
            return Command(v=v, omega=0.0)
        if verdict is Verdict.DOCKED and c.goal.contact and c.parameters.charge_watch > 0.0:
            return Phase.HOLDING
        if verdict is Verdict.OUTSIDE:
            return c.try_again(ResultCode.NOT_WITHIN_TOLERANCE, verdict.value)
        if verdict is Verdict.NO_CONTACT:
            return c.give_up(ResultCode.FAILED_TO_CHARGE, verdict.value)
        why = f": {c.observer.images.why_unseen}" if verdict is Verdict.UNSEEN else ""
        raise GoalEnd(_VERDICTS[verdict], verdict.value + why)

    def hold(self, chair: Instant) -> Asked:
        """HOLDING: docked; stand for `charge_watch`, and dock again when the contact opens meanwhile. Raises GoalEnd.

        Only the goal's own consent moves the chair: once it has ended, an open contact moves nothing.
        """
        c, now = self._context, chair.stamp
        self._closed = now if c.goal.contact else self._closed
        if now - self._closed > _OPENED:
            return c.try_again(ResultCode.FAILED_TO_CHARGE, "the charging contact has opened again")
        if c.goal.contact and now - c.goal.deadlines.entered > c.parameters.charge_watch:
            raise GoalEnd(ResultCode.SUCCESS, Verdict.DOCKED.value)
        return replace(STANDING, text="docked, watches the contact")

    def _learn(self, error: Array) -> None:
        """Where the chair stands (3,) after a stop that was to end elsewhere."""
        goal, after_final = self._context.goal, self._begun_by is Phase.FINAL
        self._stops.ended(error, goal.expected_rest, first=after_final and not (goal.retries or self._driven_on))
        goal.expected_rest = None
        if after_final or self._begun_by is Phase.CORRECTING:
            self._stops.learn_roll(self._context.controller.history)
        off = self._stops.next_off
        if off is not None:
            goal.overshoot, goal.overturn = np.where(np.abs(off) > _OVERSHOT, off, 0.0).tolist()

    def _needs_move(self) -> bool:
        """Whether verification shows, beyond doubt, what the few images before it did not."""
        error, covariance = self._context.goal.error, self._context.goal.covariance
        assert error is not None and covariance is not None  # verification has them
        if not self._moves.are_surely_needed(error, covariance) or not self._choose(error).is_move:
            return False
        self._moves.begin(error)
        return True

    def _decide(self, error: Array) -> Phase:
        c, verdict = self._context, self._choose(error)
        last = self._is_last
        if verdict is Correction.TURN and self._moves.turn_in_vain(float(error[2])) and not last:
            verdict = Correction.AGAIN
        if verdict is not Correction.TURN and self._drives_on(error):
            return Phase.FINAL
        if verdict is Correction.STAY or (verdict is Correction.AGAIN and last and within(error, c.dock.tolerance)):
            return Phase.VERIFY
        if verdict is Correction.AGAIN:
            why = self._stops.roll.in_words + self._moves.in_words
            return c.try_again(ResultCode.NOT_WITHIN_TOLERANCE, "stands beside the dock" + why)
        self._moves.begin(error)
        return Phase.CORRECTING

    def _drives_on(self, error: Array) -> bool:
        """Whether it drives on to the dock before which it stands; if so, its next stop allows for its last one."""
        goal = self._context.goal
        last = None if self._stops.off is None else float(self._stops.off[0])
        overshoot = way_on.next_overshoot(last, goal.overshoot, self._stops.roll)
        if self._driven_on >= way_on.MOST:
            return False
        if not way_on.has_way_on(error, overshoot, self._stops.roll, self._context.parameters):
            return False
        self._driven_on, goal.overshoot = self._driven_on + 1, overshoot
        return True

    def _choose(self, error: Array) -> Correction:
        c = self._context
        verdict = self._moves.choose(error, self._stops.roll, c.controller.period)
        risky = verdict is Correction.TURN and self._moves.turns_shift and self._is_last
        return Correction.STAY if risky and within(error, c.dock.tolerance) else verdict

    @property
    def _is_last(self) -> bool:
        return self._context.goal.retries >= self._context.parameters.max_retries
