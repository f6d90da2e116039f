"""The shortest time to the dock that the chair's limits allow: the bound with which docking times are compared.

Speeds are piecewise linear (the accelerations are the inputs), the pose follows exactly up to a Gauss-Legendre rule of
order six, the durations are free. With the bay there are two phases: ahead of it the whole footprint stays outside,
inside it the bay's speed limit holds and the walls are kept clear of (no margin). What is left out makes the time
shorter, never longer: motor lag, delay, sight of the markers, areas between the nodes, entering the bay twice.

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
from seater_eval.baselines.minimum_time_programme import MinimumTimeProgramme, arrival_speeds

Array = NDArray[np.float64]
STEPS = (40, 20)  # of the motion ahead of the bay and inside it
_FEASIBLE = 1e-6  # [m, rad, m/s, rad/s] largest violation of a solution that counts


@dataclass(frozen=True)
class MinimumTimeSolution:
    """A feasible motion. Rows of `states`: x, y, heading, v, omega at `times`; accelerations are constant in
    between."""

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
        self, chair: Chair, dock: Dock | None, tolerance: Tolerance | None = None, steps: tuple[int, int] = STEPS
    ) -> None:
        """`dock`: its bay is respected (None: free space). `tolerance`: the target is the set of states from which the
        chair need not leave it again (None: at rest exactly at the dock). `steps` ahead of the bay and inside it."""
        self._chair, self._dock = chair, dock
        phases = [steps[0]] if dock is None else list(steps)
        self._steps = phases
        self._programme = MinimumTimeProgramme(chair, dock, tolerance, phases)
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


def profile_time(way: float, speed: float, acceleration: float) -> float:
    """Shortest time from rest to rest over `way` with bounded speed and acceleration: trapezoid or triangle."""
    way = abs(way)
    if way <= speed**2 / acceleration:
        return 2.0 * math.sqrt(way / acceleration)
    return way / speed + speed / acceleration


def straight_line_bound(limits: Limits, start: ArrayLike, tolerance: Tolerance) -> float:
    """A time [s] that nothing can beat, of a drive straight to the tolerance and of a turn on the spot, whichever is
    longer.

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
