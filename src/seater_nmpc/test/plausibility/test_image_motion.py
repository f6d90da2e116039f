"""Speeds by images: no verdict on images whose times say nothing."""

import numpy as np
import pytest

from seater_nmpc.observe.measurement import Measurement
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.observe.odometry.travel import NO_TRAVEL
from seater_nmpc.parameters import PlausibilityParameters
from seater_nmpc.plausibility.contradiction import Kind
from seater_nmpc.plausibility.image_motion import Shown, contradiction, speeds_by_images

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


def test_two_places_that_images_leave_open_are_no_motion() -> None:
    """Of a marker at the side: now the one is likelier, now the other, and the last images show only that one."""
    shown = images([0.0, 0.1, 0.2, 0.3, 0.4])
    here = shown[0][1][0]
    for k, (_, offered) in enumerate(shown):
        weight = 0.6 if k < 3 else 0.0
        there = Measurement(np.array([2.1, -0.25, 0.26]), np.diag([1e-4, 1e-4, 1e-3]), weight)
        offered[:] = [there, Measurement(here.pose, here.covariance, 1.0 - weight)] if weight else [here]
    speeds = speeds_by_images(shown, MIDDLE)
    assert speeds is not None and speeds.images == pytest.approx((0.2, 0.0))


def test_two_flipped_images_in_a_row_are_no_wheels_that_spin() -> None:
    """As a chair saw them on its way at 0.5 m/s: flipped, the dock stands nearly where it was, only turned."""
    chair = [(3.115, -1.392, 0.909), (3.139, -1.359, 0.981), (3.163, -1.319, 1.057), (3.186, -1.274, 1.133)]
    dock = [(4.406, 1.197, 0.633), (4.432, 1.211, 0.635), (4.42, 1.215, 0.643), (5.076, 0.995, 1.425)]
    chair, dock = [*chair, (3.207, -1.225, 1.21)], [*dock, (5.039, 0.983, 1.404)]
    covariance = np.diag([0.014**2, 0.014**2, 0.01**2])
    shown = [
        (Instant(0.1 * i, np.array(at), 0.5, 0.7, NO_TRAVEL), [Measurement(np.array(seen), covariance)])
        for i, (at, seen) in enumerate(zip(chair, dock, strict=True))
    ]
    assert speeds_by_images(shown, MIDDLE) is None
    right = [*shown[:3], *((at, [Measurement(np.array([4.42, 1.213, 0.64]), covariance)]) for at, _ in shown[3:])]
    speeds = speeds_by_images(right, MIDDLE)
    assert speeds is not None and speeds.images[0] == pytest.approx(speeds.odometry[0], abs=0.1)


def late(clock: float, slowing: float, share: float = 1.0) -> Shown:
    """The dock 2 m ahead, seen each 0.1 s by a chair that slows down from 0.5 m/s; its odometry is stamped `clock` [s]
    later than the images, and its wheels get on by `share` of what they turn."""
    seen = []
    for k in range(5):
        then, t = 0.1 * k - clock, 0.1 * k  # what odometry of that stamp knows, and when the image was taken
        told, true = (0.25 * at - 0.5 * slowing * at**2 for at in (then, t))
        dock = Measurement(np.array([told + 2.0 - share * true, 0.0, 0.0]), np.diag([4e-6, 4e-6, 4e-6]))
        seen.append((Instant(t, np.array([told, 0.0, 0.0]), 0.25 - slowing * then, 0.0, NO_TRAVEL), [dock]))
    return seen


def test_odometry_that_is_stamped_late_is_no_wheel_that_slips() -> None:
    """0.16 m/s apart while it turns back with 1.1 m/s^2, and 0.15 s late."""
    speeds = speeds_by_images(late(0.15, 1.1), MIDDLE)
    assert speeds is not None and speeds.odometry[0] - speeds.images[0] > 0.15
    assert contradiction(speeds, PlausibilityParameters()) is None


@pytest.mark.parametrize("slowing", [0.0, 0.1])
def test_wheels_that_spin_are_found_whatever_the_clocks_are(slowing: float) -> None:
    speeds = speeds_by_images(late(0.0, slowing, share=0.1), MIDDLE)
    assert speeds is not None
    found = contradiction(speeds, PlausibilityParameters())
    assert found is not None and found.kind is Kind.WHEELS_SLIP
