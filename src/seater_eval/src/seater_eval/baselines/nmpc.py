"""seater_nmpc's controller behind the interface of the baselines, with a choice of solver."""

from __future__ import annotations

import dataclasses

from numpy.typing import ArrayLike

from seater_common.geometry import Chair, Dock
from seater_nmpc.control.command import Command, Status
from seater_nmpc.control.controller import DockingController
from seater_nmpc.parameters import ControlParameters, Prediction


def available_solvers() -> list[str]:
    """Names that ControlParameters knows: seater_nmpc's registry."""
    field = next(f for f in dataclasses.fields(ControlParameters) if f.name == "solver")
    return list(field.metadata["choices"])


def for_perfect_chair(parameters: ControlParameters) -> ControlParameters:
    """The same controller for a chair without delay and lag, as `run_perfect` simulates it."""
    return dataclasses.replace(parameters, prediction=Prediction(command_delay=0.0, motor_lag=0.0))


class Nmpc:
    """The docking controller, driven to the dock. No limit of wall time, so that a loaded machine decides the same."""

    def __init__(self, chair: Chair, dock: Dock, parameters: ControlParameters, solver: str | None = None) -> None:
        """`solver`: a name of `available_solvers`; None: that of the parameters. Raises ValueError."""
        if solver is not None:
            if solver not in available_solvers():
                raise ValueError(f"solver: is {solver!r}, available are {', '.join(available_solvers())}")
            parameters = dataclasses.replace(parameters, solver=solver)
        self.name = parameters.solver
        self.period = parameters.control_period
        self.controller = DockingController(chair, dock, parameters, deterministic=True)
        self.controller.warm_up()
        self.last = Command(v=0.0, omega=0.0)

    @property
    def solve_time(self) -> float:
        """Wall time in the solver, of the last cycle [s]."""
        return self.last.solve_time

    @property
    def solve_cpu(self) -> float:
        """The solver's time on the processor, of the last cycle [s]."""
        return self.last.solve_cpu

    @property
    def failed(self) -> bool:
        """Whether the last cycle had no usable solution."""
        return self.last.status in (Status.FALLBACK_SHIFTED, Status.FALLBACK_BRAKE)

    def reset(self) -> None:
        """See PoseController."""
        self.controller.reset()

    def command(self, T_dock_base: ArrayLike, velocity: tuple[float, float]) -> tuple[float, float]:
        """See PoseController."""
        self.last = self.controller.command(T_dock_base, velocity, (0.0, 0.0, 0.0))
        return self.last.v, self.last.omega
