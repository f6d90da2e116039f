"""What one axis (speed or turning) makes of a command, once it acts and the motors have followed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from seater_nmpc.parameters import Prediction

# Times the deadband: the smallest command that is sent. Friction differs from place to place.
_SURE = 1.25


@dataclass(frozen=True)
class AxisDrive:
    """Steady speed = gain * command beyond the deadband, in m/s or rad/s.

    Two kinds of deadband are common: commands up to it do nothing and larger ones act in full (a controller that
    ignores a joystick near its rest), or it is taken off every command (`offset`; friction that a weak speed loop does
    not overcome).
    """

    gain: float = 1.0
    deadband: float = 0.0
    offset: bool = False

    def effective(self, command: float) -> float:
        """Steady speed for a command."""
        beyond = abs(command) - self.deadband
        if beyond <= 0.0 and self.deadband > 0.0:
            return 0.0
        return self.gain * (math.copysign(beyond, command) if self.offset else command)

    def command(self, speed: float) -> float:
        """The command for a steady speed; at least the smallest one that surely moves the chair, or zero."""
        if speed == 0.0:
            return 0.0
        size = abs(speed) / self.gain + (self.deadband if self.offset else 0.0)
        return math.copysign(max(size, _SURE * self.deadband), speed)

    @property
    def smallest_speed(self) -> float:
        """Steady speed of the smallest command that surely moves the chair; 0 without a deadband."""
        return abs(self.effective(_SURE * self.deadband))


@dataclass
class ChairDrive:
    """Both axes, as configured or as learned since."""

    v: AxisDrive
    omega: AxisDrive
    lag_v: float  # [s] first-order time constants
    lag_omega: float
    curvature: float = 0.0  # [rad/m] that it turns by itself, as learned


def configured(prediction: Prediction) -> ChairDrive:
    """As control/prediction says."""
    p = prediction
    return ChairDrive(
        AxisDrive(p.gain_v, p.deadband_v),
        AxisDrive(p.gain_omega, p.deadband_omega),
        p.motor_lag,
        p.motor_lag_turning or p.motor_lag,
    )
