"""The docking problem of seater_nmpc (docs/explanation/controller.md) put together with do-mpc, as its users would.

Same augmented state, arc step, stage cost, exact terminal penalty and limits; the bay's walls as soft constraints with
one separating angle each, the bay's speed limit with a braking curve. do-mpc knows no variables without dynamics, so
the terminal penalty's slacks and the angles are inputs: t_k >= |pose_{k+1}|, and only the last one is priced (through a
state that remembers it). Not in it: the field of view. do-mpc solves with Ipopt, here with Ipopt's default options.
"""

from __future__ import annotations

import logging
import math
import time
import warnings
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from seater_common.geometry import Chair, Dock
from seater_common.se2 import arc_step
from seater_nmpc.ocp.constraints.bay_speed import allowed_speed
from seater_nmpc.ocp.model import augmented_step
from seater_nmpc.parameters import ControlParameters


class DoMpc:
    """Drives towards the dock; see PoseController."""

    name = "do_mpc"

    def __init__(self, chair: Chair, dock: Dock | None, parameters: ControlParameters) -> None:
        """`dock`: its bay is respected (None: free space). Raises ImportError where do-mpc is not installed."""
        with warnings.catch_warnings():  # it warns of missing optional packages
            warnings.simplefilter("ignore")
            import do_mpc
        self._chair, self._dock, self._parameters = chair, dock, parameters
        self.period = parameters.control_period
        # The chair holds a command while the plan's speed is a ramp; see
        # seater_nmpc.ocp.docking_problem.DockingProblem.
        self._lead = 0.5 * self.period + (0.5 * parameters.step if parameters.integrator == "euler" else 0.0)
        self._model = do_mpc.model.Model("discrete", "SX")
        self._build_model()
        # do-mpc makes new symbols when a model is set up, so the next state is written with those.
        z, u = self._model.x["z"], self._model.u["u"]
        self._following = augmented_step(z, u, parameters.step, parameters.integrator)
        self._mpc = self._build_controller(do_mpc)
        self.reset()

    def reset(self) -> None:
        """See PoseController."""
        self._last: tuple[float, float] | None = None
        self.solve_time, self.failed = 0.0, False

    def command(self, T_dock_base: ArrayLike, velocity: tuple[float, float]) -> tuple[float, float]:
        """See PoseController."""
        before = velocity if self._last is None else self._last
        start = arc_step(T_dock_base, *before, -self._lead)
        x0 = np.array([*start, *before, 0.0, 0.0, 0.0]).reshape(-1, 1)
        if self._last is None:
            self._begin(x0)
        began = time.perf_counter()
        with warnings.catch_warnings():  # do-mpc hands arrays to CasADi in a way that CasADi announces to change
            warnings.simplefilter("ignore", FutureWarning)
            u = np.asarray(self._mpc.make_step(x0)).ravel()
        self.solve_time = time.perf_counter() - began
        self.failed = not np.all(np.isfinite(u))
        a, alpha = (0.0, 0.0) if self.failed else (float(u[0]), float(u[1]))
        self._last = (before[0] + self.period * a, before[1] + self.period * alpha)
        return self._last

    def _begin(self, x0: np.ndarray) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FutureWarning)
            self._mpc.reset_history()
            self._mpc.x0 = x0
            self._mpc.set_initial_guess()

    def _build_model(self) -> None:
        """States z (5) and `reached` (3), inputs: accelerations, t >= |next pose|, angles."""
        model = self._model
        z = model.set_variable("_x", "z", shape=(5, 1))
        model.set_variable("_x", "reached", shape=(3, 1))
        u = model.set_variable("_u", "u", shape=(2, 1))
        t = model.set_variable("_u", "t", shape=(3, 1))
        if self._dock is not None:
            model.set_variable("_u", "beta", shape=(2, 1))
        model.set_rhs("z", augmented_step(z, u, self._parameters.step, self._parameters.integrator))
        model.set_rhs("reached", t)
        model.setup()

    def _build_controller(self, do_mpc: Any) -> Any:
        mpc, p, limits = do_mpc.controller.MPC(self._model), self._parameters, self._chair.limits
        mpc.settings.n_horizon, mpc.settings.t_step = p.horizon, p.step
        mpc.settings.store_full_solution = False
        mpc.settings.supress_ipopt_output()
        self._set_cost(mpc)
        speeds, rates = [limits.v_max, limits.omega_max], [limits.a_max, limits.alpha_max]
        mpc.bounds["lower", "_x", "z"] = np.array([-np.inf] * 3 + [-limits.v_reverse_max, -limits.omega_max])
        mpc.bounds["upper", "_x", "z"] = np.array([np.inf] * 3 + speeds)
        mpc.bounds["lower", "_u", "u"] = -np.array(rates)
        mpc.bounds["upper", "_u", "u"] = np.array(rates)
        pose, t = self._following[:3], self._model.u["t"]
        mpc.set_nl_cons("terminal", ca.vertcat(pose - t, -pose - t), ub=0.0)
        if self._dock is not None:
            self._set_areas(mpc)
        logging.getLogger("do-mpc").setLevel(logging.ERROR)
        mpc.setup()
        return mpc

    def _set_cost(self, mpc: Any) -> None:
        p, w, z, u = self._parameters, self._parameters.weights, self._model.x["z"], self._model.u["u"]
        backward = 0.5 * (ca.sqrt(z[3] ** 2 + 0.02**2) - z[3])
        stage = w.x * z[0] ** 2 + w.y * z[1] ** 2 + w.heading * z[2] ** 2
        stage += w.speed * (z[3] ** 2 + z[4] ** 2) + w.reverse * backward**2 + w.acceleration * ca.sumsqr(u)
        reached = self._model.x["reached"]
        terminal = w.terminal * (reached[0] + reached[1] + w.terminal_heading * reached[2])
        mpc.set_objective(mterm=terminal, lterm=p.step * stage)
        mpc.set_rterm(t=1e-9)  # do-mpc warns without one; this is no weight

    def _set_areas(self, mpc: Any) -> None:
        assert self._dock is not None
        p, bay, limits = self._parameters, self._dock.bay, self._chair.limits
        z, beta = self._following, self._model.u["beta"]
        c, s, half = ca.cos(z[2]), ca.sin(z[2]), 0.5 * bay.width
        corners = [(z[0] + c * a - s * b, z[1] + s * a + c * b) for a, b in self._chair.corners().tolist()]
        mpc.bounds["lower", "_u", "beta"] = np.array([-math.pi, 0.5 * math.pi])
        mpc.bounds["upper", "_u", "beta"] = np.array([-0.5 * math.pi, math.pi])
        outside = [x - bay.back_wall_x + p.margin for x, _ in corners]
        for i, wall in enumerate((half, -half)):
            for x, y in corners:
                ahead = ca.cos(beta[i]) * (x - bay.entrance_x) + ca.sin(beta[i]) * (y - wall)
                outside.append(p.margin - ahead)
        front, rear = self._chair.length_front, self._chair.length_rear
        reach = 0.5 * (front - rear) * c + 0.5 * (front + rear) * ca.sqrt(c**2 + 4e-4)
        left = bay.entrance_x - z[0] - reach - 0.5 * self._chair.width * ca.sqrt(s**2 + 4e-4)
        allowed = allowed_speed(left, limits, p.bay_deceleration)
        penalty_weight = p.step * p.weights.violation
        for name, expression in (("areas", ca.vertcat(*outside)), ("bay", ca.vertcat(z[3] - allowed, -z[3] - allowed))):
            mpc.set_nl_cons(name, expression, ub=0.0, soft_constraint=True, penalty_term_cons=penalty_weight)
