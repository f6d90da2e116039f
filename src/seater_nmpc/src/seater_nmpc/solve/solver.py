"""Solvers behind one interface, chosen by name."""

from __future__ import annotations

from collections.abc import Callable

from seater_nmpc.solve.solver_interface import Solution, Solver, SolveStatus  # isort: skip

import casadi as ca

from seater_nmpc.parameters import ControlParameters
from seater_nmpc.solve.nlpsol_solvers import DefaultIpoptSolver, FatropSolver, IpoptSolver
from seater_nmpc.solve.rti import RtiSolver

__all__ = [
    "DefaultIpoptSolver",
    "FatropSolver",
    "IpoptSolver",
    "RtiSolver",
    "Solution",
    "SolveStatus",
    "Solver",
    "make_solver",
]


def make_solver(
    functions: dict[str, ca.SX],
    parameters: ControlParameters,
    refinement: ca.Function | None = None,
    curvature: ca.Function | None = None,
) -> Solver:
    """The solver that the parameters name; `refinement` and `curvature`: see seater_nmpc.ocp.ocp.Problem (for `rti` only)."""
    makers: dict[str, Callable[[], Solver]] = {
        "ipopt": lambda: IpoptSolver(functions, parameters.ipopt),
        "ipopt_default": lambda: DefaultIpoptSolver(functions, parameters.ipopt),
        "fatrop": lambda: FatropSolver(functions, parameters.fatrop),
        "rti": lambda: RtiSolver(
            functions, parameters.rti, IpoptSolver(functions, parameters.ipopt), refinement, curvature
        ),
    }
    if parameters.solver not in makers:
        raise ValueError(f"control/solver: is {parameters.solver!r}, must be one of {', '.join(makers)}")
    return makers[parameters.solver]()
