"""Optimal control problems and their solvers are built once in a process: half a second to a second each."""

from __future__ import annotations

from functools import cache
from typing import Any

from seater_common.geometry import Chair
from seater_nmpc.control import replanner
from seater_nmpc.ocp.areas import Areas
from seater_nmpc.ocp.formulations import make_problem
from seater_nmpc.ocp.problem import Problem
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.solve.interface import Solver
from seater_nmpc.solve.registry import make_solver


class _Key:
    """Equal for what is written the same: areas hold arrays, which have no hash."""

    def __init__(self, *parts: Any) -> None:
        self.parts, self._text = parts, repr(parts)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Key) and self._text == other._text

    def __hash__(self) -> int:
        return hash(self._text)


@cache
def _problem(key: _Key) -> Problem:
    return make_problem(*key.parts)


@cache
def _solver(problem: Problem, key: _Key) -> Solver:
    return make_solver(problem, *key.parts)


def share() -> None:
    """From now on controllers of the same chair, parameters and areas have the same problem and the same solver.

    Neither keeps anything from goal to goal: a cold start forgets (RtiSolver), so that a docking comes out as with its
    own (test_campaign.py compares the bits). Two controllers of the same should not take turns.
    """

    def problem(chair: Chair, parameters: ControlParameters, areas: Areas | None) -> Problem:
        return _problem(_Key(chair, parameters, areas))

    replanner.make_problem = problem
    replanner.make_solver = lambda problem, parameters: _solver(problem, _Key(parameters))
