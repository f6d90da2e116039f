"""Wheel odometry of the chair as it is: counted ticks, nominal radius and track, a gyro if there is one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import arc_step
from seater_sim.chair.covariance import OdometryCovariance, noise_variances
from seater_sim.chair.interface import OdometrySample
from seater_sim.settings import NANOSECONDS, OdometrySettings, WheelOdometrySettings, WheelSettings
from seater_sim.settings.wheelchair import GYRO

Array = NDArray[np.float64]


class Encoders:
    """Turning of both wheels since the start, as way of a wheel of nominal radius [m]."""

    def __init__(self, wheels: WheelSettings) -> None:
        self.step = 2.0 * math.pi * wheels.radius / wheels.ticks if wheels.ticks else 0.0  # of one tick [m]
        self.left = self.right = 0.0

    def turn(self, left: float, right: float) -> None:
        """The wheels have turned on [m]."""
        self.left += left
        self.right += right

    def read(self) -> tuple[float, float]:
        """What has been counted [m], in whole ticks."""
        if self.step == 0.0:
            return self.left, self.right
        return self.step * math.floor(self.left / self.step), self.step * math.floor(self.right / self.step)


class EncoderOdometry:
    """Integrates ticks from `settings.origin` on, as a driver does that knows nominal radius and track only.

    The errors come from wheels, floor and gyro; the standard deviations of `settings` are what the driver claims.
    """

    def __init__(
        self,
        settings: OdometrySettings,
        source: WheelOdometrySettings,
        wheels: WheelSettings,
        encoders: Encoders,
        seed: int,
    ) -> None:
        self._settings, self._source, self._track = settings, source, wheels.track
        self._encoders, self._before = encoders, encoders.read()
        self._rng = np.random.default_rng([seed, 6])
        self._pose: Array = settings.origin.as_array()
        self._covariance = OdometryCovariance(settings)

    def update(self, way: float, turn: float, duration_ns: int, time_ns: int) -> OdometrySample:
        """The message after a true motion within `duration_ns`; only a gyro senses the true `turn` [rad]."""
        del way  # the encoders have counted it
        duration = duration_ns / NANOSECONDS
        now = self._encoders.read()
        left, right = now[0] - self._before[0], now[1] - self._before[1]
        self._before = now
        measured_way = 0.5 * (left + right)
        measured_turn = self._gyro(turn, duration) if self._source.yaw == GYRO else (right - left) / self._track
        variances = noise_variances(self._settings, measured_way, measured_turn)
        self._covariance.propagate(float(self._pose[2]), measured_way, measured_turn, *variances)
        self._pose = arc_step(self._pose, measured_way, measured_turn, 1.0)
        v, omega = measured_way / duration, measured_turn / duration
        twist = self._covariance.of_twist(v, omega, *self._twist_noise(variances, duration))
        if self._source.zero_twist:
            v = omega = 0.0
        return OdometrySample(time_ns, self._pose.copy(), v, omega, self._covariance.of_pose(), twist)

    def _gyro(self, turn: float, duration: float) -> float:
        s = self._source
        turn = turn * (1.0 + s.gyro_scale) + s.gyro_bias * duration
        if s.gyro_noise:
            turn += s.gyro_noise * math.sqrt(duration) * float(self._rng.standard_normal())
        return turn

    def _twist_noise(self, variances: tuple[float, float], duration: float) -> tuple[float, float]:
        """With the rounding to ticks: the difference of two roundings has the variance step^2 / 6."""
        rounding = self._encoders.step**2 / 6.0
        of_turn = 2.0 * rounding / self._track**2 if self._source.yaw != GYRO else 0.0
        return (variances[0] + 0.5 * rounding) / duration**2, (variances[1] + of_turn) / duration**2
