"""Faults between the command and the motors, and in the odometry."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import compose
from seater_sim.chair.interface import OdometrySample
from seater_sim.faults import kinds
from seater_sim.settings import to_ns


@dataclass
class PlantFault:
    """What the motors are told instead of the command. One at a time; a new one replaces the last."""

    track: float  # [m] between the driven wheels
    kind: str = kinds.CLEAR
    values: tuple[float, ...] = ()

    def set(self, kind: str, values: tuple[float, ...]) -> None:
        """Begin a fault, or end it (`clear`); values as `kinds.read` gives them."""
        self.kind, self.values = kind, values

    @property
    def persists(self) -> bool:
        """Whether the motors are driven by the fault even when no command comes."""
        return self.kind in ("runaway", "deaf")

    def command(self, v: float, omega: float) -> tuple[float, float]:
        """What reaches the motors of a command [m/s, rad/s], which is not finite perhaps."""
        if self.kind == "runaway":
            return self.values[0], self.values[1]
        if self.kind == "stuck":
            return 0.0, 0.0
        if self.kind == "reversed":
            return -v, omega
        if self.kind in ("left_motor_dead", "right_motor_dead"):
            left, right = v - 0.5 * self.track * omega, v + 0.5 * self.track * omega
            left, right = (0.0, right) if self.kind == "left_motor_dead" else (left, 0.0)
            return 0.5 * (left + right), (right - left) / self.track
        return v, omega


class OdometryFault:
    """What becomes of the odometry's messages."""

    def __init__(self) -> None:
        self._kind: str = kinds.CLEAR
        self._values: tuple[float, ...] = ()
        self._moved: NDArray[np.float64] = np.zeros(3)  # from the true odom to the one that jumped
        self._held: OdometrySample | None = None
        self._sent_ns: int | None = None  # time of the last message that went out

    def set(self, kind: str, values: tuple[float, ...]) -> None:
        """Begin a fault, or end it (`clear`); values as `kinds.read` gives them. A jump stays."""
        self._kind, self._values, self._held, self._sent_ns = kind, values, None, None
        if kind == "jump":
            self._moved = compose(self._moved, np.array([values[0], values[1], math.radians(values[2])]))

    def apply(self, sample: OdometrySample) -> OdometrySample | None:
        """The message that goes out instead; None: none."""
        sample = replace(sample, pose=compose(self._moved, sample.pose))
        kind, held = self._kind, self._held or sample
        self._held = held
        if kind == "off" or (kind == "slow" and not self._is_due(sample.time_ns)):
            return None
        if kind == "other_frame":
            ahead = np.array([self._values[0], 0.0, 0.0])
            return replace(sample, pose=compose(sample.pose, ahead), frame="chair_front")
        if kind == "frozen":
            return replace(held, time_ns=sample.time_ns, v=0.0, omega=0.0)
        if kind == "zero_stamps":
            return replace(sample, time_ns=0)
        if kind == "late":
            return replace(sample, time_ns=max(0, sample.time_ns - to_ns(self._values[0])))
        if kind == "nan":
            return replace(sample, pose=np.full(3, math.nan), v=math.nan, omega=math.nan)
        if kind == "zero_twist":
            return replace(sample, v=0.0, omega=0.0)
        if kind == "scale":
            factor = np.array([self._values[0], self._values[0], 1.0])
            return replace(sample, pose=held.pose + factor * (sample.pose - held.pose), v=self._values[0] * sample.v)
        return sample

    def _is_due(self, time_ns: int) -> bool:
        due = self._sent_ns is None or time_ns - self._sent_ns >= to_ns(self._values[0])
        self._sent_ns = time_ns if due else self._sent_ns
        return due
