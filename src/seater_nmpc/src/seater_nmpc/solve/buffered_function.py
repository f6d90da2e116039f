"""CasADi functions without the cost of converting arguments and results."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from seater_nmpc.solve.interface import Array


class BufferedFunction:
    """A CasADi function called without conversions: arguments and results live in arrays of this object."""

    def __init__(self, function: ca.Function) -> None:
        self.inputs = [np.zeros(function.nnz_in(i)) for i in range(function.n_in())]
        self.outputs = [np.zeros(function.nnz_out(i)) for i in range(function.n_out())]
        buffer: Any
        buffer, self._call = function.buffer()
        self._buffer = buffer  # holds what _call uses
        for i, values in enumerate(self.inputs):
            buffer.set_arg(i, values.data)
        for i, values in enumerate(self.outputs):
            buffer.set_res(i, values.data)

    def __call__(self, *arguments: Array) -> list[Array]:
        """The outputs' nonzeros, in arrays that the next call overwrites."""
        for own, given in zip(self.inputs, arguments, strict=True):
            own[:] = given
        self._call()
        return self.outputs
