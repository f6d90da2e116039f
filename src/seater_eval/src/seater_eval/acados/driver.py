"""acados in the closed loop: the same problem, starts and lines of obstacles as the controller's."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair, Dock
from seater_common.se2 import arc_step
from seater_eval.acados.peer import AcadosPeer
from seater_nmpc.ocp.areas import dock_areas
from seater_nmpc.ocp.docking_problem import DockingProblem
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import ProblemData, WarmStart
from seater_nmpc.solve.ipopt import IpoptSolver

Array = NDArray[np.float64]

_COLD_ROUNDS = 4  # solves of a cold start, each with the lines of the last one's plan; as the controller does


class AcadosDriver:
    """Drives to the dock with the first input of acados' plan; see PoseController. Cold starts are solved by Ipopt."""

    name = "acados"

    def __init__(
        self, chair: Chair, dock: Dock, parameters: ControlParameters, peer: AcadosPeer, obstacles: list[Array]
    ) -> None:
        """`peer` for the same chair, dock and parameters; `obstacles` convex and anticlockwise in the dock's frame."""
        self._areas, self._parameters, self._peer, self._obstacles = dock_areas(dock), parameters, peer, obstacles
        self._problem = DockingProblem(chair, parameters, self._areas)
        self._cold = IpoptSolver.for_problem(self._problem, parameters)
        self.period = parameters.control_period
        self.reset()

    def reset(self) -> None:
        """See PoseController."""
        self._plan: Array | None = None
        self._last: tuple[float, float] | None = None
        self.solve_time = self.solve_cpu = 0.0
        self.failed = False

    def command(self, T_dock_base: ArrayLike, velocity: tuple[float, float]) -> tuple[float, float]:
        """See PoseController."""
        before = velocity if self._last is None else self._last
        state = np.array([*arc_step(T_dock_base, *before, -self._problem.lead), *before])
        if self._plan is None:
            x = self._begin(state)
            self._peer.begin(x)
        else:
            x, answer = self._peer.step(self._instance(state, self._plan))
            self.solve_time, self.solve_cpu, self.failed = answer.wall, answer.cpu, answer.status != 0
        self._plan = states = self._problem.states(x)
        share = self.period / self._parameters.step
        v, omega = (float(value) for value in states[0, 3:] + share * (states[1, 3:] - states[0, 3:]))
        self._last = v, omega
        return self._last

    def _begin(self, state: Array) -> Array:
        """A converged plan from standing where the chair is."""
        states = np.repeat(state[None, :], self._parameters.horizon + 1, axis=0)
        states[:, 3:] = 0.0
        x = self._problem.guess(states, self._areas)
        for _ in range(_COLD_ROUNDS if self._obstacles else 1):
            x = self._cold.solve(self._instance(state, self._problem.states(x)), WarmStart(x)).x
        return x

    def _instance(self, state: Array, states: Array) -> ProblemData:
        lines = self._problem.obstacle_lines(self._obstacles, states)
        return self._problem.data(state, self._areas, lines)
