"""Speeds of odometry messages against those of their poses."""

import numpy as np
import pytest

from seater_common.se2 import arc_step
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.observe.odometry.twist import TwistCheck

PERIOD = 0.02


def used(check: TwistCheck, drive, reported, noise: float = 0.0, ticks: float = 0.0, start: int = 0):
    """Speeds used, (n, 2). `drive`: (n, 2) true ones of each period; `reported(v, omega)`: what the message says.
    `noise`: of what it says; `ticks` [m]: its poses are multiples of that."""
    rng, pose, result = np.random.default_rng(6), np.array([1.0, 2.0, 0.7]), []
    for k, (v, omega) in enumerate(drive):
        pose = arc_step(pose, v, omega, PERIOD)
        coarse = np.round(pose / ticks) * ticks if ticks else pose
        said = np.array(reported(v, omega)) + noise * rng.normal(size=2)
        result.append(check.speeds(Odometry(PERIOD * (start + k + 1), coarse, *said)))
    return np.array(result)


def steady(v: float, omega: float, seconds: float) -> np.ndarray:
    return np.tile([v, omega], (round(seconds / PERIOD), 1))


@pytest.mark.parametrize("v", [0.3, -0.2, 0.05])
def test_an_empty_twist_is_noticed_within_half_a_second_of_driving(v: float) -> None:
    check = TwistCheck()
    standing = used(check, steady(0.0, 0.0, 1.0), lambda v, omega: (0.0, 0.0))
    driving = used(check, steady(v, 0.4, 1.5), lambda v, omega: (0.0, 0.0), start=50)
    assert not np.any(standing) and not np.any(driving[:15])
    assert driving[28:] == pytest.approx(np.tile([v, 0.4], (47, 1)), abs=2e-4)  # chords, not arcs


def test_a_bias_at_rest_that_the_poses_do_not_have_is_noticed() -> None:
    speeds = used(TwistCheck(), steady(0.0, 0.0, 2.0), lambda v, omega: (v + 0.02, omega + 0.03))
    assert speeds[0] == pytest.approx([0.02, 0.03]) and not np.any(speeds[28:])


def test_one_wrong_axis_leaves_the_other_alone() -> None:
    speeds = used(TwistCheck(), steady(0.3, 0.4, 2.0), lambda v, omega: (0.9 * v, 0.0))
    assert speeds[-1] == pytest.approx([0.27, 0.4])


def test_a_right_twist_is_kept_through_noise_coarse_encoders_and_hard_driving() -> None:
    """Two millimetres and milliradians, 0.5 m/s^2 and 1 rad/s^2; what the message says is what is used, to the bit."""
    v = np.concatenate([np.linspace(0.0, 0.6, 60), np.full(50, 0.6), np.linspace(0.6, -0.3, 90), np.zeros(50)])
    drive = np.column_stack([v, np.interp(np.arange(v.size), [0, 40, 120, 200, 250], [0.0, 0.8, -0.8, 0.4, 0.0])])
    said: list[tuple[float, float]] = []

    def report(v: float, omega: float) -> tuple[float, float]:
        said.append((v, omega))
        return v, omega

    assert np.array_equal(used(TwistCheck(), drive, report, ticks=0.002), np.array(said))
    noisy = used(TwistCheck(), drive, lambda v, omega: (v, omega), noise=0.01)
    expected = drive + 0.01 * np.random.default_rng(6).normal(size=drive.shape)
    assert noisy == pytest.approx(expected, abs=1e-12)


def test_a_twist_that_is_right_again_is_trusted_after_two_seconds_of_driving_not_of_standing() -> None:
    check = TwistCheck()
    used(check, steady(0.3, 0.0, 1.0), lambda v, omega: (0.0, 0.0))
    used(check, steady(0.0, 0.0, 5.0), lambda v, omega: (0.0, 0.0), start=50)
    back = used(check, steady(0.3, 0.0, 3.0), lambda v, omega: (1.1 * v, omega), start=300)
    assert back[50, 0] == pytest.approx(0.3) and back[-1, 0] == pytest.approx(0.33)
