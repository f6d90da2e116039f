"""Two front castors: where they point, and how they push the chair while they swing round.

A castor's wheel does not move sideways. With its pivot moving at speed u in direction psi, and the wheel trailing by t
in direction theta, this says d(theta)/dt = (u / t) sin(psi - theta) (the textbook castor, e.g. Campion, Bastin and
d'Andrea-Novel 1996), so for constant psi and a way s of the pivot

    tan((theta - psi) / 2) <- tan((theta - psi) / 2) exp(-s / t).

The tyre resists being swivelled on the spot; the force that swivels it acts across the castor's wheel and grows with
the angle to its motion (Gersdorf and Shi, "A castor wheel controller for differential drive wheelchairs", ICINCO 2010,
eq. 7: a share of the load on it). Motors of finite stiffness turn this into a loss of speed and a turn.
"""

from __future__ import annotations

import math

import numpy as np

from seater_sim.settings import CastorSettings

# Dry friction does not push back a chair that hardly moves: below about this speed it is proportional to it. [m/s]
BREAKAWAY = 0.02


class Castors:
    """Angles of both castors in base_link; 0: the wheel trails behind its pivot, positive: it points to the left."""

    def __init__(self, settings: CastorSettings, seed: int) -> None:
        self._settings = settings
        spread = np.random.default_rng([seed, 5]).uniform(-1.0, 1.0, 2) * settings.start_angle
        self.angles: list[float] = [float(angle) for angle in spread]  # left, right [rad]
        self._sides = (0.5 * settings.spread, -0.5 * settings.spread)
        self._breakaway = max(BREAKAWAY, settings.push_v)

    def push(self, v: float, omega: float) -> tuple[float, float]:
        """(speed [m/s], turning rate [rad/s]) that they add to a chair that moves with v and omega.

        With s_i = sin(angle_i - psi_i), the force across castor i is proportional to s_i; its pivot is at (a, y_i).
        """
        s = self._settings
        if s.trail == 0.0 or (v == 0.0 and omega == 0.0):
            return 0.0, 0.0
        loss = turn = 0.0
        for angle, y in zip(self.angles, self._sides, strict=True):
            vx, vy = v - omega * y, omega * s.ahead
            speed = math.hypot(vx, vy)
            if speed == 0.0:
                continue
            sine, cosine = math.sin(angle), math.cos(angle)
            force = (sine * vx - cosine * vy) / (speed + self._breakaway)  # s_i, regularised at standstill
            loss += force * sine
            turn += force * (cosine + y / s.ahead * sine)
        return -0.5 * s.push_v * loss, s.push_omega * turn

    def swing(self, way: float, turn: float) -> None:
        """The chair has moved by `way` [m] and `turn` [rad] in a straight step or an arc."""
        trail, ahead = self._settings.trail, self._settings.ahead
        if trail == 0.0 or (way == 0.0 and turn == 0.0):
            return
        for i, y in enumerate(self._sides):
            dx, dy = way - turn * y, turn * ahead
            direction = math.atan2(dy, dx)
            half = 0.5 * (self.angles[i] - turn - direction)
            kept = math.exp(-math.hypot(dx, dy) / trail)
            self.angles[i] = direction + 2.0 * math.atan2(kept * math.sin(half), math.cos(half))
