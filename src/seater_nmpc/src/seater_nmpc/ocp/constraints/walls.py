"""Walls that end nowhere: half-planes that no corner of the footprint may enter."""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair
from seater_nmpc.ocp.constraints.interface import AreaConstraint, Slack, Stage
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import StageProgramme

Array = NDArray[np.float64]


@dataclass(frozen=True)
class HalfPlane:
    """The points p with normal . p > offset."""

    angle: float  # direction of the normal [rad]
    offset: float  # [m]

    def transformed(self, change: Array) -> HalfPlane:
        """See Area."""
        angle = self.angle + change[2]
        return HalfPlane(angle, self.offset + math.cos(angle) * change[0] + math.sin(angle) * change[1])

    def vector(self) -> list[float]:
        """(normal, offset), (3,)."""
        return [math.cos(self.angle), math.sin(self.angle), self.offset]


@dataclass(frozen=True)
class Walls:
    """Forbidden half-planes."""

    planes: tuple[HalfPlane, ...]

    def transformed(self, change: Array) -> Walls:
        """See Area."""
        return Walls(tuple(plane.transformed(change) for plane in self.planes))

    def constraint(self, chair: Chair, parameters: ControlParameters, programme: StageProgramme) -> WallConstraint:
        """See Area."""
        return WallConstraint(len(self.planes), parameters.margin, programme)


class WallConstraint(AreaConstraint[Walls]):
    """normal . V + margin <= offset for every corner V of the footprint."""

    slack = Slack.AREA

    def __init__(self, count: int, margin: float, programme: StageProgramme) -> None:
        """`margin` [m] that is kept from each of `count` half-planes."""
        super().__init__()
        self._count, self._margin = count, margin
        self._p, self._where = programme.parameter("walls", 3 * count)

    def margins(self, stage: Stage) -> list[ca.SX]:
        """See AreaConstraint."""
        planes = ca.reshape(self._p, 3, self._count)
        return [planes[2, i] - self._margin - stage.footprint @ planes[:2, i] for i in range(self._count)]

    def set_instance(self, area: Walls, p: Array, lower: Array, upper: Array) -> None:
        """See AreaConstraint."""
        p[self._where] = np.ravel([plane.vector() for plane in area.planes])
