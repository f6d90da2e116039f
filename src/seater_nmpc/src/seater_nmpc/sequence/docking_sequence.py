"""The docking sequence as a state machine in message time. No ROS.

    WAITING_FOR_DOCK -> APPROACH -> FINAL -> STOPPING -> VERIFY -> done      UNDOCKING -> done
                           ^          |        |         |
                           +- RETRY <-+--------+---------+

SEARCHING may follow WAITING_FOR_DOCK, CORRECTING comes between STOPPING and STOPPING, FINAL may follow WAITING_FOR_DOCK
and RETRY at once. docs/explanation/sequence.md has them all.

Every goal ends in exactly one step with a result, and the command of that step is zero at once: what the chair then
does with its speed is limited by the safety gate, which brakes within the chair's limits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from seater_common.geometry import Chair, Dock
from seater_nmpc.control.command import Command
from seater_nmpc.control.controller import DockingController
from seater_nmpc.observe.innovation import Fusion
from seater_nmpc.observe.measurement import Hypothesis, MarkerSight
from seater_nmpc.observe.motion import MotionObserver
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry import Instant, Odometry
from seater_nmpc.parameters import PlausibilityParameters, SequenceParameters
from seater_nmpc.plan.navigator import Navigator
from seater_nmpc.plausibility.watch import Watch
from seater_nmpc.sequence.goal.deadlines import Pause
from seater_nmpc.sequence.goal.results import GoalEnd, Phase, Result, ResultCode, Step
from seater_nmpc.sequence.phases.context import STANDING, Context
from seater_nmpc.sequence.phases.phases import Phases

_UNSEEN = 1.0  # [s] without a used image, from which on a text says why


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
        plausibility: PlausibilityParameters | None = None,
    ) -> None:
        """`navigator`: finds the way to the bay; None: one with default parameters."""
        self.observer, self._controller = observer, controller
        self._dock, self._parameters = dock, parameters or SequenceParameters()
        self._motion = MotionObserver(controller.history, observer.parameters)
        checks = plausibility or PlausibilityParameters()
        self._watch = Watch(chair, dock, observer, controller.history, checks)
        self._context = Context(
            chair=chair,
            dock=dock,
            controller=controller,
            observer=observer,
            motion=self._motion,
            navigator=navigator or Navigator(chair, dock, controller.parameters),
            parameters=self._parameters,
            require_contact=require_contact,
        )
        self._goal, self._phases = self._context.goal, Phases(self._context)
        self.active = self._cancelled = False
        self._pause: Pause | None = None
        self._prior: tuple[ArrayLike | None, float] = (None, 0.0)
        self.held = False  # the safety gate lets nothing pass, as something is in the way: standing is no failure then
        self.held_by = ""  # that, in words
        self.unsure = ""  # why it is not known what is in the way, in words; empty: it is

    def start_dock(
        self, now: float, timeout: float = 0.0, prior: ArrayLike | None = None, prior_radius: float = 1.0
    ) -> None:
        """Begin to dock at message time `now` [s]. timeout 0: the configured one; `prior`: rough dock pose in odom.

        Raises:
            ValueError: when a goal is active, or a number is not finite or negative.
        """
        self._check_start(now, timeout)
        self._prior = (prior, prior_radius)
        if prior is not None or self._unseen:
            self.observer.reset(*self._prior)
        self._begin(now, Phase.WAITING_FOR_DOCK, timeout or self._parameters.timeouts.dock)

    def start_undock(self, now: float, timeout: float = 0.0, *, force: bool = False) -> None:
        """Begin to back out to the predock point, by odometry from where the dock is known to be.

        With the contact closed, or by `force`, the chair is taken to stand docked where no dock is known near it; else
        the goal ends with NOT_DOCKED. Raises: as `start_dock`.
        """
        self._check_start(now, timeout)
        self._goal.force = force
        self._begin(now, Phase.UNDOCKING, timeout or self._parameters.timeouts.undock)

    def cancel(self) -> None:
        """End the active goal with CANCELED in the next update."""
        self._cancelled = True

    @property
    def can_pause(self) -> bool:
        """Whether a stop by a person pauses the goal, instead of ending it."""
        return self.active and self._pause is None and self._parameters.pause_time > 0.0

    @property
    def paused(self) -> bool:
        """Whether the goal waits for `resume`."""
        return self._pause is not None

    def pause(self, now: float, code: ResultCode, text: str) -> Step:
        """A person has stopped the chair: stand until `resume`, whoever drives meanwhile. After `pause_time` the goal
        ends with this code and text.

        Raises:
            ValueError: when there is nothing that can be paused.
        """
        if not self.can_pause:
            raise ValueError("no goal is active, or it cannot be paused")
        self._pause = Pause(now, self._parameters.pause_time, code, text)
        self._controller.reset()
        self._controller.history.clear()  # whoever drives from here on does not say
        self.observer.bound_reacquisition(False)
        return self._stand_paused(now)

    def resume(self, now: float) -> None:
        """Go on with the goal from wherever the chair stands now, at message time `now` [s].

        Raises:
            ValueError: when no goal is paused.
        """
        if self._pause is None:
            raise ValueError("no goal is paused")
        paused, self._pause = max(0.0, now - self._pause.since), None
        if self._docking and self._unseen:
            self.observer.reset(*self._prior)
        self._phases.resume(now, paused)
        self._watch.begin(now)

    def add_odometry(self, odometry: Odometry) -> bool:
        """Take an odometry message; false when it was refused and counted."""
        taken = self.observer.add_odometry(odometry)
        newest = self.observer.odometry.newest
        if taken and newest is not None:
            self._motion.add_odometry(replace(odometry, v=newest.v, omega=newest.omega))  # as checked against its poses
            self._controller.measured(odometry.stamp, *self.observer.true_speeds(newest.v, newest.omega))
        return taken

    def add_detections(self, stamp: float, hypotheses: list[Hypothesis], markers: Sequence[MarkerSight] = ()) -> Fusion:
        """Take the dock observations of one image, and its single markers where they are known."""
        if self.active:
            self._watch.see(hypotheses, markers)
        return self.observer.add_detections(stamp, hypotheses)

    def update(self, now: float, contact: bool | None = None) -> Step:
        """One control cycle at message time `now` [s]; `contact`: the charging contact, None when not known.

        Raises:
            ValueError: when no goal is active.
        """
        if not self.active:
            raise ValueError("no goal is active")
        self._goal.contact = contact
        if self._pause is not None:
            return self._stand_paused(now)
        self._goal.held_by = (self.held_by or "the safety gate holds the chair") if self.held else ""
        self._goal.unsure = self.unsure
        if self.held:
            self._context.stand_patiently()
        try:
            chair = self._check(now)
            command = STANDING if chair is None else self._phases.command(chair)
        except GoalEnd as end:
            doubt = self._watch.final() if end.code is ResultCode.SUCCESS and self._docking else None
            if doubt is not None:
                return self._finish(now, ResultCode[doubt.kind.name], doubt.text)
            return self._finish(now, end.code, end.text)
        return self._step(now, command)

    @property
    def backs_out(self) -> bool:
        """Whether the chair is backing out, which is done slowly, as no sensor looks there."""
        return self.active and self._pause is None and self._phases.backs_out

    def abort(self, now: float, code: ResultCode, text: str) -> Step:
        """End the active goal from outside (no more odometry, an error in the adapter): zero, with this result."""
        return self._finish(now, code, text)

    @property
    def _unseen(self) -> bool:
        estimate = self.observer.estimate()
        return estimate is None or self._context.blind(estimate)

    def _stand_paused(self, now: float) -> Step:
        assert self._pause is not None  # every caller has looked
        pause, left = self._pause, self._pause.left(now)
        try:
            self._check_inputs(now)
        except GoalEnd as end:
            return self._finish(now, end.code, end.text)
        if left < 0.0:
            return self._finish(now, pause.code, f"{pause.text}, and not resumed within {pause.longest:.0f} s")
        standing = replace(STANDING, text=f"paused, {left:.0f} s are left to resume: {pause.text}")
        return replace(self._report(now, standing), phase=Phase.PAUSED)

    def _check_start(self, now: float, timeout: float) -> None:
        if self.active:
            raise ValueError("a goal is active already")
        if not (math.isfinite(now) and math.isfinite(timeout) and timeout >= 0.0):
            raise ValueError(f"timeout: is {timeout!r}, must be finite and >= 0")

    def _begin(self, now: float, phase: Phase, timeout: float) -> None:
        self.active, self._cancelled, self._pause = True, False, None
        self._phases.begin(now, phase, timeout)
        self._watch.begin(now)

    def _check_inputs(self, now: float) -> None:
        """What ends every goal, paused or not. Raises GoalEnd."""
        if self._cancelled:
            raise GoalEnd(ResultCode.CANCELED, "cancelled")
        newest = self.observer.odometry.newest
        if not math.isfinite(now) or now < self._goal.now or newest is None:
            raise GoalEnd(ResultCode.ODOMETRY_LOST, "no odometry, or its time went backward")
        self._goal.now = now
        if now - newest.stamp > self._parameters.odometry_timeout:
            raise GoalEnd(ResultCode.ODOMETRY_LOST, f"newest odometry is {now - newest.stamp:.2f} s old")

    def _check(self, now: float) -> Instant | None:
        """What ends every phase; the chair at `now`, None while the odometry is late but not lost yet."""
        self._check_inputs(now)
        late = self._goal.deadlines.missed(now, self._goal.phase)
        if late is not None:
            code, text = late
            unseen = code is ResultCode.FAILED_TO_DETECT_DOCK
            raise GoalEnd(code, f"{text}: {self.observer.why_unseen}" if unseen else self._with_reason(text))
        found = self._watch.check(now)
        if found is not None:
            raise GoalEnd(ResultCode[found.kind.name], found.text)
        return self.observer.odometry.at(now)

    def _with_reason(self, text: str) -> str:
        """The text, and why there is no way into the bay or no image is used, if that is so."""
        estimate = self.observer.estimate()
        unseen = estimate is not None and estimate.age > _UNSEEN
        reason = self._goal.no_way or (self.observer.why_unseen if unseen else "")
        return f"{text}: {reason}" if reason else text

    def _step(self, now: float, command: Command, result: Result | None = None) -> Step:
        sent = STANDING if self.held else command
        self._controller.history.sent(now, sent.v, sent.omega)  # some are the sequence's own
        self._watch.asked(now, sent.v, sent.omega)
        return self._report(now, command, result)

    def _report(self, now: float, command: Command, result: Result | None = None) -> Step:
        goal, estimate = self._goal, self.observer.estimate()
        error, distance = goal.error, -1.0
        if error is not None and goal.phase is Phase.UNDOCKING:
            distance = max(0.0, float(error[0]) - self._dock.predock_x)
        elif error is not None:
            distance = math.hypot(error[0], error[1])
        return Step(
            command=command,
            phase=goal.phase,
            elapsed=goal.deadlines.elapsed(now),
            result=result,
            distance=distance,
            lateral_error=0.0 if error is None else float(error[1]),
            heading_error=0.0 if error is None else float(error[2]),
            measurement_age=-1.0 if estimate is None else estimate.age,
            retries=goal.retries,
        )

    @property
    def installation(self) -> dict[str, tuple[float, float]]:
        """What the last goal has found of the installation, see Watch.installation."""
        return self._watch.installation

    @property
    def _docking(self) -> bool:
        return self._goal.phase is not Phase.UNDOCKING

    def _certainty(self) -> dict[str, float]:
        """Standard deviations of the final error: noise of the images, what calibration leaves, and what the way here
        says of the installation."""
        if self._goal.covariance is None:
            return {}
        p, off = self.observer.parameters, self._watch.final_error
        common = np.diag([p.calibration_position**2, p.calibration_position**2, p.calibration_heading**2])
        P = self._goal.covariance + common + np.outer(off, off)
        return {
            "position_sd": math.sqrt(float(np.linalg.eigvalsh(P[:2, :2])[-1])),
            "heading_sd": math.sqrt(float(P[2, 2])),
        }

    def _finish(self, now: float, code: ResultCode, text: str) -> Step:
        goal = self._goal
        now = now if math.isfinite(now) else goal.now
        self.active, self._pause = False, None
        self.observer.bound_reacquisition(False)
        self._controller.reset()
        x, y, heading = (float(value) for value in (np.zeros(3) if goal.error is None else goal.error))
        result = Result(
            code=code,
            text=text,
            retries=goal.retries,
            duration=max(0.0, goal.deadlines.elapsed(now)),
            contact=bool(goal.contact),
            longitudinal_error=x,
            lateral_error=y,
            heading_error=heading,
            **self._certainty(),
        )
        step = self._step(now, STANDING, result)
        self._controller.history.clear()  # whoever drives from here on does not say
        return step
