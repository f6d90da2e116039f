"""Robust sparse least squares: Levenberg and Marquardt's steps on the normal equations, reweighted (Huber)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, diags

from seater_tools.adjust.jacobian import Jacobian
from seater_tools.adjust.normal import NormalEquations

Array = NDArray[np.float64]
Function = Callable[[Array], Array]

HUBER = 3.0  # standard deviations from where a residual counts linearly
MOST_STEPS = 40
# A step that lowers the sum of squares by less is the last one: by a tenth of a standard deviation's square. One that
# strong damping made short says nothing.
LEAST_FALL, FREE = 0.01, 1e-3
DAMPING = (1e-9, 10.0, 1e6)  # of the diagonal: smallest and first, factor per trial, largest


class NoMinimumError(ValueError):
    """The steps do not come to an end."""


@dataclass(frozen=True, eq=False)
class Minimum:
    """`jacobian`: of the residuals as weighted there. `covariance`: (J^T J)^-1 of the first unknowns."""

    state: Array
    covariance: Array
    jacobian: csr_matrix
    weights: Array


def huber_weights(white: Array) -> Array:
    """Of white residuals, in the sum of squares whose minimum is Huber's."""
    return np.minimum(1.0, HUBER / np.maximum(np.abs(white), 1e-12))


def huber_cost(white: Array) -> float:
    """Squares up to HUBER, straight lines beyond."""
    size = np.abs(white)
    return float(np.sum(np.where(size <= HUBER, size**2, 2.0 * HUBER * size - HUBER**2)))


def minimise(function: Function, jacobian: Jacobian, state: Array, first: int) -> Minimum:
    """`first`: so many unknowns get a covariance.

    Raises NoMinimumError: MOST_STEPS do not suffice, residuals are not finite, or an unknown has no influence.
    """
    white = function(state)
    if not np.all(np.isfinite(white)):
        raise NoMinimumError("the residuals at the start are not finite")
    damping = DAMPING[0]
    for _ in range(MOST_STEPS):
        weights = huber_weights(white)
        J = csr_matrix(diags(np.sqrt(weights)) @ jacobian(function, state, white))
        cost = huber_cost(white)
        state, white, damping = _step(function, state, white, J, J.T @ (np.sqrt(weights) * white), damping)
        if cost - huber_cost(white) < LEAST_FALL and not FREE < damping < DAMPING[2]:
            weights = huber_weights(white)
            J = csr_matrix(diags(np.sqrt(weights)) @ jacobian(function, state, white))
            return Minimum(state, _equations(J).covariance(first), J, weights)
    raise NoMinimumError(f"no minimum after {MOST_STEPS} steps")


def _equations(J: csr_matrix, damping: float = 0.0) -> NormalEquations:
    try:
        return NormalEquations(J, damping)
    except RuntimeError as error:
        raise NoMinimumError(f"some unknown has no influence: {error}") from error


def _step(
    function: Function, state: Array, white: Array, J: csr_matrix, g: Array, damping: float
) -> tuple[Array, Array, float]:
    """The next state with its residuals, and the damping for the step after it; the same state: no step goes down."""
    cost = huber_cost(white)
    while damping < DAMPING[2]:
        step = -_equations(J, damping).solve(g)
        tried = function(state + step)
        if np.all(np.isfinite(tried)) and huber_cost(tried) <= cost:
            return state + step, tried, max(damping / DAMPING[1], DAMPING[0])
        damping *= DAMPING[1]
    return state, white, damping
