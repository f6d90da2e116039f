"""Normal equations whose matrix is sparse and positive definite."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix, diags
from scipy.sparse.linalg import splu

Array = NDArray[np.float64]


class NormalEquations:
    """N = J^T J + damping diag(J^T J), factorised; unknowns that meet few others cost little.

    Raises RuntimeError: N is singular.
    """

    def __init__(self, J: csr_matrix, damping: float = 0.0) -> None:
        N = csc_matrix(J.T @ J)
        if damping > 0.0:
            N = csc_matrix(N + diags(damping * N.diagonal()))
        self._factor = splu(N, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        self._size = N.shape[0]

    def solve(self, right: Array) -> Array:
        """N^-1 of (n,) or (n, k)."""
        return np.asarray(self._factor.solve(right))

    def covariance(self, first: int) -> Array:
        """(first, first) of N^-1: of the first unknowns."""
        return self.solve(np.eye(self._size, first))[:first]
