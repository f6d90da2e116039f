"""Who drives the chair: the docking sequence, wired as the docking node wires it, or the controller class alone."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import compose, inverse, wrap_angle
from seater_eval.judge.parts import Files, Kept
from seater_eval.judge.plant.chair import IndependentChair
from seater_nmpc.observe.measurement import Hypothesis, MarkerSight
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.plausibility.installation.knowledge import Knowledge
from seater_nmpc.sequence.docking_sequence import DockingSequence
from seater_nmpc.sequence.goal.results import Result

Array = NDArray[np.float64]
Asked = tuple[float, float] | None

CLASS_PERIOD = 0.05  # [s]
_STEPS = 1e-6  # of a period: rounding of a stamp


class Driver(Protocol):
    """Takes what the chair and its camera say, and answers with commands (None: no new one)."""

    result: Result | None  # how it ended, if it says so
    knowledge: Knowledge | None  # of the installation, by the dockings so far
    estimates: list[list[float]]  # time, error of the dock's estimate (x [m], y [m], heading [rad]), NEES, its age [s]

    def odometry(self, message: Odometry, chair: IndependentChair) -> Asked:
        """A message has arrived; `chair` is for a driver with perfect state, and for the estimate's true error."""

    def image(self, stamp: float, hypotheses: list[Hypothesis], markers: list[MarkerSight]) -> None:
        """The poses of the dock in an image taken at `stamp`, and its single markers, have arrived."""

    def time(self, now: float, chair: IndependentChair) -> Asked:
        """Another step of time."""


@dataclass
class SequenceDriver:
    """DockingSequence, DockObserver, DockingController and Navigator, a cycle at the first odometry of each period."""

    files: Files
    kept: Kept
    parameters: NmpcParameters
    prior: Array | None = None  # rough pose of the dock in odom
    result: Result | None = None
    estimates: list[list[float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        parameters, chair = self.parameters, self.files.chair
        controller = self.kept.controller(parameters.control)
        self.observer = DockObserver(chair.camera, parameters.observer)
        navigator = self.kept.navigator(parameters)
        self._sequence = DockingSequence(
            chair,
            self.files.dock,
            controller,
            self.observer,
            parameters.sequence,
            navigator=navigator,
            plausibility=parameters.plausibility,
        )
        self._cycle = -1

    @property
    def knowledge(self) -> Knowledge | None:
        """See Driver."""
        return self._sequence.knowledge

    @knowledge.setter
    def knowledge(self, known: Knowledge | None) -> None:
        if known is not None:
            self._sequence.knowledge = known

    def odometry(self, message: Odometry, chair: IndependentChair) -> Asked:
        """See Driver."""
        self._sequence.add_odometry(message)
        cycle = math.floor(message.stamp / self.parameters.control.control_period + _STEPS)
        if cycle <= self._cycle:
            return None
        self._cycle = cycle
        self._compare(message, chair)
        if self.result is not None:
            return 0.0, 0.0
        if not self._sequence.active:
            self._sequence.start_dock(message.stamp, prior=self.prior)
        step = self._sequence.update(message.stamp)
        self.result = step.result
        return step.command.v, step.command.omega

    def image(self, stamp: float, hypotheses: list[Hypothesis], markers: list[MarkerSight]) -> None:
        """See Driver."""
        self._sequence.add_detections(stamp, hypotheses, markers)

    def time(self, now: float, chair: IndependentChair) -> Asked:
        """See Driver."""
        return None

    def _compare(self, message: Odometry, chair: IndependentChair) -> None:
        """The estimate with where the dock truly is in odom, whose own drift is no error of the estimate."""
        estimate = self.observer.estimate(message.stamp)
        if estimate is None:
            return
        error = estimate.pose - compose(message.pose, inverse((chair.x, chair.y, chair.heading)))
        error[2] = wrap_angle(float(error[2]))
        nees = float(error @ np.linalg.solve(estimate.covariance, error))
        self.estimates.append([message.stamp, *error.tolist(), nees, estimate.age])


@dataclass
class ClassDriver:
    """DockingController.command with the true pose and speeds."""

    files: Files
    kept: Kept
    parameters: NmpcParameters
    result: Result | None = None
    knowledge: Knowledge | None = None
    estimates: list[list[float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._controller = self.kept.controller(self.parameters.control)
        self._begin: float | None = None
        self._cycles = 0

    def odometry(self, message: Odometry, chair: IndependentChair) -> Asked:
        """See Driver."""
        return None

    def image(self, stamp: float, hypotheses: list[Hypothesis], markers: list[MarkerSight]) -> None:
        """See Driver."""

    def time(self, now: float, chair: IndependentChair) -> Asked:
        """See Driver."""
        self._begin = now if self._begin is None else self._begin
        if now < self._begin + self._cycles * CLASS_PERIOD - 1e-9:
            return None
        self._cycles += 1
        pose = (chair.x, chair.y, chair.heading)
        command = self._controller.command(pose, (chair.v, chair.omega), (0.0, 0.0, 0.0), stamp=now)
        return command.v, command.omega
