"""One docking of the campaign: seater_sim's plant and odometry, seater_nmpc's observer and sequence, noisy poses. No
ROS."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from seater_common.geometry import Chair, Dock
from seater_common.se2 import wrap_angle
from seater_eval.baselines.trajectories import Trajectory
from seater_eval.control.pose_noise import DockSensor, NoiseModel
from seater_eval.run.setup_files import Setup
from seater_nmpc.control.controller import DockingController
from seater_nmpc.control.limits import in_bay
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.plan.navigator import Navigator
from seater_nmpc.sequence.docking_sequence import DockingSequence
from seater_nmpc.sequence.goal.results import Result
from seater_sim.loop.simulator import Due, Simulator
from seater_sim.settings import KINEMATIC, NANOSECONDS, Obstacle

# A limit counts as violated from here on. Far above rounding, far below what anyone notices.
SLACK_SPEED = 1e-3  # [m/s, rad/s]
# A wheelchair's wheels do not turn as commanded: gains in config/plants go up to this much beyond.
GAIN_ERROR = 0.05  # of the limit
SLACK_RATE = 1e-3  # [m/s^2, rad/s^2] times one period
FAR = 0.6  # [m] farther from the dock than this, the markers have to stay in view


@dataclass(frozen=True)
class Case:
    """A start, and everything else that makes the run what it is."""

    index: int
    start: tuple[float, float, float]  # base_link in the dock's frame
    seed: int
    obstacles: tuple[tuple[float, ...], ...] = ()  # x1, y1, x2, y2, ... each, convex, anticlockwise


@dataclass
class Watch:
    """What is measured while the run goes on; speeds and poses are the true ones."""

    out_of_view: float = 0.0  # [s] with no marker in the image while farther than FAR
    excess_speed: float = 0.0  # largest speed beyond its limit [m/s, rad/s]
    excess_bay_speed: float = 0.0  # [m/s] the same for the bay's
    excess_request: float = 0.0  # largest request beyond speed and acceleration limits [m/s, rad/s]
    not_finite: int = 0  # requests


class DockingRun:
    """Closes the loop as the docking node does: odometry and images in message time, a cycle every control period."""

    def __init__(
        self,
        setup: Setup,
        case: Case,
        controller: DockingController,
        noise: NoiseModel | None = None,
        navigator: Navigator | None = None,
    ) -> None:
        """`navigator`: one that is used again, so that its search ahead of the bay is made once."""
        self.chair, self.dock = setup.chair, setup.dock
        obstacles = [*setup.simulator.obstacles, *(Obstacle(list(outline)) for outline in case.obstacles)]
        settings = replace(setup.simulator, obstacles=obstacles)
        self.simulator = Simulator(settings, setup.chair, setup.dock, None, case.start, seed=case.seed)
        self._ideal = settings.plant.kind == KINEMATIC
        self._controller = controller
        controller.forget_chair()
        controller.set_obstacles([np.array(outline).reshape(-1, 2) for outline in case.obstacles])
        observer = DockObserver(setup.chair.camera, setup.parameters.observer)
        self.sequence = DockingSequence(
            setup.chair, setup.dock, controller, observer, setup.parameters.sequence, navigator=navigator
        )
        self._sensor = DockSensor(setup.chair, setup.dock, setup.camera, noise)
        self._rng = np.random.default_rng([case.seed, 7])
        self._period, self._cycle = setup.parameters.control.control_period, -1
        self._step = settings.step
        self._asked = (0.0, 0.0)
        self.watch = Watch()
        self.started_in_view = bool(self._sensor.in_view(case.start))
        self.solve_times: list[float] = []
        self.failures = 0
        self.result: Result | None = None
        self._rows: list[list[float]] = []

    def slack_speed(self, limit: float) -> float:
        """By how much the true speed may exceed its limit, all in [m/s] or [rad/s]."""
        return SLACK_SPEED if self._ideal else GAIN_ERROR * limit

    def run(self, longest: float = 180.0, rest: float = 1.0) -> Trajectory:
        """Until the sequence ends or `longest` [s], and then `rest` [s] more: whatever moves after the end counts."""
        begin = self.simulator.time_ns
        self._record(begin)
        end: float | None = None
        while True:
            due = self.simulator.step()
            self._feed(due)
            self._observe(due)
            self._record(begin)
            elapsed = (due.time_ns - begin) / NANOSECONDS
            if self.result is not None and end is None:
                end = elapsed + rest
            if elapsed >= (longest if end is None else end):
                break
        rows = np.array(self._rows)
        return Trajectory(
            rows[:, 0], rows[:, 1:4], rows[:, 4:6], solve_times=np.array(self.solve_times), failures=self.failures
        )

    def _feed(self, due: Due) -> None:
        for image in due.images:
            hypotheses = self._sensor.measure(image.pose, self._rng)
            self.sequence.add_detections(image.stamp_ns / NANOSECONDS, hypotheses)
        sample = due.odometry
        if sample is None:
            return
        now = sample.time_ns / NANOSECONDS
        self.sequence.add_odometry(Odometry(now, sample.pose, sample.v, sample.omega))
        cycle = math.floor(now / self._period + 1e-6)
        if cycle > self._cycle:
            self._cycle = cycle
            self._control(now, due.truth.contact)

    def _control(self, now: float, contact: bool) -> None:
        if self.result is not None:
            self._request(0.0, 0.0)
            return
        if not self.sequence.active:
            self.sequence.start_dock(now)
        step = self.sequence.update(now, contact)
        self.result = step.result
        if step.command.solver:
            self.solve_times.append(step.command.solve_time)
            self.failures += self._controller.counters.consecutive_failures > 0
        self._request(step.command.v, step.command.omega)

    def _request(self, v: float, omega: float) -> None:
        """Check the request and hand it on. Asking to stand is always allowed: the motors brake within their limits."""
        watch, limits = self.watch, self.chair.limits
        if not (math.isfinite(v) and math.isfinite(omega)):
            watch.not_finite += 1
            return
        excess = max(v - limits.v_max, -v - limits.v_reverse_max, abs(omega) - limits.omega_max)
        if (v, omega) != (0.0, 0.0):
            change = abs(v - self._asked[0]) - limits.a_max * self._period
            turn = abs(omega - self._asked[1]) - limits.alpha_max * self._period
            excess = max(excess, change, turn)
        watch.excess_request = max(watch.excess_request, excess)
        self._asked = (v, omega)
        self.simulator.command(v, omega)

    def _observe(self, due: Due) -> None:
        truth, watch, limits = due.truth, self.watch, self.chair.limits
        forward = truth.v - limits.v_max
        excess = max(forward, -truth.v - limits.v_reverse_max, abs(truth.omega) - limits.omega_max)
        watch.excess_speed = max(watch.excess_speed, excess)
        if in_bay(self.chair, self.dock.bay, truth.pose):
            watch.excess_bay_speed = max(watch.excess_bay_speed, abs(truth.v) - limits.v_bay_max)
        if math.hypot(truth.pose[0], truth.pose[1]) > FAR and not self._sensor.in_view(truth.pose):
            watch.out_of_view += self._step

    def _record(self, begin: int) -> None:
        truth = self.simulator.truth
        elapsed = (truth.time_ns - begin) / NANOSECONDS
        self._rows.append([elapsed, *truth.pose, truth.v, truth.omega])


def run_values(run: DockingRun, trajectory: Trajectory, case: Case) -> dict:
    """What the campaign keeps of a run."""
    truth, watch, result = run.simulator.truth, run.watch, run.result
    final = trajectory.poses[-1]
    tolerance = run.dock.tolerance
    within = math.hypot(final[0], final[1]) <= tolerance.position and abs(wrap_angle(final[2])) <= tolerance.heading
    violated = (
        watch.not_finite > 0
        or watch.excess_speed > run.slack_speed(run.chair.limits.v_max)
        or watch.excess_bay_speed > run.slack_speed(run.chair.limits.v_bay_max)
        or watch.excess_request > SLACK_RATE * run._period
    )
    return {
        "index": case.index,
        "seed": case.seed,
        "start": list(case.start),
        "docked": bool(result is not None and result.success and within and not np.any(trajectory.speeds[-1])),
        "result": "TIMEOUT" if result is None else result.code.name,
        "text": "" if result is None else result.text,
        "retries": 0 if result is None else result.retries,
        "duration_s": None if result is None else result.duration,
        "docking_time_s": trajectory.docking_time(tolerance),
        "position_error_m": trajectory.final_position_error,
        "lateral_error_m": float(final[1]),
        "longitudinal_error_m": float(final[0]),
        "heading_error_deg": math.degrees(trajectory.final_heading_error),
        "collisions": truth.collisions,
        "min_clearance_m": truth.min_clearance,
        "limits_violated": violated,
        "excess_speed": watch.excess_speed,
        "excess_bay_speed": watch.excess_bay_speed,
        "excess_request": watch.excess_request,
        "started_in_view": run.started_in_view,
        "out_of_view_s": watch.out_of_view,
        "solver_failures": trajectory.failures,
        "solve_ms": 1e3 * float(np.median(trajectory.solve_times)) if len(trajectory.solve_times) else None,
        "solve_max_ms": 1e3 * float(np.max(trajectory.solve_times)) if len(trajectory.solve_times) else None,
    }


def draw_start(
    chair: Chair, dock: Dock, sensor: DockSensor, clearance: Callable[[np.ndarray], float], rng: np.random.Generator
) -> tuple[float, float, float]:
    """x -4..-1 m, y +-1.5 m, heading +-60 deg, so that a marker is found from there and nothing is nearer than 10
    cm."""
    for _ in range(10000):
        heading = math.radians(rng.uniform(-60.0, 60.0))
        pose = np.array([rng.uniform(-4.0, -1.0), rng.uniform(-1.5, 1.5), heading])
        if sensor.visible(pose) and clearance(pose) >= 0.1:
            return float(pose[0]), float(pose[1]), float(pose[2])
    raise RuntimeError("no start found from which a marker is seen")
