"""One plan per control cycle: cold start, warm start from the last plan, what is done with a solve that was stopped."""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair
from seater_common.se2 import inverse, relative, transform_points, wrap_angles
from seater_nmpc.control.cold_start import heading_for_target, standing
from seater_nmpc.ocp.areas import Areas
from seater_nmpc.ocp.formulations import make_problem
from seater_nmpc.ocp.problem import step_lengths
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import Plan, WarmStart
from seater_nmpc.solve.guard import GuardedSolver
from seater_nmpc.solve.interface import Solution, Solver, SolveStatus
from seater_nmpc.solve.registry import make_solver

Array = NDArray[np.float64]

# Solves of a cold start among obstacles, each with the lines that separate the last one's plan from them.
_COLD_ROUNDS = 4
_RESTART_AFTER = 3  # failed solves in a row after which the warm start is thrown away


class Replanner:
    """Problem, solver and what one cycle hands on to the next. Poses of the states are in the target's frame."""

    def __init__(
        self,
        chair: Chair,
        parameters: ControlParameters,
        areas: Areas | None,
        *,
        deterministic: bool = False,
        solver: Solver | None = None,
    ) -> None:
        """`areas` in the dock's frame or None. `deterministic`: no wall-time limit. `solver` replaces the named one."""
        self._chair, self._parameters, self._areas = chair, parameters, areas
        self._placed: tuple[Array, Areas] | None = None  # a target and the areas seen from there
        self._problem = make_problem(chair, parameters, areas)
        solver = solver or make_solver(self._problem, parameters)
        self._solver = GuardedSolver(solver, max(parameters.fallback.feasibility, parameters.rti.feasibility))
        self._limit = None if deterministic else parameters.max_wall_time
        self._cold_limit = None if deterministic else parameters.max_wall_time_cold
        self._solver.prepare([self._limit, self._cold_limit])
        self.solve_cpu = 0.0  # the last solve's time on the processor, in this thread [s]
        self.reset()

    def reset(self) -> None:
        """Forget the plan: the next solve is a cold start."""
        self._start: WarmStart | None = None
        self._unfinished: WarmStart | None = None
        self.plan: Plan | None = None  # the last usable one
        self.stamp = 0.0  # and its time [s]
        self._target = np.zeros(3)
        self._heading = 0.0
        self._failures = 0

    @property
    def path(self) -> Array | None:
        """The last plan's poses (N + 1, 3) in the dock's frame."""
        return None if self.plan is None else composed(self._target, self.plan.states[:, :3])

    @property
    def name(self) -> str:
        """The solver's."""
        return self._solver.name

    @property
    def lead(self) -> float:
        """How long before the first state of a plan its speeds begin to count [s]."""
        return self._problem.lead

    def solve(
        self,
        state: Array,
        stamp: float,
        T_dock_target: Array,
        obstacles: list[Array],
        acceleration: tuple[float, float],
        slow: tuple[float, float] | None = None,
    ) -> Solution:
        """A plan from `state` (x, y, heading, v, omega), at `stamp` [s], to the target.

        Args:
            obstacles: convex anticlockwise outlines (n, 2) in the dock's frame [m].
            acceleration: between the last two commands [m/s^2, rad/s^2].
            slow: limits of |v| and |omega| beside the chair's [m/s, rad/s].
        """
        state = self._unwound(state)
        areas = self._areas_seen_from(T_dock_target)
        cold = self._start is None
        warm = self._warm_start(areas, stamp, T_dock_target)
        outlines = [transform_points(inverse(T_dock_target), outline) for outline in obstacles]
        solution = None
        for start in [warm] if warm is not None else self._cold_starts(state, areas):
            other = self._solve_from(start, cold, state, areas, outlines, acceleration, slow)
            if solution is None or self._better(other, solution):
                solution = other
        assert solution is not None  # there is one start at least
        if self.usable(solution):
            self._keep(solution, stamp, T_dock_target)
        else:
            self._resume(solution)
        return solution

    def _solve_from(
        self,
        start: WarmStart,
        cold: bool,
        state: Array,
        areas: Areas | None,
        outlines: list[Array],
        acceleration: tuple[float, float],
        slow: tuple[float, float] | None,
    ) -> Solution:
        """See `solve`; `outlines` in the target's frame."""
        limit = self._cold_limit if cold else self._limit
        for _ in range(_COLD_ROUNDS if cold and outlines else 1):
            lines = self._problem.obstacle_lines(outlines, self._problem.states(start.x))
            data, began = self._problem.data(state, areas, lines, acceleration, slow), time.thread_time()
            solution = self._solver.solve(data, start, limit)
            self.solve_cpu = time.thread_time() - began
            if not self.usable(solution):
                break
            start = WarmStart(solution.x)
        return solution

    def _better(self, a: Solution, b: Solution) -> bool:
        if self.usable(a) != self.usable(b):
            return self.usable(a)
        return a.cost < b.cost

    def usable(self, solution: Solution) -> bool:
        """Whether its plan may be followed: solved, or stopped where all constraints hold."""
        if solution.status is SolveStatus.SOLVED:
            return True
        return solution.status is SolveStatus.LIMIT and solution.violation <= self._parameters.fallback.feasibility

    def _areas_seen_from(self, T_dock_target: Array) -> Areas | None:
        """The areas in the target's frame; the same object as long as the target is the same."""
        if self._areas is not None and (self._placed is None or not np.array_equal(T_dock_target, self._placed[0])):
            self._placed = T_dock_target.copy(), self._areas.in_frame(T_dock_target)
        return None if self._placed is None else self._placed[1]

    def _unwound(self, state: Array) -> Array:
        """The same state, its heading counted on from the last one's: no flip between half a turn left and right."""
        state = state.copy()
        turns = round((self._heading - state[2]) / (2.0 * math.pi))
        if abs(state[2] + 2.0 * math.pi * turns) <= math.pi + 0.3:
            state[2] += 2.0 * math.pi * turns
        self._heading = float(state[2])
        return state

    def _cold_starts(self, state: Array, areas: Areas | None) -> list[WarmStart]:
        """The optimisation's minima are next to where it begins: the cheapest of several counts."""
        lengths = step_lengths(self._parameters)
        ways = [standing(state, len(lengths)), heading_for_target(state, lengths, self._chair.limits)]
        return [WarmStart(self._problem.guess(way, areas)) for way in ways if way is not None]

    def _warm_start(self, areas: Areas | None, stamp: float, T_dock_target: Array) -> WarmStart | None:
        """The last plan, moved on in time and seen from the present target, with the multipliers that it had."""
        if self._unfinished is not None:
            return self._unfinished
        if self._start is None or self.plan is None:
            return None
        states = self.plan.shifted(max(0.0, stamp - self.stamp))
        if not np.array_equal(T_dock_target, self._target):
            change = relative(T_dock_target, self._target)
            heading = states[:, 2] + change[2]
            states[:, :3] = composed(change, states[:, :3])
            states[:, 2] = heading
        return WarmStart(self._problem.guess(states, areas, self._start.x), self._start.lam_x, self._start.lam_g)

    def _keep(self, solution: Solution, stamp: float, T_dock_target: Array) -> None:
        self._unfinished, self._failures = None, 0
        self._start, self.plan = solution.warm_start(), self._problem.plan(solution.x)
        self.stamp, self._target = stamp, T_dock_target

    def _resume(self, solution: Solution) -> None:
        """After a stopped solve the next one goes on from where it got to; after several, it starts anew."""
        self._failures += 1
        again = solution.status is SolveStatus.LIMIT and self._failures < _RESTART_AFTER
        self._unfinished = solution.warm_start() if again else None
        if self._failures >= _RESTART_AFTER:
            self._start = None


def composed(T: Array, poses: Array) -> Array:
    """compose(T, pose) for each row of `poses` (n, 3)."""
    return np.column_stack([transform_points(T, poses[:, :2]), wrap_angles(poses[:, 2] + T[2])])
