"""The docking controller: vehicle pose, velocity and dock pose in, a safe velocity command out. No ROS."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair, Dock
from seater_common.se2 import compose, inverse, relative, transform_points, wrap_angle
from seater_nmpc.braking import BrakingCheck
from seater_nmpc.command import Command, Counters, Status
from seater_nmpc.geometry import Areas, dock_areas
from seater_nmpc.guard import GuardedSolver
from seater_nmpc.limits import clamp, in_bay
from seater_nmpc.nlp import Plan, WarmStart
from seater_nmpc.ocp import make_problem
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.prediction import CommandHistory, coasting_pose
from seater_nmpc.separation import convex_outline
from seater_nmpc.solver import Solution, Solver, SolveStatus, make_solver

Array = NDArray[np.float64]
Target = str | Sequence[float] | Array

_SPEED_MISMATCH = (
    0.05  # [m/s, rad/s] by which the measured speed may differ from the commanded one beside what lag explains
)
_COLD_ROUNDS = 4  # solves of a cold start among obstacles, each with the lines that part the last one's plan from them
_FARTHEST = 1000.0  # [m] distance of the target at which no solver is asked: from 1e300 m fatrop does not come back
_RESTART_AFTER = 3  # failed solves in a row after which the warm start is thrown away
_TOO_NEAR = "an obstacle is within the stopping distance"


class DockingController:
    """Drives the chair to the dock, or to another pose that is given in the dock's frame.

    Poses are (x, y, heading) in any one common frame (odom, say). The whole use, without ROS:

        from seater_common.geometry import Chair, Dock
        from seater_common.se2 import arc_step
        from seater_nmpc.controller import DockingController

        controller = DockingController(Chair(), Dock())
        pose, velocity, dock_pose, period = [-2.5, 0.8, -0.35], (0.0, 0.0), [0.0, 0.0, 0.0], 0.05
        for cycle in range(300):
            command = controller.command(pose, velocity, dock_pose)
            velocity = (command.v, command.omega)
            pose = arc_step(pose, *velocity, period)  # here your chair drives
        print(pose)  # at the dock, a hundredth of a millimetre away

    Whatever comes in, the command is finite and within the chair's limits of speed and acceleration. Without a usable
    solution the last plan is followed for a short time (`fallback/max_plan_age`), then the chair brakes and stands. A
    command after which the chair could not stop short of an obstacle is not given: it brakes instead.
    """

    def __init__(
        self,
        chair: Chair,
        dock: Dock,
        parameters: ControlParameters | None = None,
        *,
        deterministic: bool = False,
        solver: Solver | None = None,
    ) -> None:
        """`deterministic`: no wall-time limit, so that a slow machine decides the same. `solver` replaces the named one."""
        self._chair, self._dock = chair, dock
        self.parameters = parameters or ControlParameters()
        self._areas = dock_areas(dock) if self.parameters.walls else None
        self._problem = make_problem(chair, self.parameters, self._areas)
        solver = solver or make_solver(
            self._problem.functions, self.parameters, self._problem.refinement, self._problem.curvature
        )
        feasibility = max(self.parameters.fallback.feasibility, self.parameters.rti.feasibility)
        self._solver = GuardedSolver(solver, feasibility)
        ipopt = self.parameters.ipopt
        self._limit = None if deterministic else ipopt.max_wall_time
        self._cold_limit = None if deterministic else ipopt.max_wall_time_cold
        self._solver.prepare([self._limit, self._cold_limit])
        self._history = CommandHistory(self.parameters.prediction)
        prediction = self.parameters.prediction
        period = self.parameters.control_period
        self._braking = BrakingCheck(chair, self.parameters.stop_margin, period, prediction.motor_lag)
        self.counters = Counters()
        self._clock = self._solve_cpu = 0.0
        self._acts_at = np.zeros(3)  # base_link in the dock's frame where the next command begins to act
        self._obstacles: list[Array] = []
        self.reset()

    def reset(self) -> None:
        """Forget plan and commands, as at the beginning of a goal."""
        self._history.clear()
        self._start: WarmStart | None = None
        self._unfinished: WarmStart | None = None
        self._plan: Plan | None = None
        self._plan_stamp = 0.0
        self._plan_target = np.zeros(3)
        self._heading = 0.0
        self.counters.consecutive_failures = 0

    def reset_commands(self) -> None:
        """Forget the commands but keep the plan: the next plan begins with the measured speed."""
        self._history.clear()

    @property
    def obstacles(self) -> list[Array]:
        """What `set_obstacles` was given last, as convex anticlockwise outlines (n, 2) in the dock's frame [m]."""
        return self._obstacles

    def set_obstacles(self, polygons: Sequence[ArrayLike]) -> None:
        """Obstacles to keep clear of from now on (an empty list: none), each by its corners (n, 2) in the dock's frame [m].

        The convex hull of the corners counts. They hold until the next call. Without walls in the problem (`walls: false`)
        there are no areas at all, and obstacles are refused.

        Raises:
            ValueError: a polygon is not finite or has no area, or the problem has no areas; what held before still holds.
        """
        outlines = [convex_outline(polygon) for polygon in polygons]
        if outlines and self._areas is None:
            raise ValueError("control/walls: is false, must be true for obstacles to be kept clear of")
        self._obstacles = outlines

    def warm_up(self) -> None:
        """Solve once cold and once warm, so that no cycle pays for loading the solver."""
        for _ in range(2):
            self.command([self._dock.predock_x, 0.0, 0.0], (0.0, 0.0), [0.0, 0.0, 0.0])
        self.reset()
        self.counters = Counters()

    def command(
        self,
        vehicle_pose: ArrayLike,
        velocity: tuple[float, float],
        dock_pose: ArrayLike,
        target: Target = "dock",
        stamp: float | None = None,
    ) -> Command:
        """The command for this control cycle.

        Args:
            vehicle_pose: base_link, (x [m], y [m], heading [rad]) in the common frame, at `stamp`.
            velocity: measured (v [m/s], omega [rad/s]).
            dock_pose: the dock's frame in the common frame.
            target: `dock`, `predock`, or a pose (x, y, heading) in the dock's frame.
            stamp: time of the vehicle pose [s]; without it, one control period after the last call.
        """
        stamp = self._clock + self.parameters.control_period if stamp is None else stamp
        numbers = [*np.ravel(vehicle_pose), *velocity, *np.ravel(dock_pose), stamp]
        self.counters.cycles += 1
        if not all(math.isfinite(value) for value in numbers):
            self.counters.refused_inputs += 1
            return self._fall_back(self._clock, None, "input not finite")
        self._clock = stamp
        T_dock_target = self._target(target)
        pose, v, omega = self._history.roll(stamp, vehicle_pose, *velocity)
        before = self._speeds_before(v, omega)
        self._acts_at = relative(dock_pose, pose)
        ahead = coasting_pose(pose, v, omega, self.parameters.prediction.motor_lag)
        ahead = coasting_pose(ahead, *before, -self._problem.lead)
        state = np.concatenate([relative(compose(dock_pose, T_dock_target), ahead), before])
        if not (np.all(np.isfinite(state)) and np.max(np.abs(state[:2])) <= _FARTHEST):
            self.counters.refused_inputs += 1
            return self._fall_back(stamp, None, f"target is farther than {_FARTHEST:.0f} m")
        areas = None if self._areas is None else self._areas.in_frame(T_dock_target)
        solution = self._solve(state, areas, stamp, T_dock_target)
        slow = self._areas is not None and in_bay(self._chair, self._dock.bay, self._acts_at)
        if not self._usable(solution):
            return self._fall_back(stamp, solution, solution.text, slow)
        return self._follow(solution, stamp, compose(dock_pose, T_dock_target), before, slow)

    def _target(self, target: Target) -> Array:
        if isinstance(target, str):
            named = {"dock": [0.0, 0.0, 0.0], "predock": [self._dock.predock_x, 0.0, 0.0]}
            if target not in named:
                raise ValueError(f"target: is {target!r}, must be one of {', '.join(named)} or a pose")
            return np.array(named[target])
        return np.asarray(target, dtype=float)

    def _speeds_before(self, v: float, omega: float) -> tuple[float, float]:
        """Speeds that the plan begins with: the last command, unless the chair plainly does not follow it."""
        last = self._history.last
        if last is None:
            return v, omega
        limits, prediction = self._chair.limits, self.parameters.prediction
        window = prediction.motor_lag + prediction.command_delay + 2.0 * self.parameters.control_period
        result = []
        for sent, measured, rate in zip(last, (v, omega), (limits.a_max, limits.alpha_max), strict=True):
            reach = rate * window + _SPEED_MISMATCH
            result.append(min(max(sent, measured - reach), measured + reach))
        return result[0], result[1]

    def _solve(self, state: Array, areas: Areas | None, stamp: float, T_dock_target: Array) -> Solution:
        turns = round((self._heading - state[2]) / (2.0 * math.pi))
        if abs(state[2] + 2.0 * math.pi * turns) <= math.pi + 0.3:  # no flipping between half a turn left and right
            state[2] += 2.0 * math.pi * turns
        self._heading = float(state[2])
        cold = self._start is None
        start = self._warm_start(areas, stamp, T_dock_target)
        if start is None:
            states = np.repeat(state[None, :], self.parameters.horizon + 1, axis=0)
            states[:, 3:] = 0.0
            start = WarmStart(self._problem.guess(states, areas))
        acceleration = self._history.acceleration(self.parameters.control_period)
        outlines = [transform_points(inverse(T_dock_target), outline) for outline in self._obstacles]
        limit = self._cold_limit if cold else self._limit
        for _ in range(_COLD_ROUNDS if cold and outlines else 1):
            lines = self._problem.obstacle_lines(outlines, self._problem.states(start.x))
            data, began = self._problem.data(state, areas, lines, acceleration), time.thread_time()
            solution = self._solver.solve(data, start, limit)
            self._solve_cpu = time.thread_time() - began
            if not self._usable(solution):
                break
            start = WarmStart(solution.x)
        if self._usable(solution):
            self._unfinished = None
            self._start, self._plan = solution.warm_start(), self._problem.plan(solution.x)
            self._plan_stamp, self._plan_target = stamp, T_dock_target
        else:
            self._resume(solution)
        return solution

    def _resume(self, solution: Solution) -> None:
        """After a stopped solve the next one goes on from where it got to; after several, it starts anew."""
        if solution.status is SolveStatus.LIMIT and self.counters.consecutive_failures + 1 < _RESTART_AFTER:
            self._unfinished = solution.warm_start()
        else:
            self._unfinished = None
        if self.counters.consecutive_failures + 1 >= _RESTART_AFTER:
            self._start = None

    def _warm_start(self, areas: Areas | None, stamp: float, T_dock_target: Array) -> WarmStart | None:
        """The last plan, moved on in time and seen from the present target, with the multipliers that it had."""
        if self._unfinished is not None:
            return self._unfinished
        if self._start is None or self._plan is None:
            return None
        states = self._plan.shifted(max(0.0, stamp - self._plan_stamp))
        if not np.array_equal(T_dock_target, self._plan_target):
            change = relative(T_dock_target, self._plan_target)
            heading = states[:, 2] + change[2]
            states[:, :3] = _composed(change, states[:, :3])
            states[:, 2] = heading
        return WarmStart(self._problem.guess(states, areas, self._start.x), self._start.lam_x, self._start.lam_g)

    def _usable(self, solution: Solution) -> bool:
        if solution.status is SolveStatus.SOLVED:
            return True
        return solution.status is SolveStatus.LIMIT and solution.gap <= self.parameters.fallback.feasibility

    def _follow(
        self, solution: Solution, stamp: float, target: Array, before: tuple[float, float], slow: bool
    ) -> Command:
        plan = self._problem.plan(solution.x)
        v, omega = plan.speeds_at(0.0 if plan.speeds_held else self.parameters.control_period)
        v, omega = clamp(self._chair, v, omega, before, self.parameters.control_period, slow)
        self.counters.consecutive_failures = 0
        if not self._stops_clear(v, omega):
            self.counters.obstacle_stops += 1
            return self._brake(stamp, solution, _TOO_NEAR, slow)
        self._history.sent(stamp, v, omega)
        status = Status.SOLVED
        if solution.status is SolveStatus.LIMIT:
            self.counters.time_limits += 1
            status = Status.TIME_LIMIT
        return Command(
            v,
            omega,
            status,
            self._solver.name,
            solution.text,
            solution.solve_time,
            self._solve_cpu,
            solution.iterations,
            solution.cost,
            max(plan.violation, solution.gap),
            _composed(target, plan.states[:, :3]),
        )

    def _fall_back(self, stamp: float, solution: Solution | None, text: str, slow: bool = False) -> Command:
        """The last plan followed further, else braking."""
        self.counters.consecutive_failures += 1
        age, period = stamp - self._plan_stamp, self.parameters.control_period
        if solution is not None and self._plan is not None and age <= self.parameters.fallback.max_plan_age + 1e-9:
            v, omega = self._plan.speeds_at(age + period)
            v, omega = clamp(self._chair, v, omega, self._history.last or (0.0, 0.0), period, slow)
            if self._stops_clear(v, omega):
                self.counters.shifted += 1
                return self._sent(stamp, v, omega, Status.FALLBACK_SHIFTED, solution, text)
        self.counters.braked += 1
        return self._brake(stamp, solution, text, slow)

    def _brake(self, stamp: float, solution: Solution | None, text: str, slow: bool) -> Command:
        """Slower with the curvature kept, which ends in standing."""
        before, period = self._history.last or (0.0, 0.0), self.parameters.control_period
        v, omega = _braked(before, self._chair.limits.a_max * period)
        v, omega = clamp(self._chair, v, omega, before, period, slow)
        return self._sent(stamp, v, omega, Status.FALLBACK_BRAKE, solution, text)

    def _sent(
        self, stamp: float, v: float, omega: float, status: Status, solution: Solution | None, text: str
    ) -> Command:
        """A command that does not come from a new plan; remembered as sent."""
        self._history.sent(stamp, v, omega)
        wall, cpu, iterations = 0.0, 0.0, 0
        if solution is not None:
            wall, cpu, iterations = solution.solve_time, self._solve_cpu, solution.iterations
        return Command(v, omega, status, self._solver.name, text, wall, cpu, iterations)

    def _stops_clear(self, v: float, omega: float) -> bool:
        return self._braking.passes(self._acts_at, v, omega, self._obstacles)


def _composed(T: Array, poses: Array) -> Array:
    """compose(T, pose) for each row of `poses` (n, 3)."""
    headings = [wrap_angle(heading) for heading in poses[:, 2] + T[2]]
    return np.column_stack([transform_points(T, poses[:, :2]), headings])


def _braked(before: tuple[float, float], change: float) -> tuple[float, float]:
    v, omega = before
    if abs(v) <= change:
        return 0.0, 0.0
    slower = v - math.copysign(change, v)
    return slower, omega * slower / v
