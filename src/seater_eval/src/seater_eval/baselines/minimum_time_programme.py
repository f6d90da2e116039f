"""The nonlinear programme of the minimum time (see minimum_time): direct multiple shooting with free durations."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock, Limits, Tolerance
from seater_eval.baselines.minimum_time_guesses import Guess

Array = NDArray[np.float64]
_NODES = (0.5 - math.sqrt(0.15), 0.5, 0.5 + math.sqrt(0.15))  # Gauss-Legendre on [0, 1]
_WEIGHTS = (5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0)
_SMOOTHING = 1e-6  # penalty weight of the accelerations squared: only picks one of several solutions of equal time
_LONGEST = 200.0  # [s]


class MinimumTimeProgramme:
    """Direct multiple shooting; x = z0, then per step u, z (and inside the bay the two angles), then the durations."""

    def __init__(self, chair: Chair, dock: Dock | None, tolerance: Tolerance | None, steps: list[int]) -> None:
        self._chair, self._dock, self._steps = chair, dock, steps
        self._x: list[ca.SX] = []
        self._g: list[ca.SX] = []
        self.lower: list[float] = []
        self.upper: list[float] = []
        self.g_lower: list[float] = []
        self.g_upper: list[float] = []
        self._turns = ca.SX.sym("turns")  # the target's heading is this many whole turns [-]
        durations = [ca.SX.sym(f"T{i}") for i in range(len(steps))]
        self._cost = sum(durations[1:], durations[0])
        z = self._variable("z0", self._state_bounds(False))
        for phase, count in enumerate(steps):
            if phase == 1:  # slow from the very beginning of the bay on
                self._constrain(z[3], -self._bay_speed(), self._bay_speed())
            for _ in range(count):
                z = self._step(z, durations[phase] / count, inside=phase == 1)
        self._finish(z, tolerance)
        for duration in durations:
            self._x.append(duration)
            self.lower.append(1e-3)
            self.upper.append(_LONGEST)

    def functions(self) -> dict[str, ca.SX]:
        """As nlpsol takes it."""
        return {"x": ca.vertcat(*self._x), "p": self._turns, "f": self._cost, "g": ca.vertcat(*self._g)}

    def guess(self, guess: Guess) -> Array:
        """The variables for a guessed motion."""
        first = guess.states(0, self._steps[0])
        x = [*first[0]]
        for phase, count in enumerate(self._steps):
            states, h = guess.states(phase, count), guess.durations[phase] / count
            for k in range(count):
                x.extend((states[k + 1, 3:] - states[k, 3:]) / h)
                x.extend(states[k + 1])
                if phase == 1:
                    x.extend([-math.pi + 0.1, math.pi - 0.1] if k < count // 2 else [-0.5 * math.pi, 0.5 * math.pi])
        return np.array([*x, *guess.durations[: len(self._steps)]])

    def read(self, x: Array) -> tuple[Array, Array, Array]:
        """Times, states and accelerations in the variables."""
        times, states, inputs, at = [0.0], [x[:5]], [], 5
        durations = x[-len(self._steps) :]
        for phase, count in enumerate(self._steps):
            for _ in range(count):
                inputs.append(x[at : at + 2])
                states.append(x[at + 2 : at + 7])
                times.append(times[-1] + durations[phase] / count)
                at += 9 if phase == 1 else 7
        return np.array(times), np.array(states), np.array(inputs)

    def _variable(self, name: str, bounds: tuple[list[float], list[float]]) -> ca.SX:
        symbol = ca.SX.sym(name, len(bounds[0]))
        self._x.append(symbol)
        self.lower.extend(bounds[0])
        self.upper.extend(bounds[1])
        return symbol

    def _constrain(self, expression: ca.SX, low: float, high: float) -> None:
        self._g.append(expression)
        self.g_lower.extend([low] * expression.numel())
        self.g_upper.extend([high] * expression.numel())

    def _state_bounds(self, inside: bool) -> tuple[list[float], list[float]]:
        limits, free = self._chair.limits, [math.inf] * 3
        forward, backward = limits.v_max, limits.v_reverse_max
        if inside:
            forward, backward = min(forward, self._bay_speed()), min(backward, self._bay_speed())
        return [-math.inf, -math.inf, -math.inf, -backward, -limits.omega_max], [*free, forward, limits.omega_max]

    def _bay_speed(self) -> float:
        return self._chair.limits.v_bay_max

    def _step(self, z: ca.SX, h: ca.SX, inside: bool) -> ca.SX:
        limits = self._chair.limits
        u = self._variable("u", ([-limits.a_max, -limits.alpha_max], [limits.a_max, limits.alpha_max]))
        following = self._variable("z", self._state_bounds(inside))
        self._constrain(following - exact_step(z, u, h), 0.0, 0.0)
        self._cost += _SMOOTHING * h * ca.sumsqr(u)
        if self._dock is not None:
            self._areas(following, inside)
        return following

    def _areas(self, z: ca.SX, inside: bool) -> None:
        assert self._dock is not None
        bay, c, s = self._dock.bay, ca.cos(z[2]), ca.sin(z[2])
        corners = [(z[0] + c * a - s * b, z[1] + s * a + c * b) for a, b in self._chair.corners().tolist()]
        if not inside:
            self._constrain(ca.vertcat(*(x for x, _ in corners)), -math.inf, bay.entrance_x)
            return
        half = 0.5 * bay.width
        low, high = [-math.pi, 0.5 * math.pi], [-0.5 * math.pi, math.pi]
        angles = self._variable("beta", (low, high))  # normals of the lines that separate the chair from the two walls
        for angle, y_wall in ((angles[0], half), (angles[1], -half)):
            ahead = [ca.cos(angle) * (x - bay.entrance_x) + ca.sin(angle) * (y - y_wall) for x, y in corners]
            self._constrain(ca.vertcat(*ahead), 0.0, math.inf)
        self._constrain(ca.vertcat(*(x for x, _ in corners)), -math.inf, bay.back_wall_x)

    def _finish(self, z: ca.SX, tolerance: Tolerance | None) -> None:
        heading = z[2] - 2.0 * math.pi * self._turns
        if tolerance is None:
            self._constrain(ca.vertcat(z[:2], heading, z[3:]), 0.0, 0.0)
            return
        v, omega = arrival_speeds(self._chair.limits, tolerance)
        self._constrain(ca.sumsqr(z[:2]) / tolerance.position**2, -math.inf, 1.0)
        self._constrain(heading, -tolerance.heading, tolerance.heading)
        self._constrain(z[3], -v, v)
        self._constrain(z[4], -omega, omega)


def arrival_speeds(limits: Limits, tolerance: Tolerance) -> tuple[float, float]:
    """Largest speeds (v, omega) with which the chair can enter the tolerance and then stay in it while it brakes.

    Necessary, so that the time with them is a bound for the time of entering for good: the way left is at most the
    circle's diameter (1 % longer for a way that is bent within the heading tolerance), the turn left twice the
    tolerance.
    """
    return math.sqrt(2.0 * limits.a_max * 2.02 * tolerance.position), math.sqrt(
        4.0 * limits.alpha_max * tolerance.heading
    )


def exact_step(z: ca.SX, u: ca.SX, h: ca.SX) -> ca.SX:
    """State after `h` [s] under constant accelerations; speeds and heading exactly, the position by quadrature."""
    x, y = z[0], z[1]
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        t = node * h
        heading = z[2] + z[4] * t + 0.5 * u[1] * t**2
        v = z[3] + u[0] * t
        x += weight * h * v * ca.cos(heading)
        y += weight * h * v * ca.sin(heading)
    return ca.vertcat(x, y, z[2] + z[4] * h + 0.5 * u[1] * h**2, z[3] + u[0] * h, z[4] + u[1] * h)
