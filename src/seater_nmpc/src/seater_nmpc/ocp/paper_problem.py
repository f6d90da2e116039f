"""The formulation `paper`: the one that the project's paper describes (design, section 5)."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_nmpc.ocp.model import euler_pose_step
from seater_nmpc.ocp.problem import Problem
from seater_nmpc.programme import StageProgramme

Array = NDArray[np.float64]


class PaperProblem(Problem):
    """The paper's formulation: poses and u = (v, omega), Euler steps, F1 and F2 weighted by Q and P, inputs by R.

    F2 = pi - ||phi - phi_doc| - pi|. No acceleration limits; areas (if any) as in DockingProblem.
    """

    speeds_held = True

    def _build(self, programme: StageProgramme) -> None:
        w, free = self._parameters.paper, [math.inf] * 3
        pose, where = programme.variable("x0", [-math.inf] * 3, free)
        self._z.append(where)
        for k, h in enumerate(self._steps.tolist()):
            u, where = programme.variable(f"u{k}", *self._speed_bounds())
            self._u.append(where)
            programme.cost += _paper_cost(pose, w.Q_position, w.Q_heading) + w.R_v * u[0] ** 2 + w.R_omega * u[1] ** 2
            following, where = programme.variable(f"x{k + 1}", [-math.inf] * 3, free)
            self._z.append(where)
            programme.constrain(following - euler_pose_step(pose, u[0], u[1], h), 0.0, 0.0)
            pose = following
            if self._areas is not None:
                self._areas.add_stage(programme, pose, u[0], h)
        programme.cost += _paper_cost(pose, w.P_position, w.P_heading)

    def _initial(self, state: Array) -> Array:
        return np.array(state[:3], dtype=float)

    def _write_trajectory(self, states: Array, x: Array) -> None:
        x[self._columns] = states[:, :3]
        x[self._input_columns] = states[:-1, 3:]

    def _read_trajectory(self, x: Array) -> Array:
        return np.hstack([x[self._columns], np.vstack([x[self._input_columns], np.zeros(2)])])


def _paper_cost(pose: ca.SX, position: float, heading: float) -> ca.SX:
    F1 = ca.sumsqr(pose[:2])
    F2 = math.pi - ca.fabs(ca.fabs(pose[2]) - math.pi)
    return position * F1 + heading * F2
