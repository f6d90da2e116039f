"""The solvers that CasADi carries: Ipopt (the reference, and with its default options as a baseline) and fatrop."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from seater_nmpc.solve.solver_interface import Array, Solution, SolveStatus, all_finite, failed, outside  # isort: skip

import casadi as ca
import numpy as np

from seater_nmpc.ocp.nlp import ProblemData, WarmStart
from seater_nmpc.parameters import FatropParameters, IpoptParameters

# What Ipopt says when a function was not finite: what it gives back is where it started, however small the gap looks there.
_NO_RESULT = ("Invalid_Number_Detected",)


class IpoptSolver:
    """Ipopt: the reference. Warm-started with variables, multipliers and a small barrier parameter."""

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
        """See Solver."""
        warm = start.lam_x is not None and start.lam_g is not None
        arguments = {"x0": start.x, "p": data.p, "lbx": data.lbx, "ubx": data.ubx, "lbg": data.lbg, "ubg": data.ubg}
        if start.lam_x is not None and start.lam_g is not None:
            arguments |= {"lam_x0": start.lam_x, "lam_g0": start.lam_g}
        return run_nlpsol(self._solver(warm, time_limit), data, arguments, start)

    def _solver(self, warm: bool, time_limit: float | None) -> ca.Function:
        key = (warm, time_limit)
        if key not in self._built:
            self._built[key] = ca.nlpsol("ipopt", "ipopt", self._functions, self._options(warm, time_limit))
        return self._built[key]

    def _options(self, warm: bool, time_limit: float | None) -> dict[str, Any]:
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


class DefaultIpoptSolver(IpoptSolver):
    """Ipopt with its default options, started from the last plan's variables alone: what one gets without effort.

    A baseline for benchmarks. Only the wall-time limit (if any) is kept, so that the controller stays safe with it.
    """

    name = "ipopt_default"

    def solve(self, data: ProblemData, start: WarmStart, time_limit: float | None = None) -> Solution:
        """See Solver."""
        return super().solve(data, WarmStart(start.x), time_limit)

    def prepare(self, time_limits: list[float | None]) -> None:
        """See Solver."""
        for limit in time_limits:
            self._solver(False, limit)

    def _options(self, warm: bool, time_limit: float | None) -> dict[str, Any]:
        options = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False, "error_on_fail": False}
        return options if time_limit is None else {**options, "ipopt.max_wall_time": time_limit}


class FatropSolver:
    """fatrop: an interior point method that factorises stage by stage. No warm start of multipliers.

    The initial state, fixed by its bounds, becomes an equality; the constraints are brought into fatrop's order (of each
    stage the dynamics first). The stages are read off the sparsity of the equalities, so a programme whose variables come
    in the order of the stages is all that is needed. fatrop has no wall-time limit: the iterations are limited.
    """

    name = "fatrop"

    def __init__(self, functions: dict[str, ca.SX], parameters: FatropParameters) -> None:
        self._functions, self._parameters = functions, parameters
        self._solver: ca.Function | None = None
        self._fixed = self._order = np.zeros(0, dtype=int)

    def prepare(self, time_limits: list[float | None]) -> None:
        """Nothing: which variables are fixed comes with the first instance."""

    def solve(self, data: ProblemData, start: WarmStart, time_limit: float | None = None) -> Solution:
        """See Solver."""
        fixed = np.flatnonzero(data.lbx == data.ubx)
        if self._solver is None or not np.array_equal(fixed, self._fixed):
            self._fixed = fixed
            self._solver = self._build(data)
        lbx, ubx, zeros = data.lbx.copy(), data.ubx.copy(), np.zeros(len(fixed))
        lbx[fixed], ubx[fixed] = -np.inf, np.inf
        arguments = {
            "x0": np.clip(start.x, data.lbx, data.ubx),
            "p": np.concatenate([data.p, data.lbx[fixed]]),
            "lbx": lbx,
            "ubx": ubx,
            "lbg": np.concatenate([data.lbg, zeros])[self._order],
            "ubg": np.concatenate([data.ubg, zeros])[self._order],
        }
        return run_nlpsol(self._solver, data, arguments, start, self._original)

    def _original(self, result: dict[str, ca.DM]) -> dict[str, ca.DM]:
        """Constraints and multipliers in the order of the programme; the initial state's become those of its bounds."""
        result = dict(result)
        for key in ("g", "lam_g"):
            values = np.empty(len(self._order))
            values[self._order] = result[key].full().ravel()
            if key == "lam_g":
                lam_x = result["lam_x"].full().ravel()
                lam_x[self._fixed] += values[len(values) - len(self._fixed) :]
                result["lam_x"] = ca.DM(lam_x)
            result[key] = ca.DM(values[: len(values) - len(self._fixed)])
        return result

    def _build(self, data: ProblemData) -> ca.Function:
        f = self._functions
        initial = ca.SX.sym("initial", len(self._fixed))
        g = ca.vertcat(f["g"], f["x"][self._fixed.tolist()] - initial)
        equality = np.concatenate([data.lbg == data.ubg, np.ones(len(self._fixed), dtype=bool)])
        inputs, stages = _stages(ca.jacobian(g, f["x"]).sparsity(), equality, len(self._fixed))
        self._order = np.argsort(stages, kind="stable")
        states = [len(self._fixed)] * len(inputs)
        counts = np.bincount(np.floor(stages[~np.isin(stages % 1.0, [0.0])]).astype(int), minlength=len(inputs))
        options = {
            "structure_detection": "manual",
            "N": len(inputs) - 1,
            "nx": states,
            "nu": inputs,
            "ng": counts.tolist(),
            "equality": equality[self._order].tolist(),
            "print_time": False,
            "error_on_fail": False,
            "fatrop.print_level": 0,
            "fatrop.tol": self._parameters.tolerance,
            "fatrop.max_iter": self._parameters.max_iterations,
            "fatrop.mu_init": self._parameters.barrier,
        }
        programme = {"x": f["x"], "p": ca.vertcat(f["p"], initial), "f": f["f"], "g": g[self._order.tolist()]}
        return ca.nlpsol("fatrop", "fatrop", programme, options)


def _stages(jacobian: ca.Sparsity, equality: Array, nx: int) -> tuple[list[int], Array]:
    """Inputs of each stage 0..N, and for each constraint its stage k (dynamics) or k + 0.5 (any other).

    The last `nx` constraints fix the initial state; the other equalities are the dynamics, in groups of nx, with the next
    state as their right-most variables. A constraint belongs to the stage that its left-most variable is in.
    """
    rows, columns = (np.array(values) for values in jacobian.get_triplet())
    left, right = np.full(len(equality), jacobian.size2()), np.zeros(len(equality), dtype=int)
    np.minimum.at(left, rows, columns)
    np.maximum.at(right, rows, columns)
    dynamics = np.flatnonzero(equality[: len(equality) - nx])
    starts = np.concatenate([[0], right[dynamics].reshape(-1, nx).min(axis=1)])
    stages = np.searchsorted(starts, left, side="right") - 0.5
    stages[dynamics] = np.repeat(np.arange(len(starts) - 1), nx)
    inputs = np.diff(np.append(starts, jacobian.size2())) - nx
    return inputs.tolist(), stages


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
    gap = max(outside(x, data.lbx, data.ubx), outside(g, data.lbg, data.ubg))
    status = SolveStatus.SOLVED if statistics.get("success") else SolveStatus.LIMIT
    return Solution(status, x, lam_x, lam_g, cost, gap, int(statistics.get("iter_count", 0)), solve_time, text)
