"""The bay's speed limit: inside the bay it holds, ahead of it the chair can still brake to it."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Limits
from seater_nmpc.ocp.constraints.interface import AreaConstraint, Slack, Stage
from seater_nmpc.ocp.constraints.walls import HalfPlane
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import StageProgramme

Array = NDArray[np.float64]

# The bound on the speed bends from the bay's limit into the braking curve over a few times this width [m], so far ahead
# of the entrance [m]. Sharper, and full steps across the bend do not settle.
_SOFTPLUS_WIDTH = 0.06
_SOFTPLUS_SHIFT = 3.0 * _SOFTPLUS_WIDTH
_ROUNDING = 0.02  # [-] rounding of |sin| and |cos| in the reach of the footprint: slows down up to 10 mm early


def allowed_speed(left: ca.SX, limits: Limits, deceleration: float) -> ca.SX:
    """sqrt(v_bay^2 + 2 a (left)+), smooth: with `left` [m] to the bay, the chair can still brake to the bay's limit.

    a is the fraction `deceleration` of the chair's largest one. At the entrance it is the bay's limit exactly.
    """
    smooth = _softplus(left - _SOFTPLUS_SHIFT) - _softplus(ca.SX(-_SOFTPLUS_SHIFT))
    return ca.sqrt(limits.v_bay_max**2 + 2.0 * deceleration * limits.a_max * smooth)


@dataclass(frozen=True)
class BayEntrance:
    """Behind this line the bay begins."""

    line: HalfPlane

    def transformed(self, change: Array) -> BayEntrance:
        """See Area."""
        return BayEntrance(self.line.transformed(change))

    def constraint(self, chair: Chair, parameters: ControlParameters, programme: StageProgramme) -> BaySpeedConstraint:
        """See Area."""
        return BaySpeedConstraint(chair, parameters.bay_deceleration, programme)


class BaySpeedConstraint(AreaConstraint[BayEntrance]):
    """|v| <= `allowed_speed` with what is left from the footprint's foremost point to the entrance."""

    slack = Slack.SPEED

    def __init__(self, chair: Chair, deceleration: float, programme: StageProgramme) -> None:
        """`deceleration`: fraction of the chair's largest one."""
        super().__init__()
        self._chair, self._deceleration = chair, deceleration
        self._p, self._where = programme.parameter("entrance", 3)

    def margins(self, stage: Stage) -> list[ca.SX]:
        """See AreaConstraint."""
        allowed = self._allowed(stage.pose)
        return [ca.vertcat(allowed - stage.v, allowed + stage.v)]

    def set_instance(self, area: BayEntrance, p: Array, lower: Array, upper: Array) -> None:
        """See AreaConstraint."""
        p[self._where] = area.line.vector()

    def _allowed(self, pose: ca.SX) -> ca.SX:
        """The largest speed for a pose [m/s]."""
        entrance, c, s = self._p, ca.cos(pose[2]), ca.sin(pose[2])
        forward = entrance[0] * c + entrance[1] * s  # cosine of the angle between the chair and the way into the bay
        sideways = entrance[1] * c - entrance[0] * s
        front = forward * 0.5 * (self._chair.length_front - self._chair.length_rear)
        length = 0.5 * (self._chair.length_front + self._chair.length_rear)
        reach = front + length * _rounded_abs(forward) + 0.5 * self._chair.width * _rounded_abs(sideways)
        left = entrance[2] - ca.dot(entrance[:2], pose[:2]) - reach
        return allowed_speed(left, self._chair.limits, self._deceleration)


def _softplus(value: ca.SX) -> ca.SX:
    """A smooth max(0, value): w log(1 + exp(value / w)), in a form that does not overflow."""
    return ca.fmax(value, 0.0) + _SOFTPLUS_WIDTH * ca.log1p(ca.exp(-ca.fabs(value) / _SOFTPLUS_WIDTH))


def _rounded_abs(value: ca.SX) -> ca.SX:
    return ca.sqrt(value**2 + _ROUNDING**2)
