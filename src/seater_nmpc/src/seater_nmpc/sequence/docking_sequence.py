"""The docking sequence as a state machine in message time. No ROS.

    WAITING_FOR_DOCK -> APPROACH -> FINAL <-> STOPPING -> VERIFY -> done
                           ^          |                     |
                           +- RETRY <-+---------------------+      UNDOCKING -> done

Every goal ends in exactly one step with a result, and the command of that step is zero at once: what the chair then does
with its speed is limited by the safety gate, which brakes within the chair's limits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair, Dock
from seater_common.se2 import relative
from seater_nmpc.control.command import Command
from seater_nmpc.control.controller import DockingController, Target
from seater_nmpc.observe.innovation import Fusion
from seater_nmpc.observe.measurement import Hypothesis
from seater_nmpc.observe.motion import MotionObserver
from seater_nmpc.observe.observer import DockEstimate, DockObserver
from seater_nmpc.observe.odometry import Instant, Odometry
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.plan.corridor import Corridor
from seater_nmpc.plan.navigator import Navigator
from seater_nmpc.sequence.deadlines import Deadlines
from seater_nmpc.sequence.results import Phase, Result, ResultCode, Step
from seater_nmpc.sequence.standstill import Standstill
from seater_nmpc.sequence.verification import Verdict, Verification, within

Array = NDArray[np.float64]

_STANDING = Command(0.0, 0.0)
_MOVING = (Phase.APPROACH, Phase.FINAL, Phase.RETRY)
_UNDOCKED_SPEED = 0.1  # [m/s] below which the chair near the predock point has arrived there


class _End(Exception):  # noqa: N818 - not an error: how a phase hands its result up
    def __init__(self, code: ResultCode, text: str) -> None:
        self.code, self.text = code, text


class DockingSequence:
    """Docks and undocks. Feed it odometry and detections as they come; call `update` once per control cycle."""

    def __init__(
        self,
        chair: Chair,
        dock: Dock,
        controller: DockingController,
        observer: DockObserver,
        parameters: SequenceParameters | None = None,
        *,
        require_contact: bool = False,
        navigator: Navigator | None = None,
    ) -> None:
        """`navigator`: finds the way to the bay; None: one with default parameters."""
        self._navigator = navigator or Navigator(chair, dock, controller.parameters)
        self._chair, self._dock, self._controller, self.observer = chair, dock, controller, observer
        self._motion = MotionObserver(controller.history, observer.parameters)
        self._parameters = parameters or SequenceParameters()
        self._require_contact = require_contact
        self._handlers: dict[Phase, Callable[[Instant], Command]] = {
            Phase.WAITING_FOR_DOCK: self._wait,
            Phase.APPROACH: self._approach,
            Phase.FINAL: self._final,
            Phase.STOPPING: self._stop,
            Phase.VERIFY: self._verify,
            Phase.RETRY: self._retry,
            Phase.UNDOCKING: self._undock,
        }
        self.active = False
        self._corridor = Corridor(chair, dock, self._parameters)
        self._contact: bool | None = None
        self._begin(0.0, Phase.WAITING_FOR_DOCK, 0.0)
        self.active = False

    def start_dock(
        self, now: float, timeout: float = 0.0, prior: ArrayLike | None = None, prior_radius: float = 1.0
    ) -> None:
        """Begin to dock at message time `now` [s]. timeout 0: the configured one; `prior`: rough dock pose in odom.

        Raises:
            ValueError: when a goal is active, or a number is not finite or negative.
        """
        self._check_start(now, timeout)
        estimate = self.observer.estimate()
        if prior is not None or estimate is None or self._blind(estimate):
            self.observer.reset(prior, prior_radius)
        self._begin(now, Phase.WAITING_FOR_DOCK, timeout or self._parameters.timeouts.dock)

    def start_undock(self, now: float, timeout: float = 0.0) -> None:
        """Begin to back out to the predock point, by odometry from where the dock is known or taken to be.

        Where no fresh estimate is at hand, the chair is taken to stand docked. Raises: as `start_dock`.
        """
        self._check_start(now, timeout)
        self._begin(now, Phase.UNDOCKING, timeout or self._parameters.timeouts.undock)

    def cancel(self) -> None:
        """End the active goal with CANCELED in the next update."""
        self._cancelled = True

    def add_odometry(self, odometry: Odometry) -> bool:
        """Take an odometry message; false when it was refused and counted."""
        taken = self.observer.add_odometry(odometry)
        if taken:
            self._motion.add_odometry(odometry)
        return taken

    def add_detections(self, stamp: float, hypotheses: list[Hypothesis]) -> Fusion:
        """Take the dock observations of one image."""
        return self.observer.add_detections(stamp, hypotheses)

    def update(self, now: float, contact: bool | None = None) -> Step:
        """One control cycle at message time `now` [s]; `contact`: the charging contact, None when not known.

        Raises:
            ValueError: when no goal is active.
        """
        if not self.active:
            raise ValueError("no goal is active")
        self._contact = contact
        try:
            chair = self._check(now)
            command = _STANDING if chair is None else self._handlers[self._phase](chair)
        except _End as end:
            return self._finish(now, end.code, end.text)
        return self._step(now, command)

    def abort(self, now: float, code: ResultCode, text: str) -> Step:
        """End the active goal from outside (no more odometry, an error in the adapter): zero, with this result."""
        return self._finish(now, code, text)

    def _check_start(self, now: float, timeout: float) -> None:
        if self.active:
            raise ValueError("a goal is active already")
        if not (math.isfinite(now) and math.isfinite(timeout) and timeout >= 0.0):
            raise ValueError(f"timeout: is {timeout!r}, must be finite and >= 0")

    def _begin(self, now: float, phase: Phase, timeout: float) -> None:
        self.active, self._cancelled = True, False
        self._now, self._retries = now, 0
        self._deadlines = Deadlines(self._parameters.timeouts, now, timeout)
        self._error: Array | None = None
        self._T_odom_dock: Array | None = None
        self._controller.history.clear()  # whoever drove until now did not say
        self._enter(phase)

    def _enter(self, phase: Phase) -> None:
        self._phase = phase
        self._deadlines.enter(self._now)
        self._standstill = Standstill(self._parameters, self._now)
        self._verification: Verification | None = None
        self._navigator.restart()
        if phase in (Phase.WAITING_FOR_DOCK, Phase.STOPPING, Phase.VERIFY, Phase.UNDOCKING):
            self._controller.reset()

    def _check(self, now: float) -> Instant | None:
        """What ends every phase; the chair at `now`, None while the odometry is late but not lost yet."""
        if self._cancelled:
            raise _End(ResultCode.CANCELED, "cancelled")
        newest = self.observer.odometry.newest
        if not math.isfinite(now) or now < self._now or newest is None:
            raise _End(ResultCode.ODOMETRY_LOST, "no odometry, or its time went backward")
        self._now = now
        if now - newest.stamp > self._parameters.odometry_timeout:
            raise _End(ResultCode.ODOMETRY_LOST, f"newest odometry is {now - newest.stamp:.2f} s old")
        late = self._deadlines.missed(now, self._phase)
        if late is not None:
            raise _End(*late)
        return self.observer.odometry.at(now)

    def _look(self, chair: Instant) -> Array:
        """The chair in the dock's frame (3,), after making sure that the dock is known well enough to move."""
        estimate = self.observer.estimate(chair.stamp)
        if estimate is None:
            raise _End(ResultCode.MARKER_LOST, "the dock is not known")
        if self._phase in _MOVING and self._blind(estimate):
            how = f"{estimate.blind_distance:.2f} m and {estimate.age:.1f} s"
            raise _End(ResultCode.MARKER_LOST, f"no marker seen for {how}")
        self._T_odom_dock = estimate.pose
        self._error = relative(estimate.pose, chair.pose)
        return self._error

    def _blind(self, estimate: DockEstimate) -> bool:
        p = self._parameters
        return estimate.blind_distance > p.max_blind_distance or estimate.age > p.max_blind_time

    def _drive(self, chair: Instant, target: Target) -> Command:
        assert self._T_odom_dock is not None  # every caller has looked
        motion = self._motion.at(chair.stamp)
        command = self._controller.command(chair.pose, motion, self._T_odom_dock, target, chair.stamp)
        failures = self._controller.counters.consecutive_failures
        if failures >= self._controller.parameters.fallback.max_consecutive:
            raise _End(ResultCode.FAILED_TO_CONTROL, f"{failures} cycles without a solution: {command.text}")
        return command

    def _wait(self, chair: Instant) -> Command:
        estimate = self.observer.estimate(chair.stamp)
        if estimate is None or self._blind(estimate):
            return _STANDING
        error = self._look(chair)
        if math.hypot(error[0], error[1]) > self._parameters.max_start_distance:
            raise _End(ResultCode.DOCK_NOT_VALID, f"the dock is {math.hypot(error[0], error[1]):.1f} m away")
        if within(error, self._dock.tolerance) and (self._contact or not self._require_contact):
            raise _End(ResultCode.ALREADY_DOCKED, "already docked")
        self._enter(Phase.FINAL if self._way_in(error) else Phase.APPROACH)
        return self._handlers[self._phase](chair)

    def _approach(self, chair: Instant) -> Command:
        error = self._look(chair)
        if self._way_in(error) or (self._at_predock(error, chair) and self._navigator.straight_way_clear(error)):
            self._enter(Phase.FINAL)
            return self._final(chair)
        return self._go(chair, error)

    def _go(self, chair: Instant, error: Array) -> Command:
        """Along the planned way; where none is found, straight for the predock point unless the bay is blocked."""
        target = self._navigator.target(error)
        if target is not None:
            return self._drive(chair, target)
        if self._navigator.blocked():
            self._controller.reset()
            return replace(_STANDING, text="obstacles leave no way into the bay")
        return self._drive(chair, "predock")

    def _way_in(self, error: Array) -> bool:
        """Whether the rest is a matter of driving straight in."""
        self._navigator.see(self._controller.obstacles)
        return self._corridor.contains(error) and self._navigator.straight_way_clear(error)

    def _final(self, chair: Instant) -> Command:
        error = self._look(chair)
        if self._corridor.missed(error):
            return self._try_again(chair, ResultCode.FAILED_TO_STAGE, "outside the corridor at the bay")
        if self._standstill.at_rest_in_place(chair, error):
            self._enter(Phase.STOPPING)
            return _STANDING
        if self._standstill.stalled(chair):
            return self._try_again(chair, ResultCode.NOT_WITHIN_TOLERANCE, "stands short of the dock")
        return self._drive(chair, "dock")

    def _stop(self, chair: Instant) -> Command:
        if self._standstill.released(self._look(chair)):
            self._enter(Phase.FINAL)
            return self._drive(chair, "dock")
        if self._standstill.has_stood(chair):
            self._enter(Phase.VERIFY)
        return _STANDING

    def _verify(self, chair: Instant) -> Command:
        self._look(chair)
        if self._verification is None:
            self._verification = Verification(self._dock, self._parameters, self._require_contact, chair.stamp)
        v, verdict = self._verification.update(chair.stamp, chair, self.observer, self._contact)
        if self._verification.error is not None:
            self._error = self._verification.error
        if verdict is Verdict.PENDING:
            return Command(v, 0.0)
        if verdict is Verdict.OUTSIDE:
            return self._try_again(chair, ResultCode.NOT_WITHIN_TOLERANCE, verdict.value)
        codes = {
            Verdict.DOCKED: ResultCode.SUCCESS,
            Verdict.UNSEEN: ResultCode.MARKER_LOST,
            Verdict.NO_CONTACT: ResultCode.FAILED_TO_CHARGE,
        }
        raise _End(codes[verdict], verdict.value)

    def _retry(self, chair: Instant) -> Command:
        error = self._look(chair)
        if self._at_predock(error, chair):
            self._enter(Phase.FINAL if self._way_in(error) else Phase.APPROACH)
            return self._handlers[self._phase](chair)
        return self._drive(chair, "predock")

    def _undock(self, chair: Instant) -> Command:
        if self._T_odom_dock is None:
            estimate = self.observer.estimate(chair.stamp)
            known = estimate is not None and not self._blind(estimate)
            self._T_odom_dock = estimate.pose if estimate is not None and known else chair.pose
        self._error = relative(self._T_odom_dock, chair.pose)
        to_go = self._error - [self._dock.predock_x, 0.0, 0.0]
        p = self._parameters
        arrived = to_go[0] <= 0.0 or math.hypot(to_go[0], to_go[1]) <= p.predock_position
        if arrived and abs(chair.v) <= _UNDOCKED_SPEED:
            if self._standstill.has_stood(chair):
                raise _End(ResultCode.SUCCESS, "undocked")
            return _STANDING
        return self._drive(chair, "predock")

    def _try_again(self, chair: Instant, code: ResultCode, why: str) -> Command:
        if self._retries >= self._parameters.max_retries:
            raise _End(code, f"{why}, after {self._retries} retries")
        self._retries += 1
        self._enter(Phase.RETRY)
        return self._retry(chair)

    def _at_predock(self, error: Array, chair: Instant) -> bool:
        p = self._parameters
        near = math.hypot(error[0] - self._dock.predock_x, error[1]) <= p.predock_position
        return near and abs(error[2]) <= p.predock_heading and abs(chair.v) <= _UNDOCKED_SPEED

    def _step(self, now: float, command: Command, result: Result | None = None) -> Step:
        self._controller.history.sent(now, command.v, command.omega)  # some are the sequence's own
        estimate = self.observer.estimate()
        error = self._error
        distance = -1.0 if error is None else math.hypot(error[0], error[1])
        if error is not None and self._phase is Phase.UNDOCKING:
            distance = max(0.0, error[0] - self._dock.predock_x)
        lateral, heading = (0.0, 0.0) if error is None else (float(error[1]), float(error[2]))
        age = -1.0 if estimate is None else estimate.age
        elapsed = self._deadlines.elapsed(now)
        return Step(command, self._phase, elapsed, result, distance, lateral, heading, age, self._retries)

    def _finish(self, now: float, code: ResultCode, text: str) -> Step:
        now = now if math.isfinite(now) else self._now
        self.active = False
        self._controller.reset()
        error = np.zeros(3) if self._error is None else self._error
        elapsed = max(0.0, self._deadlines.elapsed(now))
        x, y, heading = (float(value) for value in error)
        result = Result(code, text, self._retries, elapsed, bool(self._contact), x, y, heading)
        step = self._step(now, _STANDING, result)
        self._controller.history.clear()  # whoever drives from here on does not say
        return step
