import math

import numpy as np
import pytest

from seater_common.se2 import (
    arc_length,
    arc_poses,
    arc_step,
    compose,
    inverse,
    relative,
    transform_points,
    wrap_angle,
    wrap_angles,
)


@pytest.mark.parametrize(("angle", "wrapped"), [(0.0, 0.0), (4.0, 4.0 - 2 * math.pi), (-7.0, 2 * math.pi - 7.0)])
def test_wrap_angle(angle: float, wrapped: float) -> None:
    assert wrap_angle(angle) == pytest.approx(wrapped, abs=1e-15)


def test_wrap_angle_of_nan_and_infinity_is_nan() -> None:
    assert math.isnan(wrap_angle(math.nan)) and math.isnan(wrap_angle(math.inf))


def test_compose_takes_coordinates_in_b_to_a() -> None:
    T_a_b = [1.0, 2.0, math.pi / 2]
    np.testing.assert_allclose(compose(T_a_b, [3.0, 0.0, 0.1]), [1.0, 5.0, math.pi / 2 + 0.1], atol=1e-15)
    np.testing.assert_allclose(transform_points(T_a_b, [[3.0, 1.0]]), [[0.0, 5.0]], atol=1e-15)


def test_inverse_and_relative() -> None:
    T = np.array([0.3, -1.2, 2.5])
    np.testing.assert_allclose(compose(T, inverse(T)), np.zeros(3), atol=1e-15)
    np.testing.assert_allclose(relative(T, compose(T, [0.4, 0.5, -0.6])), [0.4, 0.5, -0.6], atol=1e-15)


def test_arc_step_is_a_quarter_circle() -> None:
    np.testing.assert_allclose(arc_step([0, 0, 0], math.pi / 2, math.pi / 2, 1.0), [1.0, 1.0, math.pi / 2], atol=1e-14)


@pytest.mark.parametrize("omega", [0.0, -0.9])
def test_arc_poses_are_those_of_arc_step(omega: float) -> None:
    durations = np.linspace(0.0, 7.0, 5)
    one_by_one = [arc_step([1, 2, 0.5], 0.4, omega, duration) for duration in durations]
    np.testing.assert_allclose(arc_poses([1, 2, 0.5], 0.4, omega, durations), one_by_one, atol=1e-14)


@pytest.mark.parametrize("way", [0.3, -0.3])
@pytest.mark.parametrize("omega", [0.0, 1e-12, -2.0])
def test_arc_length_is_the_way_driven(way: float, omega: float) -> None:
    x, y, turn = arc_step([0, 0, 0], way, omega, 1.0).tolist()
    assert arc_length(x, y, turn) == pytest.approx(way, abs=1e-15)


def test_arc_step_is_smooth_through_straight() -> None:
    np.testing.assert_allclose(arc_step([1, 2, 0.5], 0.4, 0.0, 2.0), arc_step([1, 2, 0.5], 0.4, 1e-12, 2.0), atol=1e-11)


def test_arrays_are_wrapped_as_single_angles_are() -> None:
    angles = np.array([[-7.0, -3.2, -1.0], [0.0, 3.1, 9.5]])
    single = [[wrap_angle(float(angle)) for angle in row] for row in angles]
    assert wrap_angles(angles) == pytest.approx(np.array(single), abs=1e-12)
