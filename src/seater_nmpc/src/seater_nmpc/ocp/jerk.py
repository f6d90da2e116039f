"""Limits of jerk: how fast planned accelerations may change. An option: without it the programme is as before."""

from __future__ import annotations

import math

import casadi as ca

from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import StageProgramme


class JerkLimits:
    """|u_k - u_(k-1)| <= jerk * step + s for the accelerations u = (dv/dt, domega/dt); u_(-1) comes with the instance.

    A step is as long as one of the prediction, the first one a control period: after that the next plan begins. Soft
    with an exact penalty, so that a chair near its speed limits never has an infeasible problem. Neighbouring stages
    are coupled, which not every solver takes.
    """

    def __init__(self, parameters: ControlParameters, programme: StageProgramme) -> None:
        self._parameters = parameters
        self._limits = [value or math.inf for value in (parameters.max_jerk, parameters.max_angular_jerk)]
        self._before, self.where = programme.parameter("acceleration", 2)
        self._step = parameters.control_period

    @classmethod
    def wanted(cls, parameters: ControlParameters, programme: StageProgramme) -> JerkLimits | None:
        """The limits that the parameters ask for; None: none."""
        if parameters.max_jerk == 0.0 and parameters.max_angular_jerk == 0.0:
            return None
        return cls(parameters, programme)

    def add_stage(self, programme: StageProgramme, u: ca.SX, step: float) -> None:
        """Bind the accelerations of the next stage, of length `step` [s], to those of the stage before."""
        weight = self._parameters.weights.violation
        slack, _ = programme.variable("sj", [0.0] * 2, [math.inf] * 2)
        for i, limit in enumerate(self._limits):
            if math.isfinite(limit):
                change, most = u[i] - self._before[i], limit * self._step + slack[i]
                programme.constrain(ca.vertcat(most - change, most + change), 0.0, math.inf)
        programme.cost += step * weight * (ca.sum1(slack) + ca.sumsqr(slack))
        self._before, self._step = u, step
