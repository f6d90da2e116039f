"""What all phases share: the services that they use, how far the goal has come, and how long the chair has stood."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_common.se2 import relative
from seater_nmpc.control.command import Command
from seater_nmpc.control.controller import DockingController
from seater_nmpc.control.target import Target
from seater_nmpc.observe.motion import MotionObserver
from seater_nmpc.observe.observer import DockEstimate, DockObserver
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.plan.navigator import Navigator
from seater_nmpc.plausibility.watch import Watch
from seater_nmpc.sequence.goal.progress import Progress
from seater_nmpc.sequence.goal.results import GoalEnd, Phase, ResultCode
from seater_nmpc.sequence.rest.standstill import Standstill

Array = NDArray[np.float64]
Asked = Command | Phase  # by a phase in one cycle: a command, or that another phase takes over at once

STANDING = Command(v=0.0, omega=0.0)
IMAGES_THAT_MAY_FAIL = 4  # in a row, the time until the next one arrives reckoned in
ARRIVED_SPEED = 0.1  # [m/s] below which the chair near the predock point has arrived there
_SURE = 0.5  # of the speed up to which the chair stands: as sure the odometry is to be of it


@dataclass(kw_only=True)
class Context:
    """Speeds are (v, omega) [m/s, rad/s]; errors (3,): a pose of the chair in the dock's frame [m, m, rad]."""

    chair: Chair
    dock: Dock
    controller: DockingController
    observer: DockObserver
    motion: MotionObserver
    navigator: Navigator
    parameters: SequenceParameters
    watch: Watch
    require_contact: bool
    goal: Progress = field(init=False)
    standstill: Standstill = field(init=False)

    def __post_init__(self) -> None:
        self.goal = Progress(self.parameters.timeouts)
        self.stand_patiently()

    def stand_patiently(self) -> None:
        """Count standing anew."""
        self.standstill = Standstill(self.parameters, self.goal.now)

    def look(self, chair: Instant) -> Array:
        """The error (3,), after making sure that the dock is known well enough to move. Raises GoalEnd."""
        estimate = self.estimate(chair)
        self.goal.T_odom_dock = estimate.pose
        self.goal.error = relative(estimate.pose, chair.pose)
        return self.goal.error

    def estimate(self, chair: Instant) -> DockEstimate:
        """The dock as of now. Raises GoalEnd where it is not known."""
        estimate = self.observer.estimate(chair.stamp)
        if estimate is None:
            raise GoalEnd(ResultCode.MARKER_LOST, "the dock is not known")
        return estimate

    def blind(self, estimate: DockEstimate) -> bool:
        """Whether the dock was seen too long ago, in time or way driven, to move towards it, or is seen elsewhere."""
        p = self.parameters
        if self.observer.images.contradict:
            return True
        return estimate.blind_distance > p.max_blind_distance or estimate.age > p.max_blind_time

    def in_view(self, chair: Instant) -> bool:
        """Whether the dock is known and has been seen not too long ago."""
        estimate = self.observer.estimate(chair.stamp)
        return estimate is not None and not self.blind(estimate)

    def speeds(self, chair: Instant) -> tuple[float, float]:
        """Of the chair, less the errors of its odometry."""
        return self.observer.true_speeds(*self.motion.at(chair.stamp))

    def measured(self, chair: Instant) -> tuple[float, float]:
        """Speeds as the odometry's poses have them over `standing_time`, less its errors."""
        p = self.parameters
        speeds = self.observer.odometry.mean_speeds(p.standing_time, _SURE * p.standing_speed)
        speeds = speeds or (chair.v, chair.omega)
        return self.observer.true_speeds(*speeds)

    def rest_error(self, chair: Instant) -> Array:
        """Where the chair would come to rest if it were asked to stand now (3,)."""
        assert self.goal.T_odom_dock is not None  # every caller has looked
        return self.rest_from(self.goal.T_odom_dock, chair, self.speeds(chair))

    def rest_from(self, T_odom_dock: Array, chair: Instant, speeds: tuple[float, float]) -> Array:
        """The same seen from any pose of the dock in odom (3,)."""
        return relative(T_odom_dock, self.controller.rest_pose(chair.stamp, chair.pose, speeds))

    def is_at(self, x: float, error: Array, chair: Instant) -> bool:
        """Whether the chair is, slowly, at that place on the dock's axis."""
        p = self.parameters
        near = math.hypot(error[0] - x, error[1]) <= p.predock_position
        return near and abs(error[2]) <= p.predock_heading and abs(chair.v) <= ARRIVED_SPEED

    def drive(self, chair: Instant, target: Target) -> Command:
        """The controller's command towards the target (dock's frame). Raises GoalEnd when it failed too often."""
        assert self.goal.T_odom_dock is not None  # every caller has looked
        motion = self.speeds(chair)
        command = self.controller.command(chair.pose, motion, self.goal.T_odom_dock, target, chair.stamp)
        failures = self.controller.counters.consecutive_failures
        if failures >= self.controller.parameters.fallback.max_consecutive:
            raise GoalEnd(ResultCode.FAILED_TO_CONTROL, f"{failures} cycles without a solution: {command.text}")
        return command

    def try_again(self, code: ResultCode, why: str) -> Phase:
        """The chair backs out for another attempt; where none is left, the goal is given up with this code, and at once
        where the installation is surely wrong: another attempt would end beside the dock as well."""
        doubt = None if self.goal.staging else self.watch.installation.final()
        if doubt is not None:
            return self.give_up(ResultCode[doubt.kind.name], f"{why}: {doubt.text}")
        if self.goal.retries >= self.parameters.max_retries:
            return self.give_up(code, f"{why}, after {self.goal.retries} retries")
        self.goal.retries += 1
        return Phase.RETRY

    def give_up(self, code: ResultCode, why: str) -> Phase:
        """The goal ends with this code, by GoalEnd; where `failed_end` says so, the chair backs out before."""
        failure = GoalEnd(code, why)
        if self.parameters.failed_end == "stay":
            raise failure
        self.goal.failure = failure
        return Phase.RETRY
