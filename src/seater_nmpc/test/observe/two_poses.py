"""A chair that sees one marker, whose images leave two poses of the dock open."""

import math

import numpy as np
from conftest import observation

from seater_common.geometry import Chair
from seater_common.se2 import arc_step, compose, inverse, wrap_angle
from seater_nmpc.observe.innovation import Outcome
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.message import Odometry

CHAIR, SIDE = Chair(), np.array([0.9, 0.35, math.pi])  # a marker at the side of the dock, (x, y, direction)


def both(pose, rng, weight: float, stretched: float = 0.0):
    """The dock in base_link, and the one whose marker faces as much to the other side of the line of sight."""
    marker = compose(inverse(pose), SIDE)
    marker[:2] += stretched * (marker[:2] - [CHAIR.camera.x, CHAIR.camera.y])
    eye = np.array([CHAIR.camera.x, CHAIR.camera.y])
    sight = math.atan2(*(eye - marker[:2])[::-1])
    mirrored = np.array([*marker[:2], wrap_angle(2.0 * sight - marker[2])])
    noise = rng.normal(size=3) * [0.005, 0.005, 0.02]
    docks = (compose(place + noise, inverse(SIDE)) for place in (marker, mirrored))
    return [observation(CHAIR, dock, (0.01, 0.03), w) for dock, w in zip(docks, (weight, 1.0 - weight), strict=True)]


class Drive:
    """From where the marker is seen 15 deg aside; odometry and, as a rule, images at 20 Hz."""

    def __init__(self, seed: int = 1) -> None:
        self.rng, self.observer = np.random.default_rng(seed), DockObserver(CHAIR.camera)
        self.pose, self.odom, self.k = np.array([-2.0, -0.3, 0.0]), np.array([1.0, 2.0, 0.4]), 0
        self.truth = compose(self.odom, inverse(self.pose))
        self.outcomes: list[Outcome] = []
        self.each = 1  # odometry messages to an image
        self.stretched = 0.0  # share by which depths are too long

    def on(
        self, seconds: float, v: float, weight: float, *, omega: float = 0.0, slip: float = 0.0, drift: float = 0.0
    ) -> None:
        """`weight`: of the true pose; `drift` [rad/m] of the odometry's heading."""
        for _ in range(round(20 * seconds)):
            self.k += 1
            self.pose = arc_step(self.pose, v * (1.0 - slip), omega, 0.05)
            self.odom = arc_step(self.odom, v, omega + drift * v, 0.05)
            self.observer.add_odometry(Odometry(0.05 * self.k, self.odom, v, omega + drift * v))
            if self.k % self.each == 0:
                seen = both(self.pose, self.rng, weight, self.stretched)
                self.outcomes.append(self.observer.add_detections(0.05 * self.k, seen).outcome)

    def off(self) -> float:
        """[rad] of the estimated heading."""
        truth = compose(self.odom, inverse(self.pose))
        return abs(wrap_angle(float(self.observer.estimate().pose[2] - truth[2])))
