"""The optimal control problems by name."""

from __future__ import annotations

from seater_common.geometry import Chair
from seater_nmpc.ocp.areas import Areas
from seater_nmpc.ocp.docking_problem import DockingProblem
from seater_nmpc.ocp.paper_problem import PaperProblem
from seater_nmpc.ocp.problem import Problem
from seater_nmpc.parameters import ControlParameters


def make_problem(chair: Chair, parameters: ControlParameters, areas: Areas | None) -> Problem:
    """The formulation that the parameters name."""
    makers = {"docking": DockingProblem, "paper": PaperProblem}
    if parameters.formulation not in makers:
        raise ValueError(f"control/formulation: is {parameters.formulation!r}, must be one of {', '.join(makers)}")
    return makers[parameters.formulation](chair, parameters, areas)
