"""One call of a solver that CasADi carries, and what comes back."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import casadi as ca

from seater_nmpc.programme import ProblemData, WarmStart
from seater_nmpc.solve.interface import Solution, SolveStatus, all_finite, failed, outside

# What Ipopt says when a function was not finite: what it gives back is where it started, however feasible that looks.
_NO_RESULT = ("Invalid_Number_Detected",)


def run_nlpsol(
    solver: ca.Function,
    data: ProblemData,
    arguments: dict[str, Any],
    start: WarmStart,
    translate: Callable[[dict[str, ca.DM]], dict[str, ca.DM]] = dict,
) -> Solution:
    """Call CasADi's solver and judge what comes back; `translate` brings it into the order of the programme."""
    begin = time.perf_counter()
    try:
        result = translate(solver(**arguments))
        statistics = solver.stats()
    except RuntimeError as error:  # CasADi raises on invalid numbers in the functions
        return failed(start, time.perf_counter() - begin, str(error).splitlines()[0])
    solve_time = time.perf_counter() - begin
    x, lam_x, lam_g, g = (result[key].full().ravel() for key in ("x", "lam_x", "lam_g", "g"))
    text, cost = str(statistics.get("return_status", "")), float(result["f"])
    if text in _NO_RESULT or not all_finite(cost, x, lam_x, lam_g, g):
        return failed(start, solve_time, f"not finite ({text})")
    return Solution(
        status=SolveStatus.SOLVED if statistics.get("success") else SolveStatus.LIMIT,
        x=x,
        lam_x=lam_x,
        lam_g=lam_g,
        cost=cost,
        violation=max(outside(x, data.lbx, data.ubx), outside(g, data.lbg, data.ubg)),
        iterations=int(statistics.get("iter_count", 0)),
        solve_time=solve_time,
        text=text,
    )
