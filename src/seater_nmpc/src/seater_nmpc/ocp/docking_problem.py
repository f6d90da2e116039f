"""The formulation `docking`: what the chair drives with."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_nmpc.ocp.jerk import JerkLimits
from seater_nmpc.ocp.model import augmented_step, step_curvature
from seater_nmpc.ocp.problem import Problem
from seater_nmpc.programme import StageProgramme

Array = NDArray[np.float64]

_REVERSE_WIDTH = 0.02  # [m/s] over which the cost of driving backward sets in


class DockingProblem(Problem):
    """Quadratic stage cost, exact L1 terminal penalty, acceleration limits, soft areas against the whole footprint.

    Variables in the order z0, u0, z1, areas1, u1, ..., zN, areasN, t with z = (x, y, theta, v, omega) and
    u = (dv/dt, domega/dt).

    The prediction's speeds are ramps; the chair holds each command r_k for a control period T from its beginning on,
    and so drives T sum r_k = (ramps) + T/2 (r_n - r_0). Hence p - T/2 r moves as predicted, and the plan starts there
    (`lead` = T/2). Euler steps of length h use the speed at a step's beginning, which is another h/2 late.
    """

    def _build(self, programme: StageProgramme) -> None:
        p = self._parameters
        self.lead = 0.5 * p.control_period + (0.5 * float(self._steps[0]) if p.integrator == "euler" else 0.0)
        low, high = self._speed_bounds()
        low, high = [-math.inf] * 3 + low, [math.inf] * 3 + high
        rate = [self._chair.limits.a_max, self._chair.limits.alpha_max]
        self._jerk = JerkLimits.wanted(p, programme)
        z, where = programme.variable("z0", low, high)
        self._z.append(where)
        for k, h in enumerate(self._steps.tolist()):
            u, where = programme.variable(f"u{k}", [-r for r in rate], rate)
            self._u.append(where)
            programme.cost += h * self._stage_cost(z, u)
            if self._jerk is not None:
                self._jerk.add_stage(programme, u, h)
            z_next, where = programme.variable(f"z{k + 1}", low, high)
            self._z.append(where)
            self._dynamics.append(len(programme.g_lower))
            programme.constrain(z_next - augmented_step(z, u, h, self._parameters.integrator), 0.0, 0.0)
            z = z_next
            if self._areas is not None:
                self._areas.add_stage(programme, z[:3], z[3], h)
        self._terminal_penalty(programme, z)

    def _stage_cost(self, z: ca.SX, u: ca.SX) -> ca.SX:
        w = self._parameters.weights
        backward = 0.5 * (ca.sqrt(z[3] ** 2 + _REVERSE_WIDTH**2) - z[3])
        position = w.x * z[0] ** 2 + w.y * z[1] ** 2 + w.heading * z[2] ** 2
        speed = w.speed * (z[3] ** 2 + z[4] ** 2) + w.reverse * backward**2
        return position + speed + w.acceleration * ca.sumsqr(u)

    def _terminal_penalty(self, programme: StageProgramme, z: ca.SX) -> None:
        """wN (|x| + |y| + c |theta|) with slacks t >= |.|: exact, and smooth where the solver looks."""
        w = self._parameters.weights
        t, self._terminal = programme.variable("t", [0.0] * 3, [math.inf] * 3)
        programme.constrain(t - z[:3], 0.0, math.inf)
        programme.constrain(t + z[:3], 0.0, math.inf)
        programme.cost += w.terminal * (t[0] + t[1] + w.terminal_heading * t[2])

    def _make_curvature(self) -> ca.Function | None:
        x, p, size = self.functions["x"], self.functions["p"], self.functions["x"].numel()
        lam_g, total = ca.SX.sym("lam_g", self.functions["g"].numel()), ca.SX(size, size)
        for row, z, u, h in zip(self._dynamics, self._z[:-1], self._u, self._steps.tolist(), strict=True):
            where = [*range(z.start, z.stop), *range(u.start, u.stop)]
            force = -lam_g[row : row + 2]  # the constraint is z_next - F(z, u)
            total[where, where] += step_curvature(x[z], x[u], force, h, self._parameters.integrator)
        return ca.Function("curvature", [x, p, lam_g], [ca.triu(total)])

    def _slow_columns(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        return self._columns[1:, 3], self._columns[1:, 4]

    def _initial(self, state: Array) -> Array:
        return self._within_speed_limits(state)

    def _write_trajectory(self, states: Array, x: Array) -> None:
        x[self._columns] = states
        x[self._input_columns] = np.diff(states[:, 3:], axis=0) / self._steps[:, None]
        x[self._terminal] = np.abs(states[-1, :3])

    def _read_trajectory(self, x: Array) -> Array:
        return x[self._columns]
