"""Two front castors: where they point, and how they push the chair while they swing round.

A castor's wheel does not move sideways. With its pivot moving at speed u in direction psi, and the wheel trailing by t
in direction theta, this says d(theta)/dt = (u / t) sin(psi - theta) (the textbook castor, e.g. Campion, Bastin and
d'Andrea-Novel 1996), so for constant psi and a way s of the pivot

    tan((theta - psi) / 2) <- tan((theta - psi) / 2) exp(-s / t).

The tyre resists being swivelled on the spot; the force that swivels it acts across the castor's wheel and grows with
the angle to its motion (Gersdorf and Shi, "A castor wheel controller for differential drive wheelchairs", ICINCO 2010,
eq. 7: a share of the load on it). Motors of finite stiffness turn this into a loss of speed and a turn. The force
follows from the motion that is left, so it only ever brakes: the two are solved for together.
"""

from __future__ import annotations

import math

import numpy as np

from seater_sim.settings import CastorSettings

# Dry friction does not push back a chair that hardly moves: below about this speed it is proportional to it. [m/s]
BREAKAWAY = 0.02
# The iteration for the motion ends when no castor's speed changes by more than this [m/s], or after so many rounds.
TOLERANCE, ROUNDS = 1e-9, 100


class Castors:
    """Angles of both castors in base_link; 0: the wheel trails behind its pivot, positive: it points to the left."""

    def __init__(self, settings: CastorSettings, seed: int) -> None:
        self._settings = settings
        spread = np.random.default_rng([seed, 5]).uniform(-1.0, 1.0, 2) * settings.start_angle
        self.angles: list[float] = [float(angle) for angle in spread]  # left, right [rad]
        self._sides = (0.5 * settings.spread, -0.5 * settings.spread)

    def push(self, v: float, omega: float) -> tuple[float, float]:
        """(speed [m/s], turning rate [rad/s]) that they add to a chair that would move with v and omega without them.

        The pivot of castor i is at (a, y_i) and moves with u_i; the part j_i (v, omega) of it lies across the castor,
        and so does the force -j_i (v, omega) / (u_i + BREAKAWAY), a share of what it is when the wheel lies across.
        For given u_i the motion that is left solves

            (1 + sum_i A j_i^T j_i / (u_i + BREAKAWAY)) (v, omega)_left = (v, omega)
            A = diag(push_v / 2, push_omega / a)

        With A^-1 as the norm, its matrix is symmetric and at least 1: the castors take energy for any u_i and at any
        step. The u_i follow by fixed-point iteration.
        """
        s = self._settings
        if s.trail == 0.0 or (v == 0.0 and omega == 0.0):
            return 0.0, 0.0
        across = [self._across(angle, y) for angle, y in zip(self.angles, self._sides, strict=True)]
        left, speeds = (v, omega), self._pivot_speeds(v, omega)
        for _ in range(ROUNDS):
            left = self._braked(v, omega, across, speeds)
            before, speeds = speeds, self._pivot_speeds(*left)
            if max(abs(now - then) for now, then in zip(speeds, before, strict=True)) < TOLERANCE:
                break
        return left[0] - v, left[1] - omega

    def _across(self, angle: float, y: float) -> tuple[float, float]:
        """j: the pivot's speed to the left of its castor's wheel, per speed [-] and turning rate [m] of the chair."""
        sine, cosine = math.sin(angle), math.cos(angle)
        return -sine, cosine * self._settings.ahead + sine * y

    def _pivot_speeds(self, v: float, omega: float) -> list[float]:
        """[m/s] of both pivots."""
        return [math.hypot(v - omega * y, omega * self._settings.ahead) for y in self._sides]

    def _braked(
        self, v: float, omega: float, across: list[tuple[float, float]], speeds: list[float]
    ) -> tuple[float, float]:
        """(speed, turning rate) that are left of v and omega when the pivots move with `speeds`."""
        s = self._settings
        vv = vw = ww = 0.0
        for (along, turning), speed in zip(across, speeds, strict=True):
            weight = 1.0 / (speed + BREAKAWAY)
            vv += weight * along * along
            vw += weight * along * turning
            ww += weight * turning * turning
        a, b = 0.5 * s.push_v, s.push_omega / s.ahead
        determinant = (1.0 + a * vv) * (1.0 + b * ww) - a * b * vw * vw
        return (
            ((1.0 + b * ww) * v - a * vw * omega) / determinant,
            ((1.0 + a * vv) * omega - b * vw * v) / determinant,
        )

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
