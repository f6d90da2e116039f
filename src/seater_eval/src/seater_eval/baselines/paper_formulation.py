"""The paper's formulation with plain Ipopt."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair
from seater_nmpc.ocp.formulations import make_problem
from seater_nmpc.parameters import ControlParameters


class PaperFormulation:
    """The paper's formulation (F1, F2, no acceleration limits, Euler step) with Ipopt's default options, in free space.

    Algorithm 1: measure, solve, apply the first input. Each solve begins with the last solution moved on by one step,
    at the start of a run with standing still.
    """

    name = "paper_formulation"

    def __init__(
        self, chair: Chair, parameters: ControlParameters | None = None, max_iterations: int | None = None
    ) -> None:
        """`parameters`: horizon, step and the paper's weights are taken from them; the control period is the step.
        `max_iterations`: only for tests, which have no time for Ipopt's 3000."""
        given = parameters or ControlParameters(horizon=20, step=0.1)
        self._parameters = dataclasses.replace(given, formulation="paper", walls=False)
        self.period = self._parameters.step
        self._problem = make_problem(chair, self._parameters, None)
        options: dict[str, Any] = {
            "ipopt.print_level": 0,
            "ipopt.sb": "yes",
            "print_time": False,
            "error_on_fail": False,
        }
        if max_iterations is not None:
            options["ipopt.max_iter"] = max_iterations
        self._solver = ca.nlpsol("paper", "ipopt", self._problem.functions, options)
        self.reset()

    def reset(self) -> None:
        """See PoseController."""
        self._x: NDArray[np.float64] | None = None
        self.solve_time, self.failed = 0.0, False

    def command(self, T_dock_base: ArrayLike, velocity: tuple[float, float]) -> tuple[float, float]:
        """See PoseController."""
        state = np.array([*np.asarray(T_dock_base, dtype=float), 0.0, 0.0])
        if self._x is None:
            states = np.repeat(state[None, :], self._parameters.horizon + 1, axis=0)
        else:
            states = self._problem.plan(self._x).states
            states = np.vstack([states[1:], states[-1:]])
        data = self._problem.data(state, None)
        guess = self._problem.guess(states, None)
        began = time.perf_counter()
        result = self._solver(x0=guess, p=data.p, lbx=data.lbx, ubx=data.ubx, lbg=data.lbg, ubg=data.ubg)
        self.solve_time = time.perf_counter() - began
        x = result["x"].full().ravel()
        self.failed = not np.all(np.isfinite(x))
        if self.failed:
            self._x = None
            return 0.0, 0.0
        self._x = x
        v, omega = self._problem.plan(x).states[0, 3:]
        return float(v), float(omega)
