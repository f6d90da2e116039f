"""What the chair does in each phase of a goal, and when one phase gives way to another."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_common.se2 import compose, inverse, relative
from seater_nmpc.control.command import Command
from seater_nmpc.control.controller import DockingController, Target
from seater_nmpc.observe.motion import MotionObserver
from seater_nmpc.observe.observer import DockEstimate, DockObserver
from seater_nmpc.observe.odometry import Instant
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.plan.corridor import Corridor, straight_in
from seater_nmpc.plan.front import Front
from seater_nmpc.plan.navigator import Navigator
from seater_nmpc.plan.way_back import WayBack
from seater_nmpc.sequence.goal.deadlines import Deadlines
from seater_nmpc.sequence.goal.results import Phase, ResultCode
from seater_nmpc.sequence.phases.search import SWEEPS, Search
from seater_nmpc.sequence.rest.correction import Verdict as Correction
from seater_nmpc.sequence.rest.correction import judge, standing_dock
from seater_nmpc.sequence.rest.fine_move import FineMove
from seater_nmpc.sequence.rest.standstill import Standstill
from seater_nmpc.sequence.rest.verification import Verdict, Verification, within

Array = NDArray[np.float64]

STANDING = Command(v=0.0, omega=0.0)
_MOVING = (Phase.APPROACH, Phase.FINAL, Phase.RETRY, Phase.CORRECTING)
_BACKING_OUT = (Phase.RETRY, Phase.UNDOCKING)
_DRIVING = (*_MOVING, Phase.UNDOCKING, Phase.SEARCHING)
_DOCK_ANYWHERE = (Phase.WAITING_FOR_DOCK, Phase.SEARCHING, Phase.UNDOCKING)  # none drives by where the dock was seen
_UNDOCKED_SPEED = 0.1  # [m/s] below which the chair near the predock point has arrived there
_IMAGES_THAT_MAY_FAIL = 4  # in a row, the time until the next one arrives reckoned in
_NEAR = 0.03  # [m] from the dock, where a chair that does not drive on is helped by a small move
_BACK_OFF, _BACK_OFF_TIME = 0.6, 8.0  # [m, s] that the chair backs off where it got stuck
_WELL_IN_FRONT = 0.3  # [m] nearer to the bay or farther from it, the side wall would (not) hide the markers either
_ASIDE = 0.35  # [rad] of the camera's axis, from which on markers may be out of view
_SEEN_NOW = 0.5  # [s] or a few images: a dock seen so lately is in view
_LANE = (0.3, 0.5)  # [m, rad] beside the dock's axis and ahead of the predock point, where a chair may back out
_SURE = 0.5  # of the speed up to which the chair stands: as sure the odometry is to be of it
_STOPPING_MARGIN = 0.001  # [m] short of the dock at which it may come to rest
_UNSEEN_IMAGES = 6  # times between two images
_UNSEEN = 2.0  # [s] that a standing chair waits at least for images before verification decides
_VERDICTS = {
    Verdict.DOCKED: ResultCode.SUCCESS,
    Verdict.UNSEEN: ResultCode.MARKER_LOST,
    Verdict.NO_CONTACT: ResultCode.FAILED_TO_CHARGE,
}


class GoalEnd(Exception):  # noqa: N818 - not an error: how a phase hands its result up
    """The goal ends with this result."""

    def __init__(self, code: ResultCode, text: str) -> None:
        self.code, self.text = code, text


class Phases:
    """The phases of one goal after another. `begin` a goal, then ask for one `command` per control cycle.

    A phase that gives way to another one within a cycle hands over at once. The end of a goal is raised as GoalEnd.
    """

    def __init__(
        self,
        chair: Chair,
        dock: Dock,
        controller: DockingController,
        observer: DockObserver,
        motion: MotionObserver,
        navigator: Navigator,
        parameters: SequenceParameters,
        *,
        require_contact: bool,
    ) -> None:
        self._chair, self._dock, self._controller, self._observer = chair, dock, controller, observer
        self._motion, self._navigator, self._parameters = motion, navigator, parameters
        self._require_contact = require_contact
        self._corridor, self._front = Corridor(chair, dock, parameters), Front(chair, dock)
        self._way_back = WayBack(chair, dock, controller.parameters.stop_margin)
        self._handlers: dict[Phase, Callable[[Instant], Command]] = {
            Phase.WAITING_FOR_DOCK: self._wait,
            Phase.SEARCHING: self._find,
            Phase.APPROACH: self._approach,
            Phase.FINAL: self._final,
            Phase.STOPPING: self._stop,
            Phase.CORRECTING: self._correct,
            Phase.VERIFY: self._verify,
            Phase.RETRY: self._retry,
            Phase.UNDOCKING: self._undock,
        }
        self.contact: bool | None = None  # the charging contact, None: not known
        self.force = False  # undock from here, whatever is known
        self.unsure = ""  # why it is not known what is in the way; empty: it is
        self.held_by = ""  # why the safety gate holds the chair; empty: it does not
        self.begin(0.0, Phase.WAITING_FOR_DOCK, 0.0)

    def begin(self, now: float, phase: Phase, timeout: float) -> None:
        """A goal begins at message time `now` [s] with this phase; it may take `timeout` [s]."""
        self.now, self.retries = now, 0
        self.deadlines = Deadlines(self._parameters.timeouts, now, timeout)
        self.error: Array | None = None  # (3,) the chair in the dock's frame, once known
        self.covariance: Array | None = None  # (3, 3) of the error, by the images alone, once verified
        self.T_odom_dock: Array | None = None
        self._controller.history.clear()  # whoever drove until now did not say
        self.no_way = ""  # why there is no way into the bay
        self._rough: Array | None = self._observer.prior  # the dock in odom, where it is looked for
        self._blind_since: float | None = None
        self._unsure_since: float | None = None
        self._lost = False  # out of sight on the approach, and looked for
        self._went_round = False  # to the front of the bay, as far as the way is clear
        self._controller.set_speed_limit()
        self._enter(phase)

    def resume(self, now: float, paused: float) -> None:
        """Go on with the goal after a pause of `paused` [s], from wherever the chair is now [message time]."""
        self.now = now
        self.deadlines.put_off(paused)
        self._controller.history.clear()
        self._blind_since = self._unsure_since = None
        self._lost = self._went_round = False
        self._enter(Phase.UNDOCKING if self.phase is Phase.UNDOCKING else Phase.WAITING_FOR_DOCK)

    def command(self, chair: Instant) -> Command:
        """What the present phase asks for. Raises GoalEnd."""
        unsure = self._wait_to_be_sure(chair)
        if unsure is not None:
            return unsure
        if self.phase in _MOVING:
            waiting = self._wait_for_sight(chair)
            if waiting is not None:
                return waiting
        if self.phase in _MOVING or self.backs_out:
            self._limit_speed()
        return self._handlers[self.phase](chair)

    def _wait_to_be_sure(self, chair: Instant) -> Command | None:
        """Stand while it is not known what is in the way; not for ever."""
        if not self.unsure or self.phase not in _DRIVING:
            self._unsure_since = None
            return None
        if self._unsure_since is None:
            self._unsure_since = chair.stamp
        longest = self._parameters.obstacle_wait
        if chair.stamp - self._unsure_since > longest:
            raise GoalEnd(ResultCode.BLOCKED, f"waited for {longest:.0f} s to know what is in the way: {self.unsure}")
        self._controller.reset()
        self.stand_patiently()
        return replace(STANDING, text=f"waits to know what is in the way: {self.unsure}")

    def _wait_for_sight(self, chair: Instant) -> Command | None:
        """Stand while the dock has not been seen for too long; not for ever."""
        estimate, p = self._observer.estimate(chair.stamp), self._parameters
        if estimate is None:
            raise GoalEnd(ResultCode.MARKER_LOST, "the dock is not known")
        if not self.blind(estimate):
            self._blind_since = None
            return None
        if self._blind_since is None:
            self._blind_since = chair.stamp
            self._controller.reset()
        if self._turned_away(chair, estimate) and chair.stamp - self._blind_since > p.search_after:
            self._enter(Phase.SEARCHING)
            self._lost, self._rough = True, estimate.pose
            return self._find(chair)
        if chair.stamp - self._blind_since > p.max_blind_wait:
            how = f"no marker used for {estimate.blind_distance:.2f} m and {estimate.age:.1f} s"
            raise GoalEnd(ResultCode.MARKER_LOST, f"{how}: {self._observer.why_unseen}")
        return replace(STANDING, text=f"waits to see the dock: {self._observer.why_unseen}")

    def _turned_away(self, chair: Instant, estimate: DockEstimate) -> bool:
        """Whether the dock may be out of view because the chair has turned too far, once in a goal, on the approach."""
        if self.phase is not Phase.APPROACH or self._lost:
            return False
        return abs(self._front.aside(relative(estimate.pose, chair.pose))) > _ASIDE

    def _limit_speed(self) -> None:
        """So that a few images may fail before the chair has driven `max_blind_distance`; and backing out is slow.

        Undocking goes by odometry alone.
        """
        p, period = self._parameters, self._observer.image_period
        v, why = math.inf, f"images come only every {period:.2f} s"
        if self.phase is not Phase.UNDOCKING:
            v = p.max_blind_distance / max(_IMAGES_THAT_MAY_FAIL * period, 1e-3)
        if self.backs_out and p.back_out_speed <= v:
            v, why = p.back_out_speed, ""  # as it should be: nothing to warn of
        self._controller.set_speed_limit(v=v, why=why)

    @property
    def backs_out(self) -> bool:
        """Whether the chair is backing out, for another attempt or away from where it got stuck."""
        return self.phase in _BACKING_OUT or self._back_off is not None

    def blind(self, estimate: DockEstimate) -> bool:
        """Whether the dock was seen too long ago, in time or way driven, to move towards it, or is seen elsewhere."""
        p = self._parameters
        if self._observer.contradicted:
            return True
        return estimate.blind_distance > p.max_blind_distance or estimate.age > p.max_blind_time

    def _enter(self, phase: Phase) -> None:
        self.phase = phase
        self.deadlines.enter(self.now)
        self._plan_anew()
        self._verification: Verification | None = None
        if phase not in (Phase.STOPPING, Phase.CORRECTING):
            self._moves = 0
            self._fine_move: FineMove | None = None
        self._search: Search | None = None
        self._way_back.restart()
        self._observer.acquire_moving(phase is Phase.SEARCHING)
        self._observer.bound_reacquisition(phase not in _DOCK_ANYWHERE)
        if phase in (Phase.WAITING_FOR_DOCK, Phase.VERIFY, Phase.UNDOCKING):
            self._controller.reset()

    def stand_patiently(self) -> None:
        """Count standing anew."""
        self._standstill = Standstill(self._parameters, self.now)

    def _plan_anew(self) -> None:
        """Plan and count standing anew."""
        self._back_off: Array | None = None  # where the chair backs off to
        self._back_off_until = 0.0
        self.stand_patiently()
        self._navigator.restart()

    def _look(self, chair: Instant) -> Array:
        """The chair in the dock's frame (3,), after making sure that the dock is known well enough to move."""
        estimate = self._observer.estimate(chair.stamp)
        if estimate is None:
            raise GoalEnd(ResultCode.MARKER_LOST, "the dock is not known")
        self.T_odom_dock = estimate.pose
        self.error = relative(estimate.pose, chair.pose)
        return self.error

    def _drive(self, chair: Instant, target: Target) -> Command:
        assert self.T_odom_dock is not None  # every caller has looked
        motion = self._speeds(chair)
        command = self._controller.command(chair.pose, motion, self.T_odom_dock, target, chair.stamp)
        failures = self._controller.counters.consecutive_failures
        if failures >= self._controller.parameters.fallback.max_consecutive:
            raise GoalEnd(ResultCode.FAILED_TO_CONTROL, f"{failures} cycles without a solution: {command.text}")
        return command

    def _speeds(self, chair: Instant) -> tuple[float, float]:
        """(v, omega) of the chair, less the errors of its odometry."""
        return self._observer.true_speeds(*self._motion.at(chair.stamp), chair.stamp)

    def _measured(self, chair: Instant) -> tuple[float, float]:
        """(v, omega) as the odometry's poses have it over `standing_time`, less its errors."""
        p = self._parameters
        speeds = self._observer.odometry.mean_speeds(p.standing_time, _SURE * p.standing_speed)
        speeds = speeds or (chair.v, chair.omega)
        return self._observer.true_speeds(*speeds, chair.stamp)

    def _wait(self, chair: Instant) -> Command:
        if not self._in_view(chair):
            waited = self.now - self.deadlines.entered
            if self._rough is not None and waited >= self._parameters.search_after:
                self._enter(Phase.SEARCHING)
                return self._find(chair)
            return STANDING
        error = self._look(chair)
        if math.hypot(error[0], error[1]) > self._parameters.max_start_distance:
            raise GoalEnd(ResultCode.DOCK_NOT_VALID, f"the dock is {math.hypot(error[0], error[1]):.1f} m away")
        if within(error, self._dock.tolerance) and (self.contact or not self._require_contact):
            raise GoalEnd(ResultCode.ALREADY_DOCKED, "already docked")
        if self._front.hidden(error - [_WELL_IN_FRONT, 0.0, 0.0]) and not self._went_round:
            self._enter(Phase.SEARCHING)
            return self._find(chair)
        self._enter(Phase.FINAL if self._way_in(error) else Phase.APPROACH)
        return self._handlers[self.phase](chair)

    def _find(self, chair: Instant) -> Command:
        """Look for the dock by the rough pose; as soon as it is found, go on as if it had been in view.

        Where it is seen from beside the bay only, drive round to the front first.
        """
        known = self._in_view(chair)
        if known and self._seen_now(chair) and self._well_in_front(self._look(chair)):
            return self._wait(chair)
        self._rough = self.T_odom_dock if known else self._rough
        assert self._rough is not None  # or there would be nothing to look for
        here = relative(self._rough, chair.pose)
        if self._search is None:
            first = () if known else SWEEPS[:1] if self._lost or self._front.hidden(here) else SWEEPS
            self._search = Search(
                self._chair, self._dock, self._observer.image_period, first=first, go=known or not self._lost
            )
        speeds = self._speeds(chair)
        rest = relative(self._rough, self._controller.rest_pose(chair.stamp, chair.pose, speeds))
        asked = self._search.speeds(chair.stamp, here, rest, self._controller.obstacles)
        if asked is not None:
            return self._controller.move(chair.stamp, speeds, *asked)
        if self._lost and not known:
            raise GoalEnd(ResultCode.MARKER_LOST, f"turned back to it in vain: {self._observer.why_unseen}")
        if not known:
            raise GoalEnd(ResultCode.FAILED_TO_DETECT_DOCK, f"looked all round for it: {self._observer.why_unseen}")
        self._went_round = True  # as far as it could
        return self._wait(chair)

    def _well_in_front(self, error: Array) -> bool:
        """Whether the markers can be seen nearer and farther, too: then waiting does not send it to search again."""
        return not any(self._front.hidden(error + [shift, 0.0, 0.0]) for shift in (_WELL_IN_FRONT, -_WELL_IN_FRONT))

    def _in_view(self, chair: Instant) -> bool:
        """Whether the dock is known and has been seen not too long ago."""
        estimate = self._observer.estimate(chair.stamp)
        return estimate is not None and not self.blind(estimate)

    def _seen_now(self, chair: Instant) -> bool:
        estimate = self._observer.estimate(chair.stamp)
        lately = max(_SEEN_NOW, _IMAGES_THAT_MAY_FAIL * self._observer.image_period)
        return estimate is not None and estimate.age <= lately

    def _approach(self, chair: Instant) -> Command:
        error = self._look(chair)
        in_corridor = self._way_in(error) or self._way_in(self._rest_error(chair))
        if in_corridor or (self._at_predock(error, chair) and self._navigator.straight_way_clear(error)):
            self._enter(Phase.FINAL)
            return self._final(chair)
        return self._go(chair, error)

    def _go(self, chair: Instant, error: Array) -> Command:
        """Along the planned way; where none is found, straight for the predock point unless the bay is blocked.

        Where the optimisation sees no way on from (a corner of a wall close ahead), the chair backs off and plans anew.
        """
        stalled = self._standstill.stalled(chair.stamp, self._measured(chair))
        if self._back_off is None and (self._standstill.stuck(chair.stamp, error) or stalled):
            self._back_off = compose(error, [-_BACK_OFF, 0.0, 0.0])
            self._back_off_until = chair.stamp + _BACK_OFF_TIME
        if self._back_off is not None:
            far = math.dist(error[:2], self._back_off[:2]) > self._parameters.predock_position
            if far and chair.stamp < self._back_off_until:
                return self._drive(chair, self._back_off)
            self._plan_anew()
        target, self.no_way = self._navigator.target(error), ""
        if target is not None:
            return self._drive(chair, target)
        if self._navigator.blocked():
            self._controller.reset()
            self.no_way = self._navigator.reason or "obstacles leave no way into the bay"
            return replace(STANDING, text=self.no_way)
        return self._drive(chair, "predock")

    def _way_in(self, error: Array) -> bool:
        """Whether the rest is a matter of driving straight in."""
        self._navigator.see(self._controller.obstacles)
        return self._corridor.contains(error) and self._navigator.straight_way_clear(error)

    def _final(self, chair: Instant) -> Command:
        error = self._look(chair)
        rest, speeds = self._rest_error(chair), self._speeds(chair)
        if self._corridor.missed(error) and self._corridor.missed(rest):
            return self._try_again(chair, ResultCode.FAILED_TO_STAGE, "outside the corridor at the bay")
        if rest[0] >= -self._stopping_margin(speeds) or self._standstill.in_place(chair.stamp, rest):
            self._enter(Phase.STOPPING)
            return STANDING
        near = bool(abs(error[0]) <= _NEAR)
        if self._standstill.stalled(chair.stamp, self._measured(chair), near=near):
            if near:
                self._enter(Phase.STOPPING)
                return STANDING
            return self._try_again(chair, ResultCode.NOT_WITHIN_TOLERANCE, "stands short of the dock")
        return self._drive(chair, straight_in(error))

    def _rest_error(self, chair: Instant) -> Array:
        """Where the chair would come to rest if it were asked to stand now, in the dock's frame (3,)."""
        assert self.T_odom_dock is not None  # every caller has looked
        return relative(self.T_odom_dock, self._controller.rest_pose(chair.stamp, chair.pose, self._speeds(chair)))

    def _stopping_margin(self, speeds: tuple[float, float]) -> float:
        """Half of what is driven until the next cycle: stopping then would be worse."""
        return _STOPPING_MARGIN + 0.5 * abs(speeds[0]) * self._controller.period

    def _stop(self, chair: Instant) -> Command:
        self._look(chair)
        if not self._standstill.has_stood(chair.stamp, self._measured(chair)):
            return STANDING
        fresh, p = self._observer.measurements_since(self._standstill.since), self._parameters
        if len(fresh) < p.move_measurements:
            if chair.stamp - self._standstill.since > max(_UNSEEN, _UNSEEN_IMAGES * self._observer.image_period):
                self._enter(Phase.VERIFY)
            return STANDING
        self.error = inverse(standing_dock(fresh))
        return self._decide(chair, self.error)

    def _decide(self, chair: Instant, error: Array) -> Command:
        verdict = self._choose(error)
        last = self.retries >= self._parameters.max_retries
        if verdict is Correction.STAY or (verdict is Correction.AGAIN and last and within(error, self._dock.tolerance)):
            self._enter(Phase.VERIFY)
            return STANDING
        if verdict is Correction.AGAIN:
            return self._try_again(chair, ResultCode.NOT_WITHIN_TOLERANCE, "stands beside the dock")
        self._enter(Phase.CORRECTING)
        self._moves += 1
        return self._correct(chair)

    def _choose(self, error: Array) -> Correction:
        """What is to be done; `_fine_move` is the move, if one is."""
        before, use = self._fine_move, {"turn": True, "move": True}
        while True:
            verdict = judge(error, self._moves, self._parameters, **use)
            if verdict not in (Correction.TURN, Correction.MOVE):
                return verdict
            turning, drive = verdict is Correction.TURN, self._controller.history.drive
            move = FineMove(error, turning, drive, self._chair.limits, self._controller.period, before)
            if move.is_worthwhile:
                self._fine_move = move
                return verdict
            use["turn" if turning else "move"] = False

    def _correct(self, chair: Instant) -> Command:
        self._look(chair)
        assert self._fine_move is not None  # set with the phase
        asked = self._fine_move.speeds()
        if asked is None:
            self._enter(Phase.STOPPING)
            return STANDING
        return self._controller.move(chair.stamp, self._speeds(chair), *asked)

    def _verify(self, chair: Instant) -> Command:
        self._look(chair)
        if self._verification is None:
            self._verification = Verification(self._dock, self._parameters, self._require_contact, chair.stamp)
        v, verdict = self._verification.update(chair.stamp, chair, self._observer, self.contact)
        creeps = not self._standstill.stands(chair.stamp, self._measured(chair)) and not self._verification.nudged
        if creeps or verdict is Verdict.MOVED:
            self._enter(Phase.STOPPING)  # what the images said so far is of another place
            return STANDING
        if self._verification.error is not None:
            self.error, self.covariance = self._verification.error, self._verification.covariance
        if verdict is Verdict.PENDING:
            return Command(v=v, omega=0.0)
        if verdict is Verdict.OUTSIDE:
            return self._try_again(chair, ResultCode.NOT_WITHIN_TOLERANCE, verdict.value)
        why = f": {self._observer.why_unseen}" if verdict is Verdict.UNSEEN else ""
        raise GoalEnd(_VERDICTS[verdict], verdict.value + why)

    def _retry(self, chair: Instant) -> Command:
        error, p = self._look(chair), self._parameters
        small = abs(error[1]) <= p.corridor_half_width and abs(error[2]) <= p.corridor_heading
        x = max(self._dock.predock_x, -p.retry_distance) if small else self._dock.predock_x
        if self._is_at(x, error, chair):
            self._enter(Phase.FINAL if self._way_in(error) else Phase.APPROACH)
            return self._handlers[self.phase](chair)
        return self._back_out(chair, np.array([x, 0.0, 0.0]))

    def _undock(self, chair: Instant) -> Command:
        if self.T_odom_dock is None:
            self.T_odom_dock = self._dock_to_leave(chair)
        self.error = relative(self.T_odom_dock, chair.pose)
        to_go = self.error - [self._dock.predock_x, 0.0, 0.0]
        p = self._parameters
        arrived = to_go[0] <= 0.0 or math.hypot(to_go[0], to_go[1]) <= p.predock_position
        if arrived and abs(chair.v) <= _UNDOCKED_SPEED:
            if self._standstill.has_stood(chair.stamp, self._measured(chair)):
                raise GoalEnd(ResultCode.SUCCESS, "undocked")
            return STANDING
        return self._back_out(chair, "predock")

    def _back_out(self, chair: Instant, target: Target) -> Command:
        """Out of the bay; something in the way, or so near that the chair gets nowhere, is waited for, not for ever."""
        assert self.error is not None  # every caller has looked
        outlines, longest = self._controller.obstacles, self._parameters.back_out_wait
        obstacle, waited = self._way_back.obstacle(self.error, outlines), self._way_back.update(chair.stamp, self.error)
        cause = obstacle or self.held_by or self._way_back.cause(self.error, outlines)
        if cause and waited > longest:
            raise GoalEnd(ResultCode.BLOCKED, f"waited for {longest:.0f} s to back out: {cause}")
        if obstacle:
            self._controller.reset()
            return replace(STANDING, text=f"waits to back out: {obstacle}")
        return self._drive(chair, target)

    def _dock_to_leave(self, chair: Instant) -> Array:
        """The dock in odom (3,): as known, however long ago it was seen, if the chair stands in it or on its way in or
        out; else where it is if the chair stands docked."""
        estimate, p = self._observer.estimate(chair.stamp), self._parameters
        if estimate is not None and estimate.blind_distance <= p.max_blind_distance:
            x, y, heading = relative(estimate.pose, chair.pose).tolist()
            if x >= self._dock.predock_x - _LANE[0] and abs(y) <= _LANE[0] and abs(heading) <= _LANE[1]:
                return estimate.pose
        if self.contact or self.force:
            return chair.pose
        why = "no dock is known here" if estimate is None else "the dock is known elsewhere"
        closed = "is not known" if self.contact is None else "is open"
        raise GoalEnd(
            ResultCode.NOT_DOCKED, f"{why}, and the contact {closed}: undock with `force` if it stands docked"
        )

    def _try_again(self, chair: Instant, code: ResultCode, why: str) -> Command:
        if self.retries >= self._parameters.max_retries:
            raise GoalEnd(code, f"{why}, after {self.retries} retries")
        self.retries += 1
        self._enter(Phase.RETRY)
        return self._retry(chair)

    def _at_predock(self, error: Array, chair: Instant) -> bool:
        return self._is_at(self._dock.predock_x, error, chair)

    def _is_at(self, x: float, error: Array, chair: Instant) -> bool:
        """Whether the chair is, slowly, at that place on the dock's axis."""
        p = self._parameters
        near = math.hypot(error[0] - x, error[1]) <= p.predock_position
        return near and abs(error[2]) <= p.predock_heading and abs(chair.v) <= _UNDOCKED_SPEED
