"""Speeds by images: no verdict on images whose times say nothing."""

import numpy as np
import pytest

from seater_nmpc.observe.measurement import Measurement
from seater_nmpc.observe.odometry import NO_TRAVEL, Instant
from seater_nmpc.plausibility.image_motion import Shown, speeds_by_images

MIDDLE = np.array([0.9, 0.0])


def images(stamps: list[float]) -> Shown:
    """The dock 2 m ahead of a chair that drives towards it at 0.2 m/s."""
    seen = Measurement(np.array([2.0, 0.0, 0.0]), np.diag([1e-6, 1e-6, 1e-6]))
    return [(Instant(t, np.array([0.2 * t, 0.0, 0.0]), 0.2, 0.0, NO_TRAVEL), [seen]) for t in stamps]


def test_images_in_the_order_of_their_times_give_the_speed_of_the_odometry() -> None:
    speeds = speeds_by_images(images([0.0, 0.1, 0.2, 0.3, 0.4]), MIDDLE)
    assert speeds is not None and speeds.odometry[0] == pytest.approx(0.2)
    assert speeds.images[0] == pytest.approx(0.2)


@pytest.mark.parametrize("stamps", [[0.4, 0.1, 0.2, 0.3, 0.4], [0.4, 0.3, 0.2, 0.1, 0.05], [0.4] * 5])
def test_others_give_none(stamps: list[float]) -> None:
    """As after a clock that went backward; the first divided by zero."""
    assert speeds_by_images(images(stamps), MIDDLE) is None
