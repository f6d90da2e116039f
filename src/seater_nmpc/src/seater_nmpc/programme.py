"""A nonlinear programme in stages, put together variable by variable; its instances, and a solution's plan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class ProblemData:
    """One instance of a problem: minimise f(x, p) subject to lbx <= x <= ubx and lbg <= g(x, p) <= ubg."""

    p: Array
    lbx: Array
    ubx: Array
    lbg: Array
    ubg: Array


@dataclass(frozen=True)
class WarmStart:
    """Where a solver begins: the variables, and the multipliers where a previous solution is at hand."""

    x: Array
    lam_x: Array | None = None
    lam_g: Array | None = None


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A trajectory in the frame of the problem (the target's)."""

    times: Array  # (N + 1,) [s] from the instant of the initial state
    states: Array  # (N + 1, 5): x, y, theta, v, omega
    violation: float  # largest violation of an area or of the bay's speed [m, m/s]
    speeds_held: bool  # the speeds of a row hold until the next one (else they change linearly)

    def speeds_at(self, time: float) -> Array:
        """(v, omega) that the plan has after `time` [s]; the last ones beyond its end."""
        if self.speeds_held:
            return self.states[min(int(time / self.times[1] + 1e-9), len(self.times) - 1), 3:]
        return np.array([np.interp(time, self.times, self.states[:, j]) for j in (3, 4)])

    def shifted(self, time: float) -> Array:
        """States (N + 1, 5) on the same grid, `time` [s] later; the last state stays."""
        later = self.times + time
        return np.column_stack([np.interp(later, self.times, self.states[:, j]) for j in range(self.states.shape[1])])


@dataclass
class StageProgramme:
    """Collects variables, constraints and cost in the order of the stages (the order that fatrop needs)."""

    variables: list[ca.SX] = field(default_factory=list)
    lower: list[float] = field(default_factory=list)
    upper: list[float] = field(default_factory=list)
    constraints: list[ca.SX] = field(default_factory=list)
    g_lower: list[float] = field(default_factory=list)
    g_upper: list[float] = field(default_factory=list)
    parameters: list[ca.SX] = field(default_factory=list)
    cost: ca.SX = field(default_factory=lambda: ca.SX(0))
    size: int = 0
    parameter_size: int = 0

    def variable(self, name: str, lower: Sequence[float], upper: Sequence[float]) -> tuple[ca.SX, slice]:
        """New variables with their bounds (as long as `lower`), and where they stand in x."""
        symbol = ca.SX.sym(name, len(lower))
        self.variables.append(symbol)
        self.lower.extend(lower)
        self.upper.extend(upper)
        self.size += len(lower)
        return symbol, slice(self.size - len(lower), self.size)

    def parameter(self, name: str, size: int) -> tuple[ca.SX, slice]:
        """New parameters and where they stand in p."""
        symbol = ca.SX.sym(name, size)
        self.parameters.append(symbol)
        self.parameter_size += size
        return symbol, slice(self.parameter_size - size, self.parameter_size)

    def constrain(self, expression: ca.SX, lower: float, upper: float) -> None:
        """lower <= expression <= upper, for each entry."""
        self.constraints.append(expression)
        self.g_lower.extend([lower] * expression.numel())
        self.g_upper.extend([upper] * expression.numel())

    def functions(self) -> dict[str, ca.SX]:
        """The programme as CasADi's solvers take it."""
        return {
            "x": ca.vertcat(*self.variables),
            "p": ca.vertcat(*self.parameters),
            "f": self.cost,
            "g": ca.vertcat(*self.constraints),
        }
