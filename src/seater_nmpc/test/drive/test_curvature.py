"""What a chair turns by itself."""

import pytest

from seater_nmpc.drive.curvature import CurvatureEstimator

PERIOD = 0.05


def drive(estimator: CurvatureEstimator, curvature: float, v: float, seconds: float) -> None:
    """A chair that turns by `curvature` [rad/m] beside what it is asked for."""
    for _ in range(round(seconds / PERIOD)):
        estimator.add((curvature - estimator.value) * v, v, PERIOD)


@pytest.mark.parametrize("v", [0.15, 0.5, -0.3])
def test_it_converges_to_what_the_plant_does_and_leaves_no_offset(v: float) -> None:
    estimator = CurvatureEstimator()
    drive(estimator, 0.08, v, 1.5)
    assert 0.02 < estimator.value < 0.07
    drive(estimator, 0.08, v, 25.0)
    assert estimator.value == pytest.approx(0.08, abs=1e-4)
    drive(estimator, -0.05, v, 30.0)  # another floor
    assert estimator.value == pytest.approx(-0.05, abs=2e-4)


def test_it_is_bounded() -> None:
    estimator = CurvatureEstimator()
    drive(estimator, 3.0, 0.4, 60.0)
    assert estimator.value == 0.2
    drive(estimator, -3.0, 0.4, 60.0)
    assert estimator.value == -0.2


def test_a_bump_and_turning_on_the_spot_say_little() -> None:
    estimator = CurvatureEstimator()
    estimator.add(2.0, 0.4, PERIOD)
    bumped = estimator.value
    assert 0.0 < bumped < 0.011
    for _ in range(20):
        estimator.add(0.1, 0.0, PERIOD)
    assert estimator.value == bumped
    slow, quick = CurvatureEstimator(), CurvatureEstimator()
    slow.add(0.001 * 0.1, 0.001, PERIOD)
    quick.add(0.4 * 0.1, 0.4, PERIOD)
    assert abs(slow.value) < 0.01 * quick.value
