"""What the docking node says on /diagnostics."""

from __future__ import annotations

from collections import deque

import diagnostic_updater
import rospy
from diagnostic_msgs.msg import DiagnosticStatus

from seater_nmpc.control.command import Command
from seater_nmpc.control.controller import DockingController
from seater_nmpc.observe.observer import DockObserver


class Diagnostics:
    """Control rate, solve time, age of the measurement, counters; once a second."""

    def __init__(self, controller: DockingController, observer: DockObserver, period: float) -> None:
        self._period = period
        self.use(controller, observer)
        self.installation: dict[str, tuple[float, float]] = {}  # of the last goal, see DockingSequence.installation
        self._solve_times: deque[float] = deque(maxlen=200)
        self._age, self._consecutive = -1.0, 0
        rate = {"min": 1.0 / period, "max": 1.0 / period}
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID("none")
        self._rate = diagnostic_updater.HeaderlessTopicDiagnostic(
            "control cycle", self._updater, diagnostic_updater.FrequencyStatusParam(rate, tolerance=0.2)
        )
        self._updater.add("controller", self._write)
        self._timer = rospy.Timer(rospy.Duration(1.0), lambda _: self._updater.update(), reset=True)

    def use(self, controller: DockingController, observer: DockObserver) -> None:
        """Those of another dock from now on."""
        self._controller, self._observer = controller, observer

    def cycle(self) -> None:
        """A control cycle began."""
        self._rate.tick()

    def report(self, command: Command, age: float) -> None:
        """What the cycle did; `age` of the measurement behind it [s], -1: never seen."""
        self._age, self._consecutive = age, self._controller.counters.consecutive_failures
        if command.solve_time > 0.0:
            self._solve_times.append(command.solve_time)

    def _write(self, status: diagnostic_updater.DiagnosticStatusWrapper) -> diagnostic_updater.DiagnosticStatusWrapper:
        slowed_down = self._controller.pace.why
        if slowed_down:
            status.summary(DiagnosticStatus.WARN, f"drives slowly: {slowed_down}")
        elif self._consecutive:
            status.summary(DiagnosticStatus.WARN, f"{self._consecutive} cycles in a row without a solution")
        else:
            status.summary(DiagnosticStatus.OK, "ok")
        times = sorted(self._solve_times)
        if times:
            status.add("solve time, median [ms]", f"{1e3 * times[len(times) // 2]:.1f}")
            status.add("solve time, largest of 200 [ms]", f"{1e3 * times[-1]:.1f}")
        status.add("measurement age [s]", f"{self._age:.2f}")
        for name, value in vars(self._controller.counters).items():
            status.add(f"controller: {name}", str(value))
        for outcome, count in sorted(self._observer.images.counts.items()):
            status.add(f"images: {outcome.text}", str(count))
        status.add("odometry refused", str(self._observer.refused_odometry))
        self._write_learned(status)
        return status

    def _write_learned(self, status: diagnostic_updater.DiagnosticStatusWrapper) -> None:
        """What the controller has learned of the chair, beside what is configured, and the observer of its wheels."""
        history, estimate = self._controller.history, self._observer.estimate()
        drive = history.drive
        status.add("learned: command delay [s]", f"{history.delay:.3f}")
        status.add("learned: lag, speed and turning [s]", f"{drive.lag_v:.3f} {drive.lag_omega:.3f}")
        for name, axis, unit in (("speed", drive.v, "m/s"), ("turning", drive.omega, "rad/s")):
            kind = "taken off every command" if axis.offset else "smaller commands do nothing"
            status.add(f"learned: deadband of {name} [{unit}]", f"{axis.deadband:.3f} ({kind})")
        status.add("learned: gain of speed and turning", f"{drive.v.gain:.3f} {drive.omega.gain:.3f}")
        status.add("learned: turns by itself [rad/m]", f"{drive.curvature:.3f}")
        if estimate is not None:
            status.add("wheels slip, 0 to 1; 4: one spins", f"{estimate.slip:.2f}")
            status.add("gyro bias [rad/s]", f"{estimate.drift[3]:.4f}")
        for name, (value, sd) in self.installation.items():  # [m], [rad], share; read by the history
            status.add(f"installation: {name}", f"{value:.5f} +- {sd:.5f}")
