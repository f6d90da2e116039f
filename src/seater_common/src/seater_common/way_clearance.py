"""The smallest clearance on a way of many poses."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Bay, Chair, clearance, polygon_distance
from seater_common.se2 import wrap_angle

Array = NDArray[np.float64]


def smallest_clearance(
    chair: Chair, bay: Bay, poses: Sequence[ArrayLike] | Array, obstacles: Sequence[Array] = ()
) -> float:
    """Over the poses (n, 3) of a way [m], from the bay's walls and the obstacles (convex polygons, (m, 2) each,
    anticlockwise); negative when something overlaps.

    A pose is skipped when the chair cannot have come nearer than the smallest so far: no point of it moves farther than
    the axle's way plus the turn times its distance from there. Raises IndexError without a pose.
    """
    reach = float(np.max(np.linalg.norm(chair.corners(), axis=1)))
    smallest, at_least = math.inf, -math.inf
    before = np.asarray(poses[0], dtype=float).tolist()
    for pose in poses:
        x, y, heading = np.asarray(pose, dtype=float).tolist()
        at_least -= math.hypot(x - before[0], y - before[1]) + abs(wrap_angle(heading - before[2])) * reach
        before = (x, y, heading)
        if at_least < smallest:
            at_least = _clearance(chair, bay, pose, obstacles)
            smallest = min(smallest, at_least)
    return smallest


def _clearance(chair: Chair, bay: Bay, pose: ArrayLike, obstacles: Sequence[Array]) -> float:
    corners = chair.corners_at(pose)
    return min([clearance(chair, bay, pose), *(polygon_distance(corners, outline) for outline in obstacles)])
