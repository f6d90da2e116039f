"""Sequential quadratic programming in real time: one QP per control cycle (Diehl, Bock, Schloeder 2005)."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import ClassVar, Self

import casadi as ca
import numpy as np
import piqp

from seater_nmpc.ocp.problem import Problem
from seater_nmpc.parameters import ControlParameters, RtiParameters
from seater_nmpc.programme import ProblemData, WarmStart
from seater_nmpc.solve.interface import Array, Solution, Solver, SolveStatus, all_finite, failed
from seater_nmpc.solve.ipopt import IpoptSolver
from seater_nmpc.solve.quadratic_model import NoStepError, QuadraticModel

# The line search: step lengths that are tried, and by how much the merit function may grow, relative and absolute. Full
# steps are the rule; it helps where the linearisation points across a bend and two points would alternate.
_STEP_LENGTHS = (1.0, 0.5, 0.25)
_MERIT_RISE = 1.0
_TIME_RESERVE = 1.5  # another iteration is begun only if this many times the last one's duration is left


@dataclass(frozen=True)
class _Iterate:
    """A refined point: its cost, and by how much constraints are violated there, at most and in sum."""

    x: Array
    cost: float
    violation: float
    total_violation: float

    def merit(self, penalty_weight: float) -> float:
        """The exact (L1) penalty function; exact from the largest multiplier on."""
        return self.cost + penalty_weight * self.total_violation


class RtiSolver:
    """Newton steps from the last plan, in full where harmless; a cold start (no multipliers) is left to `converging`.

    A cycle takes `iterations` steps, and further ones, up to `max_iterations`, while a constraint is violated by more
    than `feasibility`; but after the first one only while time remains.
    """

    name: ClassVar[str] = "rti"
    takes_coupled_stages: ClassVar[bool] = True

    def __init__(
        self,
        functions: dict[str, ca.SX],
        parameters: RtiParameters,
        converging: Solver,
        refinement: ca.Function | None = None,
        curvature: ca.Function | None = None,
    ) -> None:
        self._functions, self._parameters = functions, parameters
        self._converging, self._refinement, self._curvature = converging, refinement, curvature
        self._model: QuadraticModel | None = None
        self._fixed: Array = np.zeros(0)

    @classmethod
    def for_problem(cls, problem: Problem, parameters: ControlParameters) -> Self:
        """See Solver. Cold starts are solved by Ipopt."""
        converging = IpoptSolver.for_problem(problem, parameters)
        return cls(problem.functions, parameters.rti, converging, problem.refinement, problem.curvature)

    def prepare(self, time_limits: list[float | None]) -> None:
        """See Solver. The linearisation is built in the first solve, which knows what is fixed."""
        self._converging.prepare(time_limits)

    def solve(self, data: ProblemData, start: WarmStart, time_limit: float | None = None) -> Solution:
        """See Solver."""
        fixed = data.lbx == data.ubx
        if self._model is None or not np.array_equal(fixed, self._fixed):
            self._model = QuadraticModel(self._functions, data, self._parameters, self._refinement, self._curvature)
            self._fixed = fixed
        if start.lam_x is None or start.lam_g is None:
            self._model.forget()
            return self._converging.solve(data, start, time_limit)
        begin = time.perf_counter()
        try:
            return self._iterate(self._model, data, start.x, start.lam_g.copy(), begin, time_limit)
        except NoStepError as reason:
            return failed(start, time.perf_counter() - begin, str(reason))

    def _iterate(
        self, model: QuadraticModel, data: ProblemData, x: Array, lam_g: Array, begin: float, limit: float | None
    ) -> Solution:
        count, began, here = 0, begin, _iterate_at(model, x, data)
        while True:
            result = model.step(here.x, lam_g, data)
            here = _line_search(model, data, here, result, lam_g)
            count, now = count + 1, time.perf_counter()
            if self._enough(count, here.violation):
                break
            if limit is not None and now - begin + _TIME_RESERVE * (now - began) > limit:  # the next one would be late
                break
            began = now
        lam_x = np.zeros(len(data.lbx))
        lam_x[model.free] = result.z_bu - result.z_bl
        if not all_finite(0.0, lam_x, lam_g):
            raise NoStepError("multipliers not finite")
        return Solution(
            status=SolveStatus.SOLVED if here.violation <= self._parameters.feasibility else SolveStatus.LIMIT,
            x=here.x,
            lam_x=lam_x,
            lam_g=lam_g,
            cost=here.cost,
            violation=max(0.0, here.violation),
            iterations=count,
            solve_time=time.perf_counter() - begin,
            text=f"quadratic programme: {result.info.iter} iterations, longest step {np.max(np.abs(result.x)):.1e}",
        )

    def _enough(self, count: int, violation: float) -> bool:
        p = self._parameters
        return count >= (p.iterations if violation <= p.feasibility else max(p.iterations, p.max_iterations))


def _line_search(
    model: QuadraticModel, data: ProblemData, here: _Iterate, result: piqp.Result, lam_g: Array
) -> _Iterate:
    """The first step length whose merit is below the bound, else the one with the least merit. Updates lam_g."""
    multipliers = np.empty_like(lam_g)
    multipliers[model.equal], multipliers[model.unequal] = result.y, result.z_u - result.z_l
    weight = float(np.max(np.abs(multipliers)))
    bound, best, least, taken = here.merit(weight) * (1.0 + _MERIT_RISE) + _MERIT_RISE, here, math.inf, 1.0
    for length in _STEP_LENGTHS:
        x = here.x.copy()
        x[model.free] += length * result.x
        there = _iterate_at(model, x, data)
        merit = there.merit(weight)
        if merit < least:
            best, least, taken = there, merit, length
        if merit <= bound:
            break
    lam_g += taken * (multipliers - lam_g)
    return best


def _iterate_at(model: QuadraticModel, x: Array, data: ProblemData) -> _Iterate:
    """The point x, refined. Raises NoStepError where anything is not finite."""
    x, cost, g = model.refined(x, data)
    violations = np.maximum(np.maximum(data.lbg - g, g - data.ubg), 0.0)
    largest, total = float(np.max(violations)), float(np.sum(violations))
    if not math.isfinite(total + cost + float(np.dot(x, x))):
        raise NoStepError("iterate not finite")
    return _Iterate(x.copy(), cost, largest, total)
