"""The observer with odometry as drivers publish it: a gyro with a bias, slow messages, images ahead of them."""

import numpy as np
import pytest
from conftest import observation
from drives import CHAIR, Drive

from seater_common.se2 import inverse
from seater_nmpc.observe.innovation import Outcome


@pytest.mark.parametrize("image_period", [0.03, 0.1, 0.3])
@pytest.mark.parametrize("bias", [0.03, -0.05])
def test_a_gyro_with_a_bias_at_rest_acquires_and_the_dock_does_not_drift(bias: float, image_period: float) -> None:
    """At 0.03 rad/s the dock moves by 8 cm a second in odom; seen from the chair it stays, at any camera rate."""
    drive = Drive(gyro_bias=bias, image_period=image_period)
    drive.go(0.0, 0.0, 8.0)
    assert drive.outcomes.index("ACQUIRED") <= 8 and "GATE" not in drive.outcomes[-10:]
    errors = np.abs(np.array(drive.errors[-10:]))
    assert np.max(errors[:, :2]) < 0.006 and np.max(errors[:, 2]) < 0.004
    assert drive.observer.estimate().drift[3] == pytest.approx(bias, abs=0.004)
    assert drive.observer.true_speeds(0.0, bias)[1] == pytest.approx(0.0, abs=0.004)


def test_a_chair_that_turns_faster_than_a_bias_explains_acquires_nothing() -> None:
    drive = Drive()
    drive.go(0.0, 0.15, 2.0)
    assert set(drive.outcomes) == {"ACQUIRING"}


def test_images_wait_for_odometry_at_five_hertz() -> None:
    """None is lost once the period of the odometry is known, and the dock is known as well as the images say."""
    drive = Drive(odometry_period=0.2, image_period=0.05)
    drive.go(0.0, 0.0, 2.0)
    lost = drive.observer.images.counts[Outcome.NO_ODOMETRY]
    drive.go(0.3, 0.05, 5.0)
    counts = drive.observer.images.counts
    assert drive.outcomes.count("WAITING") >= 20 and counts[Outcome.NO_ODOMETRY] == lost
    assert drive.outcomes[-4:].count("FUSED") >= 2 and counts[Outcome.FUSED] >= 110
    assert np.max(np.abs(drive.errors[-1])) < 0.004


def test_a_waiting_image_counts_when_its_odometry_arrives() -> None:
    drive = Drive(odometry_period=0.2, image_period=0.2)
    drive.go(0.0, 0.0, 2.0)
    before = drive.observer.estimate()
    for _ in range(15):  # driven, images and odometry apart
        drive.go(0.3, 0.0, 0.01)
    seen = observation(CHAIR, inverse(drive.truth))
    assert drive.observer.add_detections(drive.now, [seen]).outcome is Outcome.WAITING
    assert drive.observer.estimate().pose == pytest.approx(before.pose)
    waited = drive.now
    drive.go(0.3, 0.0, 0.05)
    assert drive.observer.measurements_since(waited)[0][0].stamp == waited
    too_early = drive.observer.add_detections(drive.now + 0.9, [seen])
    assert too_early.outcome is Outcome.NO_ODOMETRY
