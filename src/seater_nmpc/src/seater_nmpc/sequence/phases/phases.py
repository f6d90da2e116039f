"""The phases of a goal: which one has the chair, and when one gives way to another."""

from __future__ import annotations

from collections.abc import Callable

from seater_nmpc.control.command import Command
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.sequence.goal.results import Phase
from seater_nmpc.sequence.phases.at_dock import AtDock
from seater_nmpc.sequence.phases.caution import Caution
from seater_nmpc.sequence.phases.context import STANDING, Asked, Context
from seater_nmpc.sequence.phases.finding import Finding
from seater_nmpc.sequence.phases.installation_check import InstallationCheck
from seater_nmpc.sequence.phases.staging import Staging
from seater_nmpc.sequence.phases.way_in import WayIn
from seater_nmpc.sequence.phases.way_out import WayOut

_BACKING_OUT = (Phase.RETRY, Phase.UNDOCKING)
_DOCK_ANYWHERE = (Phase.WAITING_FOR_DOCK, Phase.SEARCHING, Phase.UNDOCKING)  # none drives by where the dock was seen
_FROM_REST = (Phase.WAITING_FOR_DOCK, Phase.VERIFY, Phase.UNDOCKING)  # the controller begins anew
_STAND_FIRST = (Phase.STOPPING, Phase.VERIFY)  # for the cycle in which they begin


class Phases:
    """The phases of one goal after another. `begin` a goal, then ask for one `command` per control cycle.

    A phase that drives takes over within the cycle in which another one gives way to it. The end of a goal is raised
    as GoalEnd.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._way_out = WayOut(context)
        self._check = InstallationCheck(context, self._way_out)
        self._way_in, self._at_dock = WayIn(context, self._check), AtDock(context)
        self._finding = Finding(context, self._way_in)
        self._staging = Staging(context, self._way_out)
        self._caution = Caution(context, self._finding)
        self._handlers: dict[Phase, Callable[[Instant], Asked]] = {
            Phase.WAITING_FOR_DOCK: self._finding.wait,
            Phase.SEARCHING: self._finding.find,
            Phase.APPROACH: self._way_in.approach,
            Phase.FINAL: self._way_in.final,
            Phase.STOPPING: self._at_dock.stop,
            Phase.CORRECTING: self._at_dock.correct,
            Phase.VERIFY: self._at_dock.verify,
            Phase.RETRY: self._retry,
            Phase.UNDOCKING: self._way_out.undock,
            Phase.STAGING: self._staging.stage,
            Phase.HOLDING: self._at_dock.hold,
            Phase.CHECK_INSTALLATION: self._check.check,
        }
        self.begin(0.0, Phase.WAITING_FOR_DOCK, 0.0)

    def begin(self, now: float, phase: Phase, timeout: float) -> None:
        """A goal begins at message time `now` [s] with this phase; it may take `timeout` [s]."""
        self._context.goal.begin(now, phase, timeout)
        self._context.controller.history.clear()  # whoever drove until now did not say
        self._context.controller.pace.limit()
        self._finding.begin()
        self._check.begin()
        self._caution.begin()
        self._enter(phase)

    def resume(self, now: float, paused: float) -> None:
        """Go on with the goal after a pause of `paused` [s], from wherever the chair is now [message time]."""
        goal = self._context.goal
        goal.now = now
        goal.deadlines.put_off(paused)
        goal.failure = None  # a person has it go on: another attempt
        self._context.controller.history.clear()
        self._finding.resume()
        self._caution.begin()
        self._enter(Phase.UNDOCKING if goal.phase is Phase.UNDOCKING else Phase.WAITING_FOR_DOCK)

    def command(self, chair: Instant) -> Command:
        """What the present phase asks for. Raises GoalEnd."""
        self._context.controller.pace.cycle(chair.stamp)  # of all phases: a small move rests on it
        asked = self._caution.wait(chair)
        if asked is None:
            self._caution.limit_speed(self.backs_out)
            asked = self._handlers[self._context.goal.phase](chair)
        while isinstance(asked, Phase):
            self._enter(asked)
            asked = STANDING if asked in _STAND_FIRST else self._handlers[asked](chair)
        return asked

    @property
    def backs_out(self) -> bool:
        """Whether the chair is backing out, for another attempt or away from where it got stuck."""
        phase = self._context.goal.phase
        staging = phase is Phase.STAGING and self._staging.backs_out
        check = phase is Phase.CHECK_INSTALLATION and self._check.backs_out
        return phase in _BACKING_OUT or self._way_in.backs_off or staging or check

    @property
    def installation_checked(self) -> bool:
        """Whether a success has to be as certain as turns make it."""
        return self._check.vouches

    @property
    def installation_shown(self) -> bool:
        """Whether this goal has turned at two places, which shows where the camera sits."""
        return self._check.shown

    def _retry(self, chair: Instant) -> Asked:
        """RETRY; then again from there."""
        asked = self._way_out.retry(chair)
        return self._way_in.first_phase(self._context.look(chair)) if asked is None else asked

    def _enter(self, phase: Phase) -> None:
        controller, observer = self._context.controller, self._context.observer
        self._context.goal.enter(phase)
        self._finding.restart()
        self._way_in.restart()
        self._at_dock.restart(phase)
        self._way_out.restart()
        self._staging.restart()
        self._check.restart()
        observer.acquire_moving(phase is Phase.SEARCHING)
        observer.bound_reacquisition(phase not in _DOCK_ANYWHERE, self._context.dock.front)
        if phase in _FROM_REST:
            controller.reset()
