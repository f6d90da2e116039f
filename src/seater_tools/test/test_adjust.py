"""Robust least squares against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from seater_tools.adjust.jacobian import Jacobian
from seater_tools.adjust.noise import noise_factors
from seater_tools.adjust.robust import HUBER, NoMinimumError, huber_cost, huber_weights, minimise

RNG_SEED = 5


def test_the_jacobian_is_that_of_the_function() -> None:
    pattern = csr_matrix(np.array([[1, 0, 1], [0, 1, 1], [1, 0, 0], [0, 1, 0]]))

    def function(x: np.ndarray) -> np.ndarray:
        return np.array([np.sin(x[0]) * x[2], x[1] ** 2 + x[2], 3.0 * x[0], np.exp(x[1])])

    x = np.array([0.3, -0.7, 1.2])
    J = Jacobian(pattern)(function, x, function(x)).toarray()
    expected = [[np.cos(0.3) * 1.2, 0.0, np.sin(0.3)], [0.0, -1.4, 1.0], [3.0, 0.0, 0.0], [0.0, np.exp(-0.7), 0.0]]
    assert pytest.approx(np.array(expected), abs=1e-6) == J


def test_a_line_through_points_with_outliers() -> None:
    rng = np.random.default_rng(RNG_SEED)
    t = np.linspace(0.0, 1.0, 400)
    y = 2.0 - 3.0 * t + 0.1 * rng.standard_normal(400)
    y[::20] += 5.0
    dense = csr_matrix(np.ones((400, 2)))
    found = minimise(lambda x: (x[0] + x[1] * t - y) / 0.1, Jacobian(dense), np.array([0.0, 0.0]), 2)
    # 20 outliers pull with HUBER each: a shift of the mean by about 20 * 3 * 0.1 / 380.
    assert found.state == pytest.approx([2.0, -3.0], abs=0.04)
    A = np.column_stack([np.ones(400), t])[found.weights == 1.0]
    assert found.covariance == pytest.approx(0.01 * np.linalg.inv(A.T @ A), rel=0.1)


def test_steps_that_go_up_are_damped() -> None:
    """Gauss and Newton's steps of arctan diverge from here."""
    found = minimise(lambda x: 2.0 * np.arctan(x), Jacobian(csr_matrix(np.ones((1, 1)))), np.array([3.0]), 1)
    assert found.state == pytest.approx([0.0], abs=0.06)  # the square falls by less than 0.01 from there


def test_residuals_that_are_not_finite_are_refused() -> None:
    with pytest.raises(NoMinimumError, match="not finite"):
        minimise(lambda x: x * np.nan, Jacobian(csr_matrix(np.ones((1, 1)))), np.array([3.0]), 1)


def test_huber() -> None:
    white = np.array([0.5, -HUBER, 2.0 * HUBER])
    assert huber_weights(white) == pytest.approx([1.0, 1.0, 0.5])
    assert huber_cost(white) == pytest.approx(0.25 + HUBER**2 + 3.0 * HUBER**2)


def test_noise_of_two_groups_is_told_apart() -> None:
    """Each of 300 unknowns is measured twice by each of two instruments, which are 2 and 0.5 times as noisy as said."""
    rng = np.random.default_rng(RNG_SEED)
    J = csr_matrix(np.vstack([np.eye(300)] * 4))
    white = np.concatenate([2.0 * rng.standard_normal(600), 0.5 * rng.standard_normal(600)])
    groups = [slice(0, 600), slice(600, 1200)]
    factors = noise_factors(J, white, np.ones(1200), groups, np.full(2, 0.01), np.full(2, 100.0))
    assert factors == pytest.approx([2.0, 0.5], rel=0.08)  # 300 degrees of freedom each: 4 %
    bounded = noise_factors(J, white, np.ones(1200), groups, np.array([0.01, 1.0]), np.array([1.5, 100.0]))
    assert bounded == pytest.approx([1.5, 1.0])
