"""Ipopt as CasADi carries it: the reference, and with its default options as a baseline."""

from __future__ import annotations

from typing import Any, ClassVar, Self

import casadi as ca

from seater_nmpc.ocp.problem import Problem
from seater_nmpc.parameters import ControlParameters, IpoptParameters
from seater_nmpc.programme import ProblemData, WarmStart
from seater_nmpc.solve.interface import Solution
from seater_nmpc.solve.nlpsol import run_nlpsol


class IpoptSolver:
    """Ipopt: the reference. Warm-started with variables, multipliers and a small barrier parameter."""

    name: ClassVar[str] = "ipopt"
    takes_coupled_stages: ClassVar[bool] = True

    def __init__(self, functions: dict[str, ca.SX], parameters: IpoptParameters) -> None:
        self._functions, self._parameters = functions, parameters
        self._built: dict[tuple[bool, float | None], ca.Function] = {}

    @classmethod
    def for_problem(cls, problem: Problem, parameters: ControlParameters) -> Self:
        """See Solver."""
        return cls(problem.functions, parameters.ipopt)

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

    name: ClassVar[str] = "ipopt_default"

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
