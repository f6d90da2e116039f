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

from numpy.typing import ArrayLike

from seater_common.geometry import Chair, Dock
from seater_nmpc.control.command import Command
from seater_nmpc.control.controller import DockingController
from seater_nmpc.observe.innovation import Fusion
from seater_nmpc.observe.measurement import Hypothesis, MarkerSight
from seater_nmpc.observe.motion import MotionObserver
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import PlausibilityParameters, SequenceParameters
from seater_nmpc.plan.navigator import Navigator
from seater_nmpc.plausibility.installation.knowledge import Knowledge
from seater_nmpc.plausibility.watch import Watch
from seater_nmpc.sequence.conclusion import Conclusion
from seater_nmpc.sequence.ends import Ends
from seater_nmpc.sequence.goal.deadlines import Pause
from seater_nmpc.sequence.goal.results import GoalEnd, Phase, Result, ResultCode, Step
from seater_nmpc.sequence.phases.context import STANDING, Context
from seater_nmpc.sequence.phases.phases import Phases
from seater_nmpc.sequence.report import make_result, make_step
from seater_nmpc.sequence.told import Told

_SLIPPING = 1.0  # of the observer: from here on wheels slip, and what the chair does says nothing of its motors


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
            watch=self._watch,
            require_contact=require_contact,
        )
        self._goal, self._phases = self._context.goal, Phases(self._context)
        self._conclusion = Conclusion(self._context, self._phases)
        self._ends, self._told = Ends(self._context, self._watch), Told(controller.history, self._watch)
        self.active = False
        self._pause: Pause | None = None
        self._prior: tuple[ArrayLike | None, float] = (None, 0.0)
        self.held = False  # the safety gate lets nothing pass, as something is in the way: standing is no failure then
        self.held_by = ""  # that, in words
        self.unsure = ""  # why it is not known what is in the way, in words; empty: it is

    def start_dock(
        self,
        now: float,
        timeout: float = 0.0,
        prior: ArrayLike | None = None,
        prior_radius: float = 1.0,
        *,
        staging: bool = False,
    ) -> None:
        """Begin to dock at message time `now` [s]. timeout 0: the configured one; `prior`: rough dock pose in odom;
        `staging`: only to the predock point, to stand there.

        Raises:
            ValueError: when a goal is active, or a number is not finite or negative.
        """
        self._check_start(now, timeout)
        self._prior, self._goal.staging = (prior, prior_radius), staging
        if prior is not None or self._unseen:
            self.observer.reset(*self._prior)
        self._begin(now, Phase.WAITING_FOR_DOCK, timeout or self._parameters.timeouts.dock)

    def start_undock(self, now: float, timeout: float = 0.0, *, force: bool = False) -> None:
        """Begin to back out to the predock point, by odometry from where the dock is known to be.

        With the contact closed, or by `force`, the chair is taken to stand docked where no dock is known near it; else
        the goal ends with NOT_DOCKED. Raises: as `start_dock`.
        """
        self._check_start(now, timeout)
        self._goal.force, self._goal.staging = force, False
        self._begin(now, Phase.UNDOCKING, timeout or self._parameters.timeouts.undock)

    def tune(self, parameters: SequenceParameters) -> None:
        """Go by other parameters from the next goal on.

        Raises:
            ValueError: when a goal is active.
        """
        if self.active:
            raise ValueError("parameters of the sequence may be changed between two goals only")
        self._parameters = self._context.parameters = parameters
        self._goal.timeouts = parameters.timeouts
        self._phases = Phases(self._context)
        self._conclusion = Conclusion(self._context, self._phases)

    def cancel(self) -> None:
        """End the active goal with CANCELED in the next update."""
        self._ends.cancelled = True

    @property
    def can_pause(self) -> bool:
        """Whether a stop by a person pauses the goal, instead of ending it."""
        docked = self._goal.phase is Phase.HOLDING
        return self.active and self._pause is None and self._parameters.pause_time > 0.0 and not docked

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
        if self._goal.phase is not Phase.UNDOCKING and self._unseen:
            self.observer.reset(*self._prior)
        self._phases.resume(now, paused)
        self._watch.resume(now)

    def add_odometry(self, odometry: Odometry) -> bool:
        """Take an odometry message; false when it was refused and counted."""
        taken = self.observer.add_odometry(odometry)
        newest = self.observer.odometry.newest
        if taken and newest is not None:
            self._motion.add_odometry(replace(odometry, v=newest.v, omega=newest.omega))  # as checked against its poses
            slip, speeds = self.observer.slip, self.observer.true_speeds(newest.v, newest.omega)
            self._controller.measured(odometry.stamp, *speeds, rolling=slip is None or slip < _SLIPPING)
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
            chair = self._ends.check(now)
            command = STANDING if chair is None else self._phases.command(chair)
        except GoalEnd as end:
            return self._finish(now, *self._conclusion.of_phase(end))
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
            self._ends.check_inputs(now)
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
        self.active, self._ends.cancelled, self._pause = True, False, None
        self._phases.begin(now, phase, timeout)
        self._watch.begin(now)

    def _step(self, now: float, command: Command, result: Result | None = None) -> Step:
        self._told.ask(now, STANDING if self.held else command)
        return self._report(now, command, result)

    def withhold(self, now: float) -> None:
        """The command of the last `update`, at message time `now` [s], was out of date and has not been sent: the one
        before acts on, until the safety gate brakes in the silence. A chair that stands then is not blocked."""
        self._told.withhold(now)

    def _report(self, now: float, command: Command, result: Result | None = None) -> Step:
        return make_step(self._goal, now, self._dock, self.observer.estimate(), command, result)

    @property
    def installation(self) -> dict[str, tuple[float, float]]:
        """What the last goal has found of the installation, see InstallationWatch.found."""
        return self._watch.installation.found

    @property
    def knowledge(self) -> Knowledge:
        """Of the installation, by the dockings so far; may be set between goals."""
        return self._watch.installation.knowledge

    @knowledge.setter
    def knowledge(self, known: Knowledge) -> None:
        self._watch.installation.knowledge = known

    @property
    def staging(self) -> bool:
        """Whether the last goal was one to the predock point."""
        return self._goal.staging

    def _finish(self, now: float, code: ResultCode, text: str) -> Step:
        now = now if math.isfinite(now) else self._goal.now
        code, text = self._conclusion.of_goal(code, text)
        self.active, self._pause = False, None
        self.observer.bound_reacquisition(False)
        self._controller.reset()
        sds = self._conclusion.standard_deviations
        step = self._step(now, STANDING, make_result(self._goal, now, self._dock, code, text, sds))
        self._controller.history.clear()  # whoever drives from here on does not say
        return step
