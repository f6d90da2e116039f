"""Corners of side walls, kept clear of by a separating line whose angle is a variable of each stage."""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Bay, Chair
from seater_common.se2 import transform_points
from seater_nmpc.ocp.constraints.interface import AreaConstraint, Indices, Slack, Stage, columns
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import StageProgramme

Array = NDArray[np.float64]

_SCAN = 9  # angles that an initial guess is chosen from


@dataclass(frozen=True)
class Corner:
    """A convex corner of an obstacle: the obstacle lies behind both faces that meet in `point`.

    A line separates a convex footprint from it exactly when its normal (towards the chair) lies between the normals of
    the two faces and every corner V of the footprint has normal . (V - point) >= 0; so the line needs one number, its
    angle.
    """

    point: tuple[float, float]  # [m]
    first: float  # direction of the outward normal of one face [rad]
    last: float  # of the other face, anticlockwise from `first` by less than pi [rad]

    def transformed(self, change: Array) -> Corner:
        """See Area."""
        x, y = transform_points(change, [self.point])[0]
        return Corner((float(x), float(y)), self.first + change[2], self.last + change[2])


@dataclass(frozen=True)
class Corners:
    """Corners that each stand for all that lies behind them."""

    corners: tuple[Corner, ...]

    def transformed(self, change: Array) -> Corners:
        """See Area."""
        return Corners(tuple(corner.transformed(change) for corner in self.corners))

    def constraint(self, chair: Chair, parameters: ControlParameters, programme: StageProgramme) -> CornerConstraint:
        """See Area."""
        return CornerConstraint(len(self.corners), chair, parameters.margin, programme)


def side_wall_corners(bay: Bay) -> Corners:
    """Each side wall is taken with everything behind its end face and its inner face (the chair comes from the open
    side), so that one corner stands for it. In the dock's frame."""
    x, half = bay.entrance_x, 0.5 * bay.width
    left = Corner((x, half), first=-math.pi, last=-0.5 * math.pi)
    right = Corner((x, -half), first=0.5 * math.pi, last=math.pi)
    return Corners((left, right))


class CornerConstraint(AreaConstraint[Corners]):
    """(cos b, sin b) . (V - point) >= margin for each corner V of the footprint; b is free between both normals."""

    slack = Slack.AREA

    def __init__(self, count: int, chair: Chair, margin: float, programme: StageProgramme) -> None:
        """`margin` [m] that is kept from each of `count` corners."""
        super().__init__()
        self._count, self._chair, self._margin = count, chair, margin
        self._p, self._where = programme.parameter("corners", 2 * count)
        self._columns: Indices | None = None

    def add_variables(self, programme: StageProgramme) -> None:
        """See AreaConstraint: the angle of each separating line."""
        angles, where = programme.variable("beta", [-math.inf] * self._count, [math.inf] * self._count)
        self.symbols.append(angles)
        self.places.append(where)

    def margins(self, stage: Stage) -> list[ca.SX]:
        """See AreaConstraint."""
        angles, points = self.symbols[stage.index], self._points()
        normals = [ca.vertcat(ca.cos(angles[i]), ca.sin(angles[i])) for i in range(self._count)]
        return [
            stage.footprint @ normal - ca.dot(normal, points[:, i]) - self._margin for i, normal in enumerate(normals)
        ]

    def set_instance(self, area: Corners, p: Array, lower: Array, upper: Array) -> None:
        """See AreaConstraint."""
        p[self._where] = np.ravel([corner.point for corner in area.corners])
        if self._columns is None:
            self._columns = columns(self.places)
        lower[self._columns] = [corner.first for corner in area.corners]
        upper[self._columns] = [corner.last for corner in area.corners]

    def guess(self, area: Corners, states: Array, x: Array) -> None:
        """See AreaConstraint."""
        for where, pose in zip(self.places, states[1:, :3], strict=True):
            footprint = self._chair.corners_at(pose)
            x[where] = [separating_angle(footprint, corner) for corner in area.corners]

    def best(self, stage: Stage, lower: ca.SX, upper: ca.SX) -> ca.SX:
        """See AreaConstraint."""
        points, start, heading = self._points(), self.places[stage.index].start, stage.pose[2]
        return ca.vertcat(
            *(
                best_angle(
                    stage.footprint - ca.repmat(points[:, i].T, 4, 1), heading, lower[start + i], upper[start + i]
                )
                for i in range(self._count)
            )
        )

    def _points(self) -> ca.SX:
        return ca.reshape(self._p, 2, self._count)


def separating_angle(footprint: ArrayLike, corner: Corner) -> float:
    """Angle in [first, last] whose line has the footprint (4, 2) farthest ahead of it, from a coarse scan."""
    candidates = np.linspace(corner.first, corner.last, _SCAN)
    normals = np.column_stack([np.cos(candidates), np.sin(candidates)])
    ahead = normals @ (np.asarray(footprint) - np.asarray(corner.point)).T
    return float(candidates[np.argmax(np.min(ahead, axis=1))])


def best_angle(corners: ca.SX, heading: ca.SX, first: ca.SX, last: ca.SX) -> ca.SX:
    """The angle b in [first, last] with the largest min_i (cos b, sin b) . V_i; corners V (4, 2) seen from the point.

    It is one of: the ends of the range, the direction of a corner, the direction across a side of the footprint.
    """
    begin, end = (ca.vertcat(ca.cos(angle), ca.sin(angle)) for angle in (first, last))
    across = ca.vertcat(ca.cos(heading), ca.sin(heading))
    along = ca.vertcat(-across[1], across[0])
    directions = [corners[i, :].T / ca.sqrt(ca.sumsqr(corners[i, :]) + 1e-12) for i in range(4)]
    best, margin = begin, ca.mmin(corners @ begin)
    for normal in [end, *directions, across, -across, along, -along]:
        inside = ca.fmin(_cross(begin, normal), _cross(normal, end)) >= 0.0
        ahead = ca.if_else(inside, ca.mmin(corners @ normal), -math.inf)
        best = ca.if_else(ahead > margin, normal, best)
        margin = ca.fmax(ahead, margin)
    return ca.fmin(first + ca.acos(ca.fmax(-1.0, ca.fmin(1.0, ca.dot(begin, best)))), last)


def _cross(a: ca.SX, b: ca.SX) -> ca.SX:
    return a[0] * b[1] - a[1] * b[0]
