"""The sparse Jacobian by differences: columns that share no row are moved together."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize._numdiff import group_columns
from scipy.sparse import csr_matrix

Array = NDArray[np.float64]

STEP = 1e-7  # of unknowns of about 1 m or 1 rad, whose residuals are smooth: slopes are right to about as much


class Jacobian:
    """Of a function whose derivative has this pattern (residuals, unknowns), not zero where it depends."""

    def __init__(self, pattern: csr_matrix) -> None:
        self._shape = pattern.shape
        group = group_columns(pattern)
        entries = pattern.tocoo()
        self._parts = []
        for index in range(int(group.max()) + 1):
            mine = group[entries.col] == index
            self._parts.append((group == index, entries.row[mine], entries.col[mine]))

    def __call__(self, function: Callable[[Array], Array], state: Array, white: Array) -> csr_matrix:
        """At `state`, where the function is `white`."""
        rows, columns, values = [], [], []
        for moved, row, column in self._parts:
            slope = (function(state + STEP * moved) - white) / STEP
            rows.append(row)
            columns.append(column)
            values.append(slope[row])
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        return csr_matrix(entries, shape=self._shape)
