"""What voltages make a chair drive as asked."""

from __future__ import annotations

import math

import numpy as np

from seater_base.deflection.table import AxisTable, DeflectionTable


class Axis:
    """The inverse of one measured curve, linear between its points, and cut off at its ends: never beyond them."""

    def __init__(self, table: AxisTable) -> None:
        self._neutral, self._lowest, self._highest = table.neutral, table.lowest, table.highest
        moving = [(s, v) for s, v in zip(table.speeds, table.volts, strict=True) if s != 0.0]
        still = [v for s, v in zip(table.speeds, table.volts, strict=True) if s == 0.0]
        rises = table.speeds[-1] > table.speeds[0]
        # Where the deadband ends the speed is still zero: the first volt beyond it moves the chair.
        ends = {1.0: still[-1] if rises else still[0], -1.0: still[0] if rises else still[-1]}
        self._sides = {
            sign: np.array(sorted([(0.0, end), *((abs(s), v) for s, v in moving if sign * s > 0.0)])).T
            for sign, end in ends.items()
        }

    def volts(self, speed: float) -> float:
        """[V] for a speed; what is not finite stands, as zero does."""
        if not math.isfinite(speed) or speed == 0.0:
            return self._neutral
        speeds, volts = self._sides[math.copysign(1.0, speed)]
        return min(max(float(np.interp(abs(speed), speeds, volts)), self._lowest), self._highest)


class Deflections:
    """Both axes."""

    def __init__(self, table: DeflectionTable) -> None:
        self.table = table
        self._drive, self._turn = Axis(table.drive), Axis(table.turn)

    @property
    def neutral(self) -> tuple[float, float]:
        """[V] of drive and turn while the chair shall stand."""
        return self.table.drive.neutral, self.table.turn.neutral

    def volts(self, v: float, omega: float) -> tuple[float, float]:
        """[V] of drive and turn for [m/s] and [rad/s]; neutral in both when one of them is not finite."""
        if not (math.isfinite(v) and math.isfinite(omega)):
            return self.neutral
        return self._drive.volts(v), self._turn.volts(omega)
