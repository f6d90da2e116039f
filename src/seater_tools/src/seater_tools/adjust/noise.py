"""How noisy each kind of measurement is, by what it leaves over: variance components after Foerstner.

s^2 = v^T v / r for each group, where r is its redundancy: the number of its residuals less the trace of their part in
the hat matrix. Iterated on the linearised problem, because a change of one group's weight moves all residuals. The
trace is estimated with random signs (Hutchinson): the matrix itself would be full.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, diags

from seater_tools.adjust.normal import NormalEquations

Array = NDArray[np.float64]

MOST_ROUNDS = 60
ENOUGH = 0.03  # relative change of a factor at which the rounds end
PROBES = 12  # of the trace: with some hundreds of residuals, right to about 1 %
REDUNDANCY = 2.0  # least, of a group whose noise is estimated


def noise_factors(
    J: csr_matrix, white: Array, weights: Array, groups: Sequence[slice], low: Array, high: Array
) -> Array:
    """Factors (groups,) on the standard deviations that J and `white` (n,) were whitened with, within low and high.

    J: (n, unknowns) with robust weights (n,) in it; `white` is without them. Rows outside the groups stay as they are.
    """
    factors, rooted = np.ones(len(groups)), np.sqrt(weights) * white
    signs = np.random.default_rng(1).choice([-1.0, 1.0], (len(white), PROBES))
    for _ in range(MOST_ROUNDS):
        scale = np.ones(len(white))
        for group, factor in zip(groups, factors, strict=True):
            scale[group] = 1.0 / factor
        A = csr_matrix(diags(scale) @ J)
        equations = NormalEquations(A)
        v = scale * rooted
        v = v - A @ equations.solve(A.T @ v)
        before = factors.copy()
        for i, group in enumerate(groups):
            probes = np.asarray(A[group].T @ signs[group])
            trace = float(np.sum(probes * equations.solve(probes))) / PROBES
            redundancy = float(np.sum(weights[group])) - trace
            if redundancy > REDUNDANCY:
                factors[i] *= np.sqrt(float(v[group] @ v[group]) / redundancy)
        factors = np.clip(factors, low, high)
        if np.all(np.abs(np.log(factors / before)) < ENOUGH):
            break
    return factors
