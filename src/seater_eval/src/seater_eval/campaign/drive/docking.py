"""One docking out of rendered images, in lock-step, without ROS: what sim_node, the marker detector, the docking node
and the safety gate do together, in the same order (docs/reference/lock_step.md)."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.se2 import compose, inverse, relative, wrap_angle
from seater_eval.campaign.drive import tools
from seater_eval.campaign.drive.chain import Gate, Perception
from seater_eval.campaign.drive.trace import Clock, Trace
from seater_eval.campaign.drive.without_images import PoseSensor
from seater_eval.campaign.setup.configuration import Configuration
from seater_nmpc.observe.measurement import Hypothesis, MarkerSight
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.sequence.docking_sequence import DockingSequence
from seater_nmpc.sequence.goal.results import Phase, Result
from seater_nmpc.sequence.vehicle import Vehicle
from seater_sim.chair.odometry import OdometrySample
from seater_sim.loop.simulator import SimulatedImage, Simulator
from seater_sim.settings import NANOSECONDS
from seater_sim.world.events import GOOD

Array = NDArray[np.float64]


class ImageDocking:
    """A goal `dock` from beginning to end. Same arguments: same run, to the bit."""

    def __init__(
        self,
        configuration: Configuration,
        parameters: NmpcParameters,
        start: ArrayLike,
        seed: int,
        *,
        require_contact: bool = True,
        rough_pose: ArrayLike | None = None,
        images: bool = True,
    ) -> None:
        """Args:
        parameters: what the controller, observer and sequence are told.
        start: base_link in the true dock frame, (x [m], y [m], heading [rad]).
        seed: of plant, odometry and image noise.
        rough_pose: of the dock in its own true frame; comes with the goal.
        images: False: nothing is rendered nor detected, poses are drawn (see without_images).

        Raises ValueError (ParameterError among them) where a node would refuse to start.
        """
        c = configuration
        self.clock = Clock()
        with self._timed("setup"):
            self._vehicle = Vehicle(c.chair, c.dock)
            chair = self._vehicle.chair
            controller = tools.controller(chair, c.dock, parameters, c.camera)
            controller.set_obstacles([obstacle.polygon() for obstacle in c.simulator.obstacles])
            self.observer = DockObserver(chair.camera, parameters.observer)
            navigator = tools.navigator(chair, c.dock, parameters, c.camera)
            self.sequence = DockingSequence(
                chair,
                c.dock,
                controller,
                self.observer,
                parameters.sequence,
                require_contact=require_contact,
                navigator=navigator,
                plausibility=parameters.plausibility,
            )
            self.gate = Gate(c.chair, c.safety)
            self._eyes = Perception(c) if images else PoseSensor(c, seed)
            camera = tools.camera(c) if images else None
            self.simulator = Simulator(
                c.simulator, c.simulated_chair, c.simulated_dock, c.simulated_camera, start, seed=seed, camera=camera
            )
        self._rough_pose, self._period, self._cycle = rough_pose, parameters.control.control_period, -1
        self.result: Result | None = None
        self.trace = Trace()

    def run(self, longest: float, rest: float) -> None:
        """Until the goal has its result (or `longest` [s]), and then `rest` [s] more. Raises what any part raises."""
        simulator = self.simulator
        self._begin_ns = simulator.time_ns
        self._record()
        self._take_odometry(simulator.first_odometry())  # the goal is given while time stands
        self.sequence.start_dock(self._begin_ns / NANOSECONDS, prior=self._prior())
        end = longest
        while self._elapsed() < end:
            active = self.result is None
            with self._timed("plant"):
                due = simulator.step()
            self._record()
            if due.odometry is not None:
                self._on_odometry(due.odometry, due.truth.contact)
            for image in due.images if self.result is None else []:  # what comes later changes nothing any more
                self._on_image(image)
            if active and self.result is not None:
                end = self._elapsed() + rest

    def _prior(self) -> Array | None:
        """The rough pose in odom."""
        newest = self.observer.odometry.newest
        if self._rough_pose is None or newest is None:
            return None
        return compose(compose(newest.pose, inverse(self._true_pose())), self._rough_pose)

    def _true_pose(self) -> Array:
        """Of what the core drives, in the true dock frame."""
        return self._vehicle.pose(self.simulator.truth.pose)

    def _elapsed(self) -> float:
        return (self.simulator.time_ns - self._begin_ns) / NANOSECONDS

    def _take_odometry(self, sample: OdometrySample) -> None:
        odometry = Odometry(sample.time_ns / NANOSECONDS, sample.pose, sample.v, sample.omega)
        self.sequence.add_odometry(self._vehicle.odometry(odometry))

    def _on_odometry(self, sample: OdometrySample, contact: bool) -> None:
        """As the docking node: a control cycle at the first message in each period of message time."""
        with self._timed("control"):
            self._take_odometry(sample)
            now = sample.time_ns / NANOSECONDS
            cycle = math.floor(now / self._period + 1e-6)
            if cycle > self._cycle:
                self._cycle = cycle
                self._control(now, contact)

    def _control(self, now: float, contact: bool) -> None:
        if self.result is not None:
            self._send(now, 0.0, 0.0, -1)
            return
        step = self.sequence.update(now, contact)
        command = self._vehicle.command(step.command)
        self.result = step.result
        self._send(now, command.v, command.omega, step.phase)

    def _send(self, now: float, v: float, omega: float, phase: Phase | int) -> None:
        passed = self.gate.pass_on(now, v, omega)
        self.simulator.command(*passed)
        estimate, newest = self.observer.estimate(), self.observer.odometry.newest
        error, age = np.full(3, math.nan), math.nan
        if estimate is not None and newest is not None:
            error = relative(estimate.pose, newest.pose) - self._true_pose()
            error[2], age = wrap_angle(float(error[2])), estimate.age
        self.trace.cycle_rows.append((self._elapsed(), float(phase), v, omega, *passed, *error.tolist(), age))

    def _on_image(self, image: SimulatedImage) -> None:
        """An image that is none (an event says so) reaches nobody: the nodelet is silent about it."""
        if image.mode != GOOD:
            return
        hypotheses, markers, count = self._look(image)
        with self._timed("control"):
            fusion = self.sequence.add_detections(image.stamp_ns / NANOSECONDS, hypotheses, markers)
        taken = (image.stamp_ns - self._begin_ns) / NANOSECONDS
        self.trace.image_rows.append((taken, float(count), float(fusion.outcome)))

    def _look(self, image: SimulatedImage) -> tuple[list[Hypothesis], list[MarkerSight], int]:
        """The dock's possible poses, the markers (none without images), and how many are seen."""
        if isinstance(self._eyes, PoseSensor):
            with self._timed("detect"):
                hypotheses, count = self._eyes.measure(image)
            return hypotheses, [], count
        with self._timed("render"):
            pixels = image.render()
        with self._timed("detect"):
            hypotheses, markers = self._eyes.detect(grey(pixels))
        return hypotheses, markers, len(markers)

    def _record(self) -> None:
        truth = self.simulator.truth
        self.trace.truth_rows.append((self._elapsed(), *truth.pose.tolist(), truth.v, truth.omega))

    @contextmanager
    def _timed(self, part: str) -> Iterator[None]:
        begin = time.process_time()
        yield
        self.clock.add(part, time.process_time() - begin)


def grey(pixels: NDArray) -> NDArray[np.uint8]:
    """As the nodelet takes images: grey as they are, colours by their luminance (BT.601)."""
    import cv2

    return pixels if pixels.ndim == 2 else np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY), dtype=np.uint8)
