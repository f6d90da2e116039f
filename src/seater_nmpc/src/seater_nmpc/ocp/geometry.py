"""Where the chair must not be, in the form that the optimal control problem takes.

All arrays are in one frame (the dock's, or after `in_frame` another one's).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Dock
from seater_common.se2 import inverse, transform_points

Array = NDArray[np.float64]


@dataclass(frozen=True)
class HalfPlane:
    """Forbidden: points p with normal . p > offset."""

    angle: float  # direction of the normal [rad]
    offset: float  # [m]


@dataclass(frozen=True)
class Corner:
    """A convex corner of an obstacle: the obstacle lies behind both faces that meet in `point`.

    A line parts a convex footprint from it exactly when its normal (towards the chair) lies between the normals of the
    two faces and every corner V of the footprint has normal . (V - point) >= 0; so the line needs one number, its angle.
    """

    point: tuple[float, float]  # [m]
    first: float  # direction of the outward normal of one face [rad]
    last: float  # of the other face, anticlockwise from `first` by less than pi [rad]


@dataclass(frozen=True)
class Areas:
    """Prohibited areas, the line behind which the bay begins (not to be crossed fast), and what is to be kept in view."""

    half_planes: tuple[HalfPlane, ...]
    corners: tuple[Corner, ...]
    entrance: HalfPlane
    # The leftmost and the rightmost marker (of whoever comes): one of them at least is to stay in the camera's view [m].
    view: tuple[tuple[float, float], tuple[float, float]] = ((0.0, 0.0), (0.0, 0.0))

    def in_frame(self, pose: ArrayLike) -> Areas:
        """The same areas seen from the frame that has this pose (x, y, heading)."""
        change = inverse(pose)
        return Areas(
            tuple(_plane_in(change, plane) for plane in self.half_planes),
            tuple(_corner_in(change, corner) for corner in self.corners),
            _plane_in(change, self.entrance),
            (_point_in(change, self.view[0]), _point_in(change, self.view[1])),
        )


def dock_areas(dock: Dock) -> Areas:
    """The bay's walls and the outermost markers, in the dock's frame.

    Each side wall is taken with everything behind its end face and its inner face (the chair comes from the open side),
    so that one corner stands for it.
    """
    bay = dock.bay
    aside = sorted((marker.position[1], marker.position[0]) for marker in dock.markers)
    view = (aside[-1][1], aside[-1][0]), (aside[0][1], aside[0][0])
    x, half = bay.entrance_x, 0.5 * bay.width
    left = Corner((x, half), first=-math.pi, last=-0.5 * math.pi)
    right = Corner((x, -half), first=0.5 * math.pi, last=math.pi)
    return Areas((HalfPlane(0.0, bay.back_wall_x),), (left, right), HalfPlane(0.0, x), view)


def _plane_in(change: Array, plane: HalfPlane) -> HalfPlane:
    angle = plane.angle + change[2]
    return HalfPlane(angle, plane.offset + math.cos(angle) * change[0] + math.sin(angle) * change[1])


def _corner_in(change: Array, corner: Corner) -> Corner:
    return Corner(_point_in(change, corner.point), corner.first + change[2], corner.last + change[2])


def _point_in(change: Array, point: tuple[float, float]) -> tuple[float, float]:
    x, y = transform_points(change, [point])[0]
    return float(x), float(y)
