"""One docking: what simulator, obstacle node, docking node and safety gate do together, without ROS and images."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import inverse, transform_points
from seater_eval.judge.plant.camera import DockCamera
from seater_eval.judge.plant.effects import Pictures
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.sequence.docking_sequence import DockingSequence
from seater_nmpc.sequence.goal.results import Result, ResultCode
from seater_obstacles.depth import DepthImages, cloud_sight
from seater_obstacles.evaluation.cases import draw_scene
from seater_obstacles.evaluation.gate_log import GateLog
from seater_obstacles.evaluation.parts import Parts, load_parts
from seater_obstacles.finder import ObstacleFinder
from seater_obstacles.scan import scan_sight
from seater_obstacles.sight import Sight
from seater_sim.chair.interface import OdometrySample
from seater_sim.loop.simulator import Simulator, Truth
from seater_sim.ranging.taken import SimulatedRange
from seater_sim.settings import NANOSECONDS, SCAN

Array = NDArray[np.float64]

_LONGEST = 150.0  # [s]
_AFTER = 1.0  # [s] that a run goes on after its last goal
_GOALS = 3  # so often a person asks, when something was in the way
_PAUSE = 3.0  # [s] until the next goal
_GATE_PERIOD = 2  # steps of 10 ms
_PERHAPS_FREE_AGAIN = (ResultCode.BLOCKED, ResultCode.FAILED_TO_STAGE, ResultCode.TIMEOUT, ResultCode.MARKER_LOST)


@dataclass(frozen=True)
class Job:
    """All that a run depends on. `watched`: with the sensor, else blind."""

    config: str
    case: str
    sensor: str
    seed: int
    watched: bool = True


def run_job(job: Job) -> dict[str, Any]:
    """How it went. The same job gives the same bits."""
    run = _Run(job)
    run.drive()
    return run.values()


class _Run:
    def __init__(self, job: Job) -> None:
        self._job, self._parts = job, load_parts(job.config)
        parts = self._parts
        scene = draw_scene(job.case, job.sensor, parts.simulator, parts.chair, np.random.default_rng([job.seed, 1]))
        self._simulator = Simulator(scene.settings, parts.chair, parts.dock, parts.camera, scene.start, seed=job.seed)
        self._camera = DockCamera(parts.chair, parts.dock, Pictures(), np.random.default_rng([job.seed, 2]))
        self._marker_noise = np.random.default_rng([job.seed, 3])
        self._finder = ObstacleFinder(parts.obstacles, parts.chair, parts.dock)
        self._depth = DepthImages(1)
        self._gate = GateLog(parts.gate())
        self._observer, self._sequence = _docking(parts)
        self._poses: dict[int, Array] = {}  # odometry by its stamp [ns]
        self._images: list[tuple[float, Any, Any]] = []
        self._outlines: list[Array] = []  # in odom
        self._cycle, self._next_image = -1, 0.0
        self.results: list[Result] = []
        self._ended = math.nan
        self._touches: list[dict[str, float]] = []

    def drive(self) -> None:
        """Until the last goal has ended."""
        simulator, begin, steps = self._simulator, self._simulator.time_ns, 0
        self._take(simulator.first_odometry())
        while (elapsed := (simulator.time_ns - begin) / NANOSECONDS) < _LONGEST:
            before = simulator.truth
            due = simulator.step()
            steps += 1
            now = due.time_ns / NANOSECONDS
            if due.truth.collisions > len(self._touches):
                self._touches.append(self._touch(elapsed, due.truth, before))
            self._look(now, due.truth.pose)
            if due.odometry is not None:
                self._take(due.odometry)
                self._control(now, elapsed, due.truth.contact)
            for taken in due.ranges if self._job.watched else []:
                self._see(now, taken)
            if steps % _GATE_PERIOD == 0:
                self._simulator.command(*self._gate.output(now))
            if self._over(elapsed):
                return

    def _over(self, elapsed: float) -> bool:
        if self._sequence.active or not self.results:
            return False
        again = self.results[-1].code in _PERHAPS_FREE_AGAIN and len(self.results) < _GOALS
        return not again and elapsed - self._ended > _AFTER

    def _take(self, sample: OdometrySample) -> None:
        self._poses[sample.time_ns] = sample.pose
        stamp = sample.time_ns / NANOSECONDS
        self._sequence.add_odometry(Odometry(stamp, sample.pose, sample.v, sample.omega))

    def _look(self, now: float, pose: Array) -> None:
        """Poses of the dock in an image, and their arrival."""
        if now >= self._next_image:
            self._next_image = max(now, self._next_image) + 1.0 / Pictures().rate
            place = (float(pose[0]), float(pose[1]), float(pose[2]))
            sights = self._camera.sights(place, self._marker_noise)
            self._images.append((now, self._camera.look(place), sights))
        while self._images and self._images[0][0] + Pictures().latency <= now:
            self._sequence.add_detections(*self._images.pop(0))

    def _control(self, now: float, elapsed: float, contact: bool) -> None:
        cycle = math.floor(now / self._parts.parameters.control.control_period + 1e-6)
        if cycle <= self._cycle:
            return
        self._cycle = cycle
        waits = bool(self.results) and elapsed - self._ended < _PAUSE
        done = bool(self.results) and (self.results[-1].code not in _PERHAPS_FREE_AGAIN or len(self.results) == _GOALS)
        if not self._sequence.active:
            self._gate.request(now, 0.0, 0.0)
            if waits or done or not self._gate.arm(now):
                return
            self._sequence.start_dock(now)
        self._parts.controller.set_obstacles(self._in_dock())
        self._sequence.held = self._gate.holds
        step = self._sequence.update(now, contact)
        self._gate.request(now, step.command.v, step.command.omega)
        if step.result is not None:
            self.results.append(step.result)
            self._ended = elapsed

    def _in_dock(self) -> list[Array]:
        estimate = self._observer.estimate()
        if estimate is None:
            return []
        T_dock_odom = inverse(estimate.pose)
        return [transform_points(T_dock_odom, outline) for outline in self._outlines]

    def _see(self, now: float, taken: SimulatedRange) -> None:
        """As the obstacle node."""
        estimate, stamp = self._observer.estimate(), taken.stamp_ns / NANOSECONDS
        dock = None if estimate is None else estimate.pose
        found = self._finder.update(stamp, self._sight(taken), self._poses[taken.stamp_ns], dock)
        self._outlines = found.outlines
        self._gate.obstacles(now, stamp, found.points)

    def _sight(self, taken: SimulatedRange) -> Sight:
        values, sensor, sense = taken.measure(), taken.sensor, self._parts.obstacles.sense
        if sensor.kind == SCAN:
            scan = sensor.settings.scan
            limits, T = (scan.min_range, scan.max_range), sensor.T_base_sensor
            return scan_sight(values, float(sensor.angles[0]), scan.step, limits, T, sense.max_range)
        return cloud_sight(self._depth.cloud(values.astype(np.float32), sensor.K), sensor.T_base_sensor, sense)

    def _touch(self, elapsed: float, truth: Truth, before: Truth) -> dict[str, float]:
        """When the chair touches something: its speeds just before, and where in base_link somebody walks then."""
        values = {"at_s": elapsed, "v": before.v, "omega": before.omega}
        for x, y in transform_points(inverse(truth.pose), self._simulator.walkers):
            values |= {"walker_x": float(x), "walker_y": float(y)}
        return values

    def values(self) -> dict[str, Any]:
        """For JSON."""
        truth = self._simulator.truth
        x, y, heading = self._parts.dock.docking_error(truth.pose)
        tolerance = self._parts.dock.tolerance
        docked = math.hypot(x, y) <= tolerance.position and abs(heading) <= tolerance.heading
        return {
            "case": self._job.case,
            "seed": self._job.seed,
            "touches": self._touches,
            "smallest_gap_m": truth.min_clearance,
            "docked": bool(docked and self.results and self.results[-1].success),
            "goals": len(self.results),
            "codes": [result.code.name for result in self.results],
            "texts": [result.text for result in self.results],
            "time_s": self._ended,
            **self._gate.values(),
        }


def _docking(parts: Parts) -> tuple[DockObserver, DockingSequence]:
    controller = parts.controller
    controller.forget_chair()
    controller.pace.limit()
    controller.set_obstacles([])
    observer = DockObserver(parts.chair.camera, parts.parameters.observer)
    sequence = DockingSequence(
        parts.chair,
        parts.dock,
        controller,
        observer,
        parts.parameters.sequence,
        require_contact=True,
        navigator=parts.navigator,
        plausibility=parts.parameters.plausibility,
    )
    return observer, sequence
