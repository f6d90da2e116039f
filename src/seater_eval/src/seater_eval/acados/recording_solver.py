"""A solver that remembers what it was asked and what came back."""

from __future__ import annotations

from typing import ClassVar, Self

from seater_nmpc.ocp.problem import Problem
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import ProblemData, WarmStart
from seater_nmpc.solve.interface import Solution, Solver
from seater_nmpc.solve.registry import make_solver


class RecordingSolver:
    """The solver that the parameters name; `data` and `solution` are the last instance and its solution."""

    name: ClassVar[str] = "recording"
    takes_coupled_stages: ClassVar[bool] = True
    data: ProblemData
    solution: Solution
    cold: bool  # whether the last solve began without multipliers

    def __init__(self, solver: Solver) -> None:
        self._solver = solver

    @classmethod
    def for_problem(cls, problem: Problem, parameters: ControlParameters) -> Self:
        """See Solver."""
        return cls(make_solver(problem, parameters))

    def prepare(self, time_limits: list[float | None]) -> None:
        """See Solver."""
        self._solver.prepare(time_limits)

    def solve(self, data: ProblemData, start: WarmStart, time_limit: float | None = None) -> Solution:
        """See Solver."""
        self.data, self.cold = data, start.lam_g is None
        self.solution = self._solver.solve(data, start, time_limit)
        return self.solution
