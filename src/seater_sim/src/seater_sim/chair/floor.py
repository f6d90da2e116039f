"""What the floor does: slip, slippery patches, slope.

Slip is (1 - way / turning of the wheel): a wheel that drives loses way, one that brakes gains it. Its part under load
is proportional to the force that the wheel transmits (the linear range of a tyre, Pacejka, "Tire and Vehicle
Dynamics"), hence to the acceleration with that of gravity.
"""

from __future__ import annotations

import math

import numpy as np

from seater_sim.settings import FloorSettings

GRAVITY = 9.81  # [m/s^2]


class Patches:
    """Slippery patches along the way, placed by the seed: gap, patch, gap, patch, ..."""

    def __init__(self, settings: FloorSettings, seed: int) -> None:
        self._settings = settings
        self._rng = np.random.default_rng([seed, 4])
        self._begin = self._end = 0.0
        self._slip = (0.0, 0.0)
        self._next(0.0)

    def at(self, way: float) -> tuple[float, float]:
        """Slip of the left and the right wheel; `way` [m], rolled by the wheels in either direction, never falls."""
        if self._settings.patch_slip == 0.0:
            return 0.0, 0.0
        while way >= self._end:
            self._next(self._end)
        return self._slip if way >= self._begin else (0.0, 0.0)

    def _next(self, way: float) -> None:
        s, rng = self._settings, self._rng
        self._begin = way + s.patch_gap * float(rng.exponential())
        self._end = self._begin + s.patch_length * float(rng.uniform(0.5, 1.5))
        slip = s.patch_slip * float(rng.uniform(0.5, 1.0))
        one_sided, left = rng.random() < s.patch_one_sided, rng.random() < 0.5
        self._slip = (slip * (left or not one_sided), slip * (not left or not one_sided))


class Floor:
    """Slip and slope under the chair."""

    def __init__(self, settings: FloorSettings, seed: int) -> None:
        self._settings = settings
        self._patches = Patches(settings, seed)
        self._way = 0.0
        self._pull = GRAVITY * math.sin(settings.slope)

    def gravity(self, heading: float) -> tuple[float, float]:
        """Acceleration of gravity in the plane of the floor [m/s^2]: against the chair's x axis, and to its left."""
        if self._pull == 0.0:
            return 0.0, 0.0
        off = heading - self._settings.uphill
        return self._pull * math.cos(off), self._pull * math.sin(off)

    def push(self, against: float, left: float) -> tuple[float, float]:
        """(speed [m/s], turning rate [rad/s]) that gravity adds while the motors drive.

        The speed falls through the motors' finite stiffness. The centre of mass lies ahead of the driven axle and turns
        the chair downhill (measured by Richter et al., "Consequences of a cross slope on wheelchair handrim
        biomechanics", 2007: 0.87 Nm per degree of cross slope).
        """
        return -self._settings.compliance * against, self._settings.downhill_turn * left

    def roll(self, left: float, right: float, loads: tuple[float, float], aside: float) -> tuple[float, float, float]:
        """Ways (left, right, sideways) over the floor [m].

        Args:
            left: way of the left wheel's circumference [m].
            right: of the right wheel's.
            loads: acceleration that each wheel transmits, along x, with gravity's [m/s^2].
            aside: acceleration of gravity to the left [m/s^2].
        """
        s = self._settings
        patch_left, patch_right = self._patches.at(self._way)
        left *= 1.0 - _slip(max(s.slip_left, patch_left), math.copysign(s.slip_load, left) * loads[0])
        right *= 1.0 - _slip(max(s.slip_right, patch_right), math.copysign(s.slip_load, right) * loads[1])
        self._way += 0.5 * (abs(left) + abs(right))  # a chair that turns on the spot rolls off its patch as well
        return left, right, 0.5 * abs(left + right) * s.side_slip * aside


def _slip(steady: float, of_load: float) -> float:
    """Their sum; a locked wheel slides (the first bound), a spinning one still drives a little."""
    return min(max(steady + of_load, -1.0), 0.95)
