"""What every solver takes and gives back. A solver never raises into the control loop and never returns non-finite."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.ocp.problem import Problem
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import ProblemData, WarmStart

Array = NDArray[np.float64]


class SolveStatus(Enum):
    """How a solve ended."""

    SOLVED = "solved"  # converged; of the real-time iteration: as far as it goes in a cycle, and feasible
    LIMIT = "limit"  # stopped by time or iterations; the iterate may or may not be usable
    FAILED = "failed"  # no usable numbers


@dataclass(frozen=True, kw_only=True)
class Solution:
    """What a solver gives back; x and the multipliers are finite unless the status is FAILED."""

    status: SolveStatus
    x: Array
    lam_x: Array
    lam_g: Array
    cost: float
    violation: float  # largest one of bounds and constraints [m, rad, m/s, rad/s]
    iterations: int
    solve_time: float  # wall time [s]
    text: str  # the solver's own words

    def warm_start(self) -> WarmStart:
        """This solution as the beginning of the next solve."""
        return WarmStart(self.x, self.lam_x, self.lam_g)


class Solver(Protocol):
    """A method for problems of one structure, and what it is capable of."""

    name: ClassVar[str]
    takes_coupled_stages: ClassVar[bool]  # constraints between inputs of neighbouring stages

    @classmethod
    def for_problem(cls, problem: Problem, parameters: ControlParameters) -> Self:
        """One for this problem with its own group of the parameters."""

    def solve(self, data: ProblemData, start: WarmStart, time_limit: float | None = None) -> Solution:
        """Solve one instance within `time_limit` [s] of wall time (None: only iterations are limited)."""

    def prepare(self, time_limits: list[float | None]) -> None:
        """Build what solves with these time limits need."""


def outside(values: Array, lower: Array, upper: Array) -> float:
    """By how much the values leave their bounds, at most."""
    return float(max(0.0, np.max(lower - values), np.max(values - upper)))


def all_finite(cost: float, *arrays: Array) -> bool:
    """Whether every number is finite."""
    return bool(np.isfinite(cost)) and all(np.all(np.isfinite(values)) for values in arrays)


def failed(start: WarmStart, solve_time: float, text: str) -> Solution:
    """No usable numbers."""
    nothing = np.zeros(0)
    return Solution(
        status=SolveStatus.FAILED,
        x=start.x,
        lam_x=nothing,
        lam_g=nothing,
        cost=0.0,
        violation=float("inf"),
        iterations=0,
        solve_time=solve_time,
        text=text,
    )
