"""Two places of the dock that the images of a chair that stands leave open, told apart once it moves."""

import math

import numpy as np
import pytest
from conftest import observation

from seater_common.geometry import Chair, Dock
from seater_common.se2 import arc_step, compose, inverse, wrap_angle
from seater_nmpc.observe.innovation import Outcome
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import PlausibilityParameters
from seater_nmpc.plausibility.jump import sudden

CHAIR, SIDE = Chair(), np.array([0.9, 0.35, math.pi])  # a marker at the side of the dock, (x, y, direction)


def both(pose, rng, weight: float):
    """The dock in base_link, and the one whose marker faces as much to the other side of the line of sight."""
    marker = compose(inverse(pose), SIDE)
    eye = np.array([CHAIR.camera.x, CHAIR.camera.y])
    sight = math.atan2(*(eye - marker[:2])[::-1])
    mirrored = np.array([*marker[:2], wrap_angle(2.0 * sight - marker[2])])
    noise = rng.normal(size=3) * [0.005, 0.005, 0.02]
    docks = (compose(place + noise, inverse(SIDE)) for place in (marker, mirrored))
    return [observation(CHAIR, dock, (0.01, 0.03), w) for dock, w in zip(docks, (weight, 1.0 - weight), strict=True)]


class Drive:
    """From where the marker is seen 15 deg aside; odometry and images at 20 Hz."""

    def __init__(self, seed: int = 1) -> None:
        self.rng, self.observer = np.random.default_rng(seed), DockObserver(CHAIR.camera)
        self.pose, self.odom, self.k = np.array([-2.0, -0.3, 0.0]), np.array([1.0, 2.0, 0.4]), 0
        self.truth = compose(self.odom, inverse(self.pose))
        self.outcomes: list[Outcome] = []

    def on(self, seconds: float, v: float, weight: float, *, slip: float = 0.0, drift: float = 0.0) -> None:
        """`weight`: of the true pose; `drift` [rad/m] of the odometry's heading."""
        for _ in range(round(20 * seconds)):
            self.k += 1
            self.pose = arc_step(self.pose, v * (1.0 - slip), 0.0, 0.05)
            self.odom = arc_step(self.odom, v, drift * v, 0.05)
            self.observer.add_odometry(Odometry(0.05 * self.k, self.odom, v, drift * v))
            fusion = self.observer.add_detections(0.05 * self.k, both(self.pose, self.rng, weight))
            self.outcomes.append(fusion.outcome)

    def off(self) -> float:
        """[rad] of the estimated heading."""
        truth = compose(self.odom, inverse(self.pose))
        return abs(wrap_angle(float(self.observer.estimate().pose[2] - truth[2])))


@pytest.mark.parametrize(("slip", "drift"), [(0.0, 0.0), (0.12, 0.0), (0.0, 0.2)])
def test_the_wrong_one_of_two_is_left_within_a_few_decimetres(slip: float, drift: float) -> None:
    """However both drift in odom."""
    drive = Drive()
    drive.on(1.0, 0.0, 0.35)
    assert drive.off() > 0.2 and Outcome.ACQUIRED in drive.outcomes
    drive.observer.bound_reacquisition(True, Dock().front)
    before = len(drive.outcomes)
    drive.on(2.0, 0.3, 0.45, slip=slip, drift=drift)
    assert drive.off() < 0.05
    assert drive.outcomes[before:].count(Outcome.ACQUIRED) == 1
    jump = drive.observer.images.jump
    assert jump is None or sudden(jump, PlausibilityParameters()) is None
    assert drive.observer.elsewhere is None


def test_the_right_one_stays_though_images_favour_the_other() -> None:
    drive = Drive()
    drive.on(1.0, 0.0, 0.65)
    drive.on(3.0, 0.3, 0.4)
    assert drive.off() < 0.05 and drive.outcomes.count(Outcome.ACQUIRED) == 1


def test_images_of_a_chair_that_stands_err_alike_and_change_nothing() -> None:
    drive = Drive()
    drive.on(1.0, 0.0, 0.65)
    drive.on(5.0, 0.0, 0.1)
    assert drive.off() < 0.05


def test_nearby_the_dock_changes_no_more() -> None:
    drive = Drive()
    drive.pose = np.array([-0.25, -0.1, 0.0])
    drive.on(1.0, 0.0, 0.35)
    drive.observer.bound_reacquisition(True, Dock().front)
    before = len(drive.outcomes)
    drive.on(2.0, 0.1, 0.35)
    assert Outcome.ACQUIRED not in drive.outcomes[before:]
