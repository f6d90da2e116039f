"""The shortest time to the dock that the chair's limits allow: the bound with which docking times are compared.

Speeds are piecewise linear (the accelerations are the inputs), the pose follows exactly up to a Gauss-Legendre rule of
order six, the durations are free. With the bay there are two phases: ahead of it the whole footprint stays outside, inside
it the bay's speed limit holds and the walls are kept clear of (no margin). What is left out makes the time shorter, never
longer: motor lag, delay, sight of the markers, areas between the nodes, entering the bay twice.

The problem is not convex: several initial guesses, the best feasible solution is taken. It is a bound as far as one of
them leads to the global optimum; `straight_line_bound` is one for certain, but a weak one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair, Dock, Limits, Tolerance
from seater_eval.baselines.minimum_time_guesses import Guess, guesses

Array = NDArray[np.float64]

_NODES = (0.5 - math.sqrt(0.15), 0.5, 0.5 + math.sqrt(0.15))  # Gauss-Legendre on [0, 1]
_SHARES = (5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0)
_FEASIBLE = 1e-6  # [m, rad, m/s, rad/s] largest violation of a solution that counts
_SMOOTHING = 1e-6  # price of acceleration squared: only picks one among solutions of equal time
_LONGEST = 200.0  # [s]


@dataclass(frozen=True)
class MinimumTimeSolution:
    """A feasible motion. Rows of `states`: x, y, heading, v, omega at `times`; accelerations are constant in between."""

    time: float  # [s]
    times: Array  # (n + 1,)
    states: Array  # (n + 1, 5)
    accelerations: Array  # (n, 2)
    guess: str  # the initial guess that led here
    agreeing: int  # how many guesses led to the same time within 1 %
    violation: float  # largest violation of a constraint at the nodes


class MinimumTime:
    """Solves for many starts; building it takes a moment."""

    def __init__(
        self, chair: Chair, dock: Dock | None, tolerance: Tolerance | None = None, steps: tuple[int, int] = (40, 20)
    ) -> None:
        """`dock`: its bay is respected (None: free space). `tolerance`: the target is the set of states from which the chair
        need not leave it again (None: at rest exactly at the dock). `steps` ahead of the bay and inside it."""
        self._chair, self._dock = chair, dock
        phases = [steps[0]] if dock is None else list(steps)
        self._steps = phases
        self._programme = _Programme(chair, dock, tolerance, phases)
        self._solver = ca.nlpsol("minimum_time", "ipopt", self._programme.functions(), _OPTIONS)

    def solve(self, start: ArrayLike, max_guesses: int | None = None) -> MinimumTimeSolution | None:
        """From rest at `start` (x, y, heading in the dock's frame); None when no guess leads to a feasible motion."""
        start = np.asarray(start, dtype=float)
        found: list[MinimumTimeSolution] = []
        for guess in guesses(self._chair, self._dock, start)[:max_guesses]:
            solution = self._solve(start, guess)
            if solution is not None:
                found.append(solution)
        if not found:
            return None
        best = min(found, key=lambda solution: solution.time)
        agreeing = sum(solution.time <= 1.01 * best.time for solution in found)
        return MinimumTimeSolution(**{**best.__dict__, "agreeing": agreeing})

    def _solve(self, start: Array, guess: Guess) -> MinimumTimeSolution | None:
        p = self._programme
        lower, upper = np.array(p.lower), np.array(p.upper)
        lower[:5] = upper[:5] = [*start, 0.0, 0.0]
        result = self._solver(
            x0=p.guess(guess), p=guess.turns, lbx=lower, ubx=upper, lbg=np.array(p.g_lower), ubg=np.array(p.g_upper)
        )
        x, g = result["x"].full().ravel(), result["g"].full().ravel()
        if not (np.all(np.isfinite(x)) and np.all(np.isfinite(g))):
            return None
        outside = [lower - x, x - upper, np.array(p.g_lower) - g, g - np.array(p.g_upper)]
        violation = max(0.0, *(float(np.max(value)) for value in outside))
        if violation > _FEASIBLE:
            return None
        times, states, accelerations = p.read(x)
        return MinimumTimeSolution(float(times[-1]), times, states, accelerations, guess.name, 1, violation)


_OPTIONS: dict[str, Any] = {
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "print_time": False,
    "error_on_fail": False,
    "ipopt.max_iter": 400,
    "ipopt.tol": 1e-7,
    "ipopt.mu_strategy": "adaptive",
}


class _Programme:
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
        angles = self._variable("beta", (low, high))  # normals of the lines that part the chair from the two walls
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

    Necessary, so that the time with them is a bound for the time of entering for good: the way left is at most the circle's
    diameter (1 % longer for a way that is bent within the heading tolerance), the turn left twice the tolerance.
    """
    return math.sqrt(2.0 * limits.a_max * 2.02 * tolerance.position), math.sqrt(
        4.0 * limits.alpha_max * tolerance.heading
    )


def exact_step(z: ca.SX, u: ca.SX, h: ca.SX) -> ca.SX:
    """State after `h` [s] under constant accelerations; speeds and heading exactly, the position by quadrature."""
    x, y = z[0], z[1]
    for node, share in zip(_NODES, _SHARES, strict=True):
        t = node * h
        heading = z[2] + z[4] * t + 0.5 * u[1] * t**2
        v = z[3] + u[0] * t
        x += share * h * v * ca.cos(heading)
        y += share * h * v * ca.sin(heading)
    return ca.vertcat(x, y, z[2] + z[4] * h + 0.5 * u[1] * h**2, z[3] + u[0] * h, z[4] + u[1] * h)


def profile_time(way: float, speed: float, acceleration: float) -> float:
    """Shortest time from rest to rest over `way` with bounded speed and acceleration: trapezoid or triangle."""
    way = abs(way)
    if way <= speed**2 / acceleration:
        return 2.0 * math.sqrt(way / acceleration)
    return way / speed + speed / acceleration


def straight_line_bound(limits: Limits, start: ArrayLike, tolerance: Tolerance) -> float:
    """A time [s] that nothing can beat, of a drive straight to the tolerance and of a turn on the spot, whichever is longer.

    The larger of the two speed limits counts both ways; arriving at `arrival_speeds` costs nothing.
    """
    x, y, heading = np.asarray(start, dtype=float)
    v, omega = arrival_speeds(limits, tolerance)
    fastest = max(limits.v_max, limits.v_reverse_max)
    way = max(0.0, math.hypot(x, y) - tolerance.position)
    turn = max(0.0, abs(math.remainder(heading, 2.0 * math.pi)) - tolerance.heading)
    return max(
        _arriving_time(way, fastest, limits.a_max, v), _arriving_time(turn, limits.omega_max, limits.alpha_max, omega)
    )


def _arriving_time(way: float, speed: float, acceleration: float, arrival: float) -> float:
    """As `profile_time`, but arriving with speed `arrival`."""
    arrival = min(arrival, speed)
    if way <= 0.5 * arrival**2 / acceleration:
        return math.sqrt(2.0 * way / acceleration)
    peak = math.sqrt(acceleration * way + 0.5 * arrival**2)
    if peak <= speed:
        return (2.0 * peak - arrival) / acceleration
    rest = way - (speed**2 - 0.5 * arrival**2) / acceleration
    return (2.0 * speed - arrival) / acceleration + rest / speed
