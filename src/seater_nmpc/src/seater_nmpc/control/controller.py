"""The docking controller: vehicle pose, velocity and dock pose in, a safe velocity command out. No ROS."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.se2 import compose, relative
from seater_nmpc.control.actuation import Actuation
from seater_nmpc.control.braking import braked, curvature_at
from seater_nmpc.control.clearance import Clearance
from seater_nmpc.control.command import Command, Counters, Status
from seater_nmpc.control.driven import Driven
from seater_nmpc.control.limits import clamp, in_bay, within_reach
from seater_nmpc.control.pace import Pace
from seater_nmpc.control.replanner import Replanner, composed
from seater_nmpc.control.target import Target
from seater_nmpc.control.to_and_fro import ToAndFro
from seater_nmpc.control.way_round import WayRound
from seater_nmpc.drive.prediction import CommandHistory, coasting_pose
from seater_nmpc.ocp.areas import dock_areas
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.solve.interface import Solution, Solver, SolveStatus

Array = NDArray[np.float64]

_FARTHEST = 1000.0  # [m] distance of the target at which no solver is asked: from 1e300 m fatrop does not come back


class DockingController:
    """Drives the chair to the dock, or to another pose that is given in the dock's frame.

    Poses are (x, y, heading) in any one common frame (odom, say). The whole use, without ROS:

        from seater_common.geometry import Chair, Dock
        from seater_common.se2 import arc_step
        from seater_nmpc.control.controller import DockingController

        controller = DockingController(Chair(), Dock())
        pose, velocity, dock_pose, period = [-2.5, 0.8, -0.35], (0.0, 0.0), [0.0, 0.0, 0.0], 0.05
        for cycle in range(300):
            command = controller.command(pose, velocity, dock_pose)
            velocity = (command.v, command.omega)
            pose = arc_step(pose, *velocity, period)  # here your chair drives
        print(pose)  # at the dock, some hundredths of a millimetre away

    Whatever comes in, the command is finite and within the chair's limits of speed and acceleration. Without a usable
    solution the last plan is followed for a short time (`fallback/max_plan_age`), then the chair brakes and stands. A
    command after which the chair could not stop short of an obstacle, or of a wall, is not given: it brakes instead.
    """

    def __init__(
        self,
        chair: Chair,
        dock: Dock,
        parameters: ControlParameters | None = None,
        *,
        deterministic: bool = False,
        solver: Solver | None = None,
        camera: CameraModel | None = None,
    ) -> None:
        """`deterministic`: no wall-time limit, so a slow machine decides the same. `solver` replaces the named one.
        `camera`: what keeps the markers in view; None: a narrow one is reckoned with."""
        self._chair, self._dock = chair, dock
        self.parameters = parameters or ControlParameters()
        self._areas = dock_areas(dock, chair.camera, camera) if self.parameters.walls else None
        self._replanner = Replanner(chair, self.parameters, self._areas, deterministic=deterministic, solver=solver)
        self.history = CommandHistory(self.parameters.prediction)  # of all that the chair is asked for, by whomever
        self._commands, self._begins = self.history.view(), True
        prediction = self.parameters.prediction
        self._actuation = Actuation(chair, self.history, adapt=prediction.adapt)
        self.pace = Pace(chair.limits, self.parameters.control_period)
        self._clearance = Clearance(chair, dock.bay, self.parameters)
        self._way_round = WayRound(chair, dock, self.parameters, camera)
        self.counters = Counters()
        self._clock = 0.0
        # base_link in the dock's frame, and its speed [m/s], where the next command begins to act
        self._acts_at, self._speed_there = np.zeros(3), 0.0
        self.reset()

    def reset(self) -> None:
        """Forget the plan, as at a goal's beginning: the next begins with the measured speeds, whatever was sent."""
        self._begins = True
        self.pace.restart()
        self._driven = Driven()
        self._replanner.reset()
        self._to_and_fro = ToAndFro()
        self._way_round.restart()
        self.counters.consecutive_failures = 0

    def forget_chair(self) -> None:
        """Forget all that was learned of the chair's response, as for another chair, and reset."""
        self.history.clear()
        self.history.forget_response()
        self._actuation = Actuation(self._chair, self.history, adapt=self.parameters.prediction.adapt)
        self.reset()

    def reset_commands(self) -> None:
        """Forget the commands but keep the plan: the next plan begins with the measured speeds."""
        self.history.clear()

    def plan_like(self, other: DockingController) -> None:
        """Plan with the parameters of `other`, a controller of the same chair at the same dock whose weights alone
        differ. What was learned of the chair stays. Between two goals, as the plan is forgotten."""
        self.parameters, self._replanner = other.parameters, other._replanner
        self.reset()

    @property
    def period(self) -> float:
        """Measured time between two cycles [s], at least `control_period`."""
        return self.pace.period

    @property
    def obstacles(self) -> list[Array]:
        """What `set_obstacles` was given last, as convex anticlockwise outlines (n, 2) in the dock's frame [m]."""
        return self._clearance.outlines

    def set_obstacles(self, polygons: Sequence[ArrayLike]) -> None:
        """Obstacles to keep clear of from now on (none: an empty list): corners (n, 2) of each in the dock's frame [m].

        The convex hull of the corners counts. They hold until the next call. Without walls in the problem
        (`walls: false`) there are no areas at all, and obstacles are refused.

        Raises:
            ValueError: a polygon is not finite or has no area, or the problem has no areas; those before still hold.
        """
        self._clearance.set(polygons)

    def warm_up(self) -> None:
        """Solve once cold and once warm, so that no cycle pays for loading the solver."""
        for _ in range(2):
            self.command([self._dock.predock_x, 0.0, 0.0], (0.0, 0.0), [0.0, 0.0, 0.0])
        self.forget_chair()
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
            target: `dock` (round the bay's corner where the chair gets stuck there), `predock`, or a pose (x, y,
                heading) in the dock's frame.
            stamp: time of the vehicle pose [s]; without it, one control period after the last call.
        """
        stamp = self._clock + self.parameters.control_period if stamp is None else stamp
        numbers = [*np.ravel(vehicle_pose), *velocity, *np.ravel(dock_pose), stamp]
        self.counters.cycles += 1
        if self._begins:
            self._begin()
        if not all(math.isfinite(value) for value in numbers):
            self.counters.refused_inputs += 1
            return self._fall_back(self._clock, None, "input not finite")
        self._clock = stamp
        self.pace.cycle(stamp)
        self._actuation.measured(stamp, *self._driven.speeds(stamp, np.asarray(vehicle_pose, dtype=float), velocity))
        pose = relative(dock_pose, vehicle_pose)
        T_dock_target = self._way_round.towards(target, stamp, pose, self._clearance.outlines)
        if self._way_round.begins:
            self._replanner.reset()
        T_common_target = compose(dock_pose, T_dock_target)
        state = self._state(stamp, vehicle_pose, velocity, dock_pose, T_common_target)
        if not (np.all(np.isfinite(state)) and np.max(np.abs(state[:2])) <= _FARTHEST):
            self.counters.refused_inputs += 1
            return self._fall_back(stamp, None, f"target is farther than {_FARTHEST:.0f} m")
        acceleration = self._commands.acceleration(self.period)
        solution = self._replanner.solve(
            state, stamp, T_dock_target, self._clearance.outlines, acceleration, self.pace.limits(self.history.drive)
        )
        slow = self._areas is not None and in_bay(self._chair, self._dock.bay, self._acts_at)
        if not self._replanner.usable(solution):
            return self._fall_back(stamp, solution, solution.text, slow)
        return self._follow(solution, stamp, T_common_target, (float(state[3]), float(state[4])), slow)

    def _state(
        self,
        stamp: float,
        vehicle_pose: ArrayLike,
        velocity: tuple[float, float],
        dock_pose: ArrayLike,
        T_common_target: Array,
    ) -> Array:
        """Where the plan begins: x, y, heading in the target's frame, v, omega. Notes where the command will act."""
        pose, v, omega = self._commands.roll(stamp, vehicle_pose, *velocity)
        before = self._speeds_before(v, omega)
        self._acts_at, self._speed_there = relative(dock_pose, pose), v
        ahead = coasting_pose(pose, v, omega, self.history.drive.lag_v, self.history.drive.lag_omega)
        late = 0.5 * (self.period - self.parameters.control_period)  # of the middle of a longer period
        ahead = coasting_pose(ahead, *before, -self._replanner.lead - late)
        return np.concatenate([relative(T_common_target, ahead), before])

    def measured(self, stamp: float, v: float, omega: float, *, rolling: bool = True) -> None:
        """Mean speeds [m/s, rad/s] since the last call, measured at `stamp` [s]: to learn the chair's response from.

        Without such calls those given to `command` count. `rolling`: false where wheels slip: the chair turns by
        itself, which says nothing of its motors.
        """
        self._actuation.measured(stamp, v, omega, rolling=rolling)

    def move(self, stamp: float, velocity: tuple[float, float], v: float, omega: float) -> Command:
        """A command for these speeds without a plan, within the chair's limits: for a small move by hand, as it were.

        `velocity`: measured at `stamp`, as for `command`.
        """
        self.pace.cycle(stamp)
        if self._begins:
            self._begin()
        v, omega = self._actuation.send(stamp, (v, omega), velocity, self.period, True, planned=False)
        return Command(v=v, omega=omega)

    def rest_pose(self, stamp: float, vehicle_pose: ArrayLike, velocity: tuple[float, float]) -> Array:
        """Where the chair comes to rest when zero is commanded now: (x, y, heading), in the frame of `vehicle_pose`.

        Arguments: as of `command`.
        """
        pose, v, omega = self._commands.roll(stamp, vehicle_pose, *velocity)
        return coasting_pose(pose, v, omega, self.history.drive.lag_v, self.history.drive.lag_omega)

    def _begin(self) -> None:
        self._commands.restart()
        self._actuation.restart()
        self._begins = False

    def _speeds_before(self, v: float, omega: float) -> tuple[float, float]:
        """Speeds to begin with: the last command, unless the chair, measured at (v, omega), does not follow it."""
        prediction = self.parameters.prediction
        window = prediction.motor_lag + prediction.command_delay + 2.0 * self.period
        return within_reach(self._chair, self._commands.last_wanted, (v, omega), window)

    def _follow(
        self, solution: Solution, stamp: float, target: Array, before: tuple[float, float], slow: bool
    ) -> Command:
        plan = self._replanner.plan
        assert plan is not None  # a usable solution leaves one
        v, omega = plan.speeds_at(0.0 if plan.speeds_held else self.period)
        v = self._to_and_fro.speed(stamp, plan, v, before[0])
        wanted = clamp(self._chair, v, omega, before, self.period, slow)
        self.counters.consecutive_failures = 0
        if too_near := self._too_near(*wanted):
            self.counters.obstacle_stops += 1
            return self._brake(stamp, solution, too_near, slow)
        v, omega = self._actuation.send(stamp, wanted, before, self.period, slow)
        status = Status.SOLVED
        if solution.status is SolveStatus.LIMIT:
            self.counters.time_limits += 1
            status = Status.TIME_LIMIT
        return Command(
            v=v,
            omega=omega,
            status=status,
            solver=self._replanner.name,
            text=solution.text,
            solve_time=solution.solve_time,
            solve_cpu=self._replanner.solve_cpu,
            iterations=solution.iterations,
            cost=solution.cost,
            constraint_violation=max(plan.violation, solution.violation),
            path=composed(target, plan.states[:, :3]),
        )

    def _fall_back(self, stamp: float, solution: Solution | None, text: str, slow: bool = False) -> Command:
        """The last plan followed further, else braking."""
        self.counters.consecutive_failures += 1
        plan, age, period = self._replanner.plan, stamp - self._replanner.stamp, self.period
        if solution is not None and plan is not None and age <= self.parameters.fallback.max_plan_age + 1e-9:
            v, omega = plan.speeds_at(age + period)
            v, omega = clamp(self._chair, v, omega, self._commands.last_wanted or (0.0, 0.0), period, slow)
            if not self._too_near(v, omega):
                self.counters.shifted += 1
                v, omega = self._actuation.send(stamp, (v, omega), (0.0, 0.0), period, slow)
                return self._fallback_command(v, omega, Status.FALLBACK_SHIFTED, solution, text)
        self.counters.braked += 1
        return self._brake(stamp, solution, text, slow)

    def _brake(self, stamp: float, solution: Solution | None, text: str, slow: bool) -> Command:
        """Slower along the last plan's path, or with the curvature kept, which ends in standing."""
        before, period = self._commands.last or (0.0, 0.0), self.period
        path = self._replanner.path
        curvature = None if path is None else curvature_at(path, self._acts_at)
        v, omega = braked(before, self._chair.limits.a_max * period, curvature)
        v, omega = clamp(self._chair, v, omega, before, period, slow)
        self.history.sent(stamp, v, omega)
        return self._fallback_command(v, omega, Status.FALLBACK_BRAKE, solution, text)

    def _fallback_command(
        self, v: float, omega: float, status: Status, solution: Solution | None, text: str
    ) -> Command:
        """A command that does not come from a new plan."""
        command = Command(v=v, omega=omega, status=status, solver=self._replanner.name, text=text)
        return command.after(solution, self._replanner.solve_cpu)

    def _too_near(self, v: float, omega: float) -> str:
        path, drive = self._replanner.path, self.history.drive
        return self._clearance.too_near(self._acts_at, self._speed_there, v, omega, path, self.period, drive)
