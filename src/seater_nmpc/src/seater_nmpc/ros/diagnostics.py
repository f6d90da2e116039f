"""What the docking node says on /diagnostics: an entry for each stage that it knows of, see health/stages.py."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

import diagnostic_updater
import rospy
from diagnostic_updater import DiagnosticStatusWrapper as Status

from seater_nmpc.control.command import Command
from seater_nmpc.control.controller import DockingController
from seater_nmpc.health import stages
from seater_nmpc.health.word import Word
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.sequence.goal.results import Phase, Result, Step


class Diagnostics:
    """Once a second, from a thread of its own: it only reads."""

    def __init__(
        self, controller: DockingController, observer: DockObserver, period: float, silence: Callable[[], float]
    ) -> None:
        """`period` [s] of a cycle; `silence`: [s] since the last odometry came."""
        self._period, self._silence = period, silence
        self.use(controller, observer)
        self.installation: dict[str, tuple[float, float]] = {}  # of the last goal, see DockingSequence.installation
        self._solve_times: deque[float] = deque(maxlen=200)
        self._age, self._failures, self._answered = math.inf, 0, -math.inf
        self._phase: Phase | None = None
        self._result: Result | None = None
        self._held_by, self._cycles, self._since, self._rate = "", 0, rospy.get_time(), 1.0 / period
        self._refused = 0
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID("none")
        entries: dict[str, Callable[[Status], Status]] = {stage: partial(self._sight, stage) for stage in stages.SIGHT}
        entries |= {"solver": self._solver, "sequence": self._sequence, "base": self._base}
        for stage, write in entries.items():
            self._updater.add(stage, write)
        self._timer = rospy.Timer(rospy.Duration(1.0), lambda _: self._updater.update(), reset=True)

    def use(self, controller: DockingController, observer: DockObserver) -> None:
        """Those of another dock from now on."""
        self._controller, self._observer = controller, observer

    def cycle(self) -> None:
        """A control cycle began."""
        self._cycles += 1

    def answered(self) -> None:
        """Perception has worked an image through."""
        self._answered = time.monotonic()

    def step(self, step: Step, held_by: str) -> None:
        """What the sequence came to; `held_by`: who holds the chair, empty: nobody."""
        self._phase, self._held_by = (None if step.done else step.phase), held_by
        self._result = step.result or self._result

    def report(self, command: Command, age: float) -> None:
        """What the cycle did; `age` of the measurement behind it [s], -1: never seen."""
        self._age, self._failures = age if age >= 0.0 else math.inf, self._controller.counters.consecutive_failures
        if command.solve_time > 0.0:
            self._solve_times.append(command.solve_time)

    def _odometry(self, refused: int = 0) -> Word:
        return stages.base(math.inf if self._observer.odometry.newest is None else self._silence(), refused)

    def _base(self, status: Status) -> Status:
        refused = self._observer.refused_odometry
        lately, self._refused = max(0, refused - self._refused), refused
        _say(status, self._odometry(lately))
        status.add("odometry age [s]", f"{self._silence():.2f}")
        status.add("odometry refused", str(refused))
        return status

    def _sight(self, stage: str, status: Status) -> Status:
        images, answered = self._observer.images, time.monotonic() - self._answered
        seen = stages.Sight(self._phase is not None, self._age, answered, images.unused, images.why_unseen)
        _say(status, stages.sight(stage, seen, self._odometry()))
        status.add("measurement age [s]", f"{self._age:.2f}")
        if stage == "observer":
            status.add("images, usual time between two [s]", f"{images.period:.3f}")
            for outcome, count in sorted(images.counts.copy().items()):
                status.add(f"images: {outcome.text}", str(count))
            estimate = self._observer.estimate()
            if estimate is not None:
                status.add("wheels slip, 0 to 1; 4: one spins", f"{estimate.slip:.2f}")
                status.add("gyro bias [rad/s]", f"{estimate.drift[3]:.4f}")
        return status

    def _solver(self, status: Status) -> Status:
        now = rospy.get_time()
        if now > self._since:
            self._rate = self._cycles / (now - self._since)
        self._cycles, self._since = 0, now
        times = sorted(self._solve_times)
        median = times[len(times) // 2] if times else 0.0
        slowed_down = self._controller.pace.why
        solving = stages.Solving(self._failures, slowed_down, median, self._period, self._rate)
        _say(status, stages.solver(solving, self._odometry()))
        status.add("control cycles [Hz]", f"{self._rate:.1f}")
        if times:
            status.add("solve time, median [ms]", f"{1e3 * median:.1f}")
            status.add("solve time, largest of 200 [ms]", f"{1e3 * times[-1]:.1f}")
        for name, value in vars(self._controller.counters).items():
            status.add(f"controller: {name}", str(value))
        self._write_learned(status)
        return status

    def _sequence(self, status: Status) -> Status:
        _say(status, stages.sequence(self._phase, self._result, self._held_by))
        status.add("goal", "none" if self._phase is None else self._phase.name)
        for name, (value, sd) in self.installation.items():  # [m], [rad], share; read by the history
            status.add(f"installation: {name}", f"{value:.5f} +- {sd:.5f}")
        return status

    def _write_learned(self, status: Status) -> None:
        """What the controller has learned of the chair, beside what is configured."""
        history = self._controller.history
        drive = history.drive
        status.add("learned: command delay [s]", f"{history.delay:.3f}")
        status.add("learned: lag, speed and turning [s]", f"{drive.lag_v:.3f} {drive.lag_omega:.3f}")
        for name, axis, unit in (("speed", drive.v, "m/s"), ("turning", drive.omega, "rad/s")):
            kind = "taken off every command" if axis.offset else "smaller commands do nothing"
            status.add(f"learned: deadband of {name} [{unit}]", f"{axis.deadband:.3f} ({kind})")
        status.add("learned: gain of speed and turning", f"{drive.v.gain:.3f} {drive.omega.gain:.3f}")
        status.add("learned: turns by itself [rad/m]", f"{drive.curvature:.3f}")


def _say(status: Any, word: Word) -> None:
    status.summary(int(word.level), word.text)
