"""The solvers by name."""

from __future__ import annotations

from seater_nmpc.ocp.problem import Problem
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.solve.fatrop import FatropSolver
from seater_nmpc.solve.interface import Solver
from seater_nmpc.solve.ipopt import DefaultIpoptSolver, IpoptSolver
from seater_nmpc.solve.rti import RtiSolver

_ALL: tuple[type[Solver], ...] = (IpoptSolver, DefaultIpoptSolver, FatropSolver, RtiSolver)
SOLVERS = {solver.name: solver for solver in _ALL}


def make_solver(problem: Problem, parameters: ControlParameters) -> Solver:
    """The solver that the parameters name.

    Raises:
        ValueError: an unknown name, or one that cannot solve this problem.
    """
    able = [name for name, solver in SOLVERS.items() if solver.takes_coupled_stages or not problem.couples_stages]
    if parameters.solver not in able:
        why = " where max_jerk or max_angular_jerk is not 0" if parameters.solver in SOLVERS else ""
        raise ValueError(f"control/solver: is {parameters.solver!r}, must be one of {', '.join(able)}{why}")
    return SOLVERS[parameters.solver].for_problem(problem, parameters)
