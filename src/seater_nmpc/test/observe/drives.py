"""A chair whose odometry errs, around an observer: encoders on a slipping floor, a gyro with a bias, slow messages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from conftest import NOISE, T_ODOM_DOCK, observation

from seater_common.geometry import Chair
from seater_common.se2 import arc_step, compose, inverse, relative
from seater_nmpc.observe.innovation import Fusion
from seater_nmpc.observe.measurement import difference
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import ObserverParameters

CHAIR = Chair()
STEP = 0.01  # [s]


@dataclass
class Drive:
    """Odometry and images of a drive that begins standing at `truth` (in the dock's frame)."""

    truth: np.ndarray = field(default_factory=lambda: np.array([-2.6, 0.2, -0.1]))
    slip: Callable[[np.ndarray], float] = lambda pose: 0.0  # fraction of the wheels' way that is lost there
    pull: Callable[[np.ndarray], float] = lambda pose: 0.0  # [rad/m] that the chair turns there, unseen by its wheels
    aside: float = 0.0  # [m] to the left in each metre, unseen by its wheels
    gyro_bias: float = 0.0  # [rad/s]
    odometry_period: float = 0.02  # [s]
    image_period: float = 0.1
    parameters: ObserverParameters = field(default_factory=ObserverParameters)
    seed: int = 0

    def __post_init__(self) -> None:
        self.observer = DockObserver(CHAIR.camera, self.parameters)
        self.noise = np.random.default_rng(self.seed)
        self.odom = compose(T_ODOM_DOCK, self.truth)
        self.ticks = 0
        self.fusions: list[Fusion] = []
        self.errors: list[np.ndarray] = []  # of the dock in base_link after each image, once there is an estimate
        self.nees: list[float] = []

    @property
    def now(self) -> float:
        return round(self.ticks * STEP, 6)

    def go(self, v: float, omega: float, seconds: float) -> None:
        """Drive so; `v` and `omega` are what the wheels turn by."""
        for _ in range(round(seconds / STEP)):
            driven = v * (1.0 - self.slip(self.truth))
            self.truth = arc_step(self.truth, driven, omega + driven * self.pull(self.truth), STEP)
            self.truth = compose(self.truth, [0.0, self.aside * abs(driven) * STEP, 0.0])
            self.odom = arc_step(self.odom, v, omega + self.gyro_bias, STEP)
            self.ticks += 1
            if self.ticks % round(self.odometry_period / STEP) == 0:
                self.observer.add_odometry(Odometry(self.now, self.odom, v, omega + self.gyro_bias))
            if self.ticks % round(self.image_period / STEP) == 0:
                self.look()

    def look(self, wrong: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Fusion:
        """An image, with noise and `wrong` by so much."""
        error = self.noise.normal(size=3) * [NOISE[0], NOISE[0], NOISE[1]] + wrong
        self.fusions.append(self.observer.add_detections(self.now, [observation(CHAIR, inverse(self.truth) + error)]))
        estimate = self.observer.estimate()
        if estimate is not None:
            self.errors.append(relative(self.odom, estimate.pose) - inverse(self.truth))
            residual = difference(estimate.pose, compose(self.odom, inverse(self.truth)))
            self.nees.append(float(residual @ np.linalg.solve(estimate.covariance, residual)))
        return self.fusions[-1]

    @property
    def outcomes(self) -> list[str]:
        return [fusion.outcome.name for fusion in self.fusions]
