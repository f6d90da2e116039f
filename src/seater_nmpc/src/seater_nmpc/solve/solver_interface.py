"""What every solver takes and gives back. A solver never raises into the control loop and never returns non-finite."""

from __future__ import annotations

import os
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

# One thread: threads of BLAS only disturb a solve of this size. Read when the library is loaded, hence before CasADi.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402
from numpy.typing import NDArray  # noqa: E402

from seater_nmpc.ocp.nlp import ProblemData, WarmStart  # noqa: E402

Array = NDArray[np.float64]


class SolveStatus(Enum):
    """How a solve ended."""

    SOLVED = "solved"  # converged; of the real-time iteration: as far as it goes in a cycle, and feasible
    LIMIT = "limit"  # stopped by time or iterations; the iterate may or may not be usable
    FAILED = "failed"  # no usable numbers


@dataclass(frozen=True)
class Solution:
    """What a solver gives back; x and the multipliers are finite unless the status is FAILED."""

    status: SolveStatus
    x: Array
    lam_x: Array
    lam_g: Array
    cost: float
    gap: float  # largest violation of bounds and constraints
    iterations: int
    solve_time: float  # wall time [s]
    text: str  # the solver's own words

    def warm_start(self) -> WarmStart:
        """This solution as the beginning of the next solve."""
        return WarmStart(self.x, self.lam_x, self.lam_g)


class Solver(Protocol):
    """A method for problems of one structure."""

    name: str

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
    return Solution(SolveStatus.FAILED, start.x, nothing, nothing, 0.0, float("inf"), 0, solve_time, text)
