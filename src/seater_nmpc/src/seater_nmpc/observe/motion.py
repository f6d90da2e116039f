"""The chair's motion: true speeds behind the motors' lag, from the commands that were sent and the odometry's speeds.

One Kalman filter per axis. Between two messages the speed follows what the motors are believed to make of the command
that acts (deadband, gain, curvature), as a first-order lag; what they do otherwise (ramps, load, floor) is white
acceleration. The odometry's speed is a difference of wheel angles over one period, so it is noisy. Before a command
acts the last speed is what is predicted; with a lag of 0 each command is reached at once.
"""

from __future__ import annotations

import math

from seater_nmpc.drive.prediction import CommandHistory
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import ObserverParameters

# Normalised innovation squared from which on the motors plainly do something else: the odometry counts.
_UNEXPLAINED = 16.0
_GAP = 0.5  # [s] between two messages after which the filter begins anew


class _Axis:
    """Speed of one axis and its variance."""

    def __init__(self, noise: float, agility: float, lag: float) -> None:
        self._noise, self._agility, self._lag = noise**2, agility**2, lag
        self.speed, self.variance = 0.0, math.inf

    def predict(self, speed: float, duration: float) -> None:
        decay = math.exp(-duration / self._lag) if self._lag > 0.0 else 1.0
        self.speed = speed
        # agility is the deviation of the acceleration that persists over about a lag: density agility^2 * lag
        self.variance = decay**2 * self.variance + self._agility * max(self._lag, duration) * duration

    def update(self, measured: float) -> None:
        innovation, expected = measured - self.speed, self.variance + self._noise
        if innovation**2 > _UNEXPLAINED * expected or math.isinf(expected):
            self.speed, self.variance = measured, self._noise
            return
        gain = self.variance / expected
        self.speed += gain * innovation
        self.variance *= 1.0 - gain


class MotionObserver:
    """Speeds of the chair now. Feed it each odometry message; `history` notes the commands when they are sent."""

    def __init__(self, history: CommandHistory, parameters: ObserverParameters) -> None:
        self._commands = history.view()
        self._history, self._parameters = history, parameters
        self.clear()

    def clear(self) -> None:
        """Forget the speeds and what was sent until now."""
        p = self._parameters
        self._commands.restart()
        self._stamp: float | None = None
        self._v = _Axis(p.speed_noise, p.speed_agility, self._history.drive.lag_v)
        self._omega = _Axis(p.omega_noise, p.omega_agility, self._history.drive.lag_omega)

    def add_odometry(self, odometry: Odometry) -> None:
        """Take a message that is finite and newer than the last one."""
        if self._stamp is not None and not 0.0 < odometry.stamp - self._stamp <= _GAP:
            self.clear()
        if self._stamp is not None:
            duration = odometry.stamp - self._stamp
            v, omega = self._commands.speeds(self._stamp, odometry.stamp, self._v.speed, self._omega.speed)
            self._v.predict(v, duration)
            self._omega.predict(omega, duration)
        self._v.update(odometry.v)
        self._omega.update(odometry.omega)
        self._stamp = odometry.stamp

    def at(self, stamp: float) -> tuple[float, float]:
        """(v [m/s], omega [rad/s]) at `stamp`, not before the newest message; zero before the first one."""
        if self._stamp is None:
            return 0.0, 0.0
        return self._commands.speeds(self._stamp, stamp, self._v.speed, self._omega.speed)
