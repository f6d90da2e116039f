"""What stands between a solver and the controller: exceptions, numbers not finite, late and infeasible results."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from seater_nmpc.programme import ProblemData, WarmStart
from seater_nmpc.solve.interface import Solution, Solver, SolveStatus, all_finite, failed, outside

# A solver that stops at its limit comes back a little after it; by more than this fraction, and the result is late.
_GRACE = 0.1


class GuardedSolver:
    """Passes on to a solver and trusts nothing that comes back.

    - An exception, numbers that are not finite, arrays of a wrong length: FAILED.
    - Later than the time limit by more than a tenth: LIMIT with an infinite violation. It is not used in this cycle,
      which is over; the next one may go on from it.
    - SOLVED, but the variables leave their bounds, or violate constraints, by more than `feasibility`: LIMIT.
    """

    def __init__(self, solver: Solver, feasibility: float) -> None:
        """`feasibility`: largest constraint violation [m, rad, m/s, rad/s] that a solution may have."""
        self._solver, self._feasibility = solver, feasibility
        self.name = solver.name

    def prepare(self, time_limits: list[float | None]) -> None:
        """See Solver."""
        self._solver.prepare(time_limits)

    def solve(self, data: ProblemData, start: WarmStart, time_limit: float | None = None) -> Solution:
        """See Solver. Never raises."""
        begin = time.perf_counter()
        try:
            solution = self._solver.solve(data, start, time_limit)
            taken = time.perf_counter() - begin
            if solution.status is SolveStatus.FAILED:
                return solution
            fault = _fault(solution, data)
        except Exception as error:  # whatever a solver stumbles over: the chair must brake, not the node end
            return failed(start, time.perf_counter() - begin, f"{type(error).__name__}: {error}".splitlines()[0])
        if fault:
            return failed(start, taken, f"{fault} ({solution.text})")
        if time_limit is not None and taken > (1.0 + _GRACE) * time_limit:
            text = f"late: {taken:.3f} s, allowed {time_limit:.3f} s ({solution.text})"
            return replace(solution, status=SolveStatus.LIMIT, violation=float("inf"), solve_time=taken, text=text)
        violation = max(solution.violation, outside(solution.x, data.lbx, data.ubx))
        if violation > self._feasibility:
            return replace(solution, status=SolveStatus.LIMIT, violation=violation)
        return solution


def _fault(solution: Solution, data: ProblemData) -> str:
    """What makes the numbers unusable; empty when nothing does."""
    expected = ((solution.x, data.lbx), (solution.lam_x, data.lbx), (solution.lam_g, data.lbg))
    if any(np.shape(values) != bounds.shape for values, bounds in expected):
        return "arrays of a wrong length"
    if not all_finite(solution.cost + solution.violation, solution.x, solution.lam_x, solution.lam_g):
        return "not finite"
    return ""
