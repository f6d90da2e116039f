"""Solvers behind one interface, chosen by name. A solver never raises into the control loop and never returns non-finite."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

# One thread: threads of BLAS only disturb a solve of this size. Read when the library is loaded, hence before CasADi.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import casadi as ca  # noqa: E402
import numpy as np  # noqa: E402
from numpy.typing import NDArray  # noqa: E402

from seater_nmpc.nlp import ProblemData, WarmStart  # noqa: E402
from seater_nmpc.parameters import ControlParameters, IpoptParameters  # noqa: E402

Array = NDArray[np.float64]


class SolveStatus(Enum):
    """How a solve ended."""

    SOLVED = "solved"  # converged
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


class IpoptSolver:
    """Ipopt as CasADi carries it: the reference."""

    name = "ipopt"

    def __init__(self, functions: dict[str, ca.SX], parameters: IpoptParameters) -> None:
        self._functions, self._parameters = functions, parameters
        self._built: dict[tuple[bool, float | None], ca.Function] = {}

    def prepare(self, time_limits: list[float | None]) -> None:
        """Build what solves with these time limits need, so that no control cycle has to."""
        for warm in (False, True):
            for limit in time_limits:
                self._solver(warm, limit)

    def solve(self, data: ProblemData, start: WarmStart, time_limit: float | None = None) -> Solution:
        warm = start.lam_x is not None and start.lam_g is not None
        arguments = {"x0": start.x, "p": data.p, "lbx": data.lbx, "ubx": data.ubx, "lbg": data.lbg, "ubg": data.ubg}
        if start.lam_x is not None and start.lam_g is not None:
            arguments |= {"lam_x0": start.lam_x, "lam_g0": start.lam_g}
        solver = self._solver(warm, time_limit)
        begin = time.perf_counter()
        try:
            result = solver(**arguments)
            statistics = solver.stats()
        except RuntimeError as error:  # CasADi raises on invalid numbers in the functions
            return _failed(start, time.perf_counter() - begin, str(error).splitlines()[0])
        return _solution(data, result, statistics, time.perf_counter() - begin)

    def _solver(self, warm: bool, time_limit: float | None) -> ca.Function:
        key = (warm, time_limit)
        if key not in self._built:
            self._built[key] = ca.nlpsol("ipopt", "ipopt", self._functions, self._options(warm, time_limit))
        return self._built[key]

    def _options(self, warm: bool, time_limit: float | None) -> dict:
        options = {
            "ipopt.print_level": 0,
            "ipopt.sb": "yes",
            "print_time": False,
            "error_on_fail": False,
            "ipopt.tol": self._parameters.tolerance,
            "ipopt.max_iter": self._parameters.max_iterations,
        }
        if time_limit is not None:
            options["ipopt.max_wall_time"] = time_limit
        if warm:
            options |= {
                "ipopt.warm_start_init_point": "yes",
                "ipopt.mu_init": self._parameters.warm_barrier,
                "ipopt.warm_start_bound_push": 1e-6,
                "ipopt.warm_start_bound_frac": 1e-6,
                "ipopt.warm_start_slack_bound_push": 1e-6,
                "ipopt.warm_start_slack_bound_frac": 1e-6,
                "ipopt.warm_start_mult_bound_push": 1e-6,
            }
        return options


def make_solver(functions: dict[str, ca.SX], parameters: ControlParameters) -> Solver:
    """The solver that the parameters name."""
    makers = {"ipopt": lambda: IpoptSolver(functions, parameters.ipopt)}
    if parameters.solver not in makers:
        raise ValueError(f"control/solver: is {parameters.solver!r}, must be one of {', '.join(makers)}")
    return makers[parameters.solver]()


def _solution(data: ProblemData, result: dict[str, ca.DM], statistics: dict, solve_time: float) -> Solution:
    x, lam_x, lam_g, g = (result[key].full().ravel() for key in ("x", "lam_x", "lam_g", "g"))
    text = str(statistics.get("return_status", ""))
    cost = float(result["f"])
    if not (np.isfinite(cost) and all(np.all(np.isfinite(values)) for values in (x, lam_x, lam_g, g))):
        return _failed(WarmStart(np.zeros_like(x)), solve_time, f"not finite ({text})")
    gap = max(_outside(x, data.lbx, data.ubx), _outside(g, data.lbg, data.ubg))
    status = SolveStatus.SOLVED if statistics.get("success") else SolveStatus.LIMIT
    return Solution(status, x, lam_x, lam_g, cost, gap, int(statistics.get("iter_count", 0)), solve_time, text)


def _outside(values: Array, lower: Array, upper: Array) -> float:
    return float(max(0.0, np.max(lower - values), np.max(values - upper)))


def _failed(start: WarmStart, solve_time: float, text: str) -> Solution:
    nothing = np.zeros(0)
    return Solution(SolveStatus.FAILED, start.x, nothing, nothing, 0.0, float("inf"), 0, solve_time, text)
