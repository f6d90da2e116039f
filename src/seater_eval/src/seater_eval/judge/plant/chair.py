"""The chair on its floor: two driven wheels that slip, castors that push, a slope that pulls."""

from __future__ import annotations

import math

import numpy as np

from seater_eval.judge.plant.built import TRACK, Built
from seater_eval.judge.plant.castors import Castors
from seater_eval.judge.plant.drive import Motors
from seater_eval.judge.plant.effects import Effects

STEP = 0.005  # [s]
_GRAVITY = 9.81  # [m/s^2]
# How far the motors give way under gravity, assumed here: 2 degrees along the way cost 2 cm/s; 2 degrees across it turn
# the chair downhill by 0.03 rad per metre. The turning moment: Brubaker, McLaurin, McClay, "Effects of side slope on
# wheelchair performance", J. Rehabil. Res. Dev. 23(2), 1986.
_GIVES_WAY = 0.05  # [s] speed lost per acceleration
_TURNS_DOWN = 0.1  # [s^2/m^2] turn per metre and acceleration
_ROLLING = 0.05  # [m/s] below this speed friction takes more and more of the slope's pull
_RELAXATION = 0.05  # [m] of way on which a wheel's slip follows the floor (a tyre's relaxation length)
_THROUGH_WHEELS = 0.5  # share of the castors' push that turns the wheels, so that the encoders see it; the rest skids


class IndependentChair:
    """True pose of base_link in the dock's frame, true speeds, and how far the wheels have rolled."""

    def __init__(
        self, effects: Effects, built: Built, start: tuple[float, float, float], rng: np.random.Generator
    ) -> None:
        """`rng`: of the delay's jitter."""
        self._built = built
        self._motors = Motors(effects.drive, built, rng)
        self._castors = Castors(effects.floor.castor_omega, effects.floor.castor_v, built.castor_side)
        self.x, self.y, self.heading = start
        self.v = self.omega = 0.0  # [m/s, rad/s] over the last step
        self._slips = [self._floor_slip(0.5 * TRACK, 0), self._floor_slip(-0.5 * TRACK, 1)]
        self.rolled = [0.0, 0.0]  # [m] left, right, as a wheel of nominal radius would have

    def command(self, now: float, v: float, omega: float) -> None:
        """Ask for v [m/s] and omega [rad/s] at `now` [s]."""
        self._motors.command(now, v, omega)

    def step(self, now: float) -> None:
        """From `now` [s] to one STEP later."""
        built, half = self._built, 0.5 * TRACK
        v, omega = self._motors.step(now, STEP)
        push_v, push_omega = self._castors.step(v, omega, STEP)
        pull_v, pull_omega = self._pull(v)
        v += pull_v + _THROUGH_WHEELS * push_v
        omega += pull_omega + _THROUGH_WHEELS * push_omega
        left = (v - half * omega) * built.strength[0]
        right = (v + half * omega) * built.strength[1]
        self.rolled[0] += left * STEP
        self.rolled[1] += right * STEP
        left *= (1.0 + built.radius[0]) * (1.0 - self._slip(half, 0, left))
        right *= (1.0 + built.radius[1]) * (1.0 - self._slip(-half, 1, right))
        self.v = 0.5 * (left + right) + (1.0 - _THROUGH_WHEELS) * push_v
        self.omega = (right - left) / (TRACK * (1.0 + built.track)) + (1.0 - _THROUGH_WHEELS) * push_omega
        middle = self.heading + 0.5 * self.omega * STEP
        self.x += self.v * STEP * math.cos(middle)
        self.y += self.v * STEP * math.sin(middle)
        self.heading = math.remainder(self.heading + self.omega * STEP, 2.0 * math.pi)

    def _pull(self, v: float) -> tuple[float, float]:
        """What the slope does to (v, omega)."""
        up_x, up_y = self._built.slope
        c, s = math.cos(self.heading), math.sin(self.heading)
        along, across = up_x * c + up_y * s, -up_x * s + up_y * c  # uphill ahead, uphill to the left
        rolling = min(1.0, abs(v) / _ROLLING)
        return -_GIVES_WAY * _GRAVITY * along * rolling, -_TURNS_DOWN * _GRAVITY * across * abs(v)

    def _slip(self, left: float, wheel: int, speed: float) -> float:
        """Of a wheel that rolls with `speed` [m/s]; see _floor_slip."""
        now, floor = self._slips[wheel], self._floor_slip(left, wheel)
        if now != floor:
            self._slips[wheel] = floor + (now - floor) * math.exp(-abs(speed) * STEP / _RELAXATION)
        return self._slips[wheel]

    def _floor_slip(self, left: float, wheel: int) -> float:
        """Where it has come to rest, of a wheel that stands `left` [m] of the axle's middle."""
        x, y = self.x - left * math.sin(self.heading), self.y + left * math.cos(self.heading)
        for patch in self._built.patches:
            if (x - patch.x) ** 2 + (y - patch.y) ** 2 < patch.radius**2:
                return max(patch.slip, self._built.slip[wheel])
        return self._built.slip[wheel]
