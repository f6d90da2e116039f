"""Tells the safety gate where the bay's walls are while a person drives, so that the joystick pushes nobody into them.

A docking keeps clear of the walls by itself, nearer than the gate would let it, so nothing is told meanwhile.
"""

from __future__ import annotations

import math

import numpy as np
import rospy
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Bay
from seater_common.se2 import relative, transform_points
from seater_msgs.msg import ObstaclePoints

Array = NDArray[np.float64]

SOURCE, FRAME = "bay", "base_link"
PERIOD = 0.1  # [s] of message time; the gate forgets after obstacle_timeout
SPACING = 0.04  # [m] between two points of a wall
_NEAR = 2.5  # [m] from base_link: more than a chair and its way to rest


class BayWalls:
    """Publishes `bay_walls` while the place of the dock is known."""

    def __init__(self) -> None:
        self._publisher = rospy.Publisher("bay_walls", ObstaclePoints, queue_size=1, tcp_nodelay=True)
        self._last, self._told = -math.inf, False  # [s] stamp of the last message; whether it told any wall

    def update(self, stamp: rospy.Time, bay: Bay, dock: ArrayLike | None, base: ArrayLike, *, docks: bool) -> None:
        """Once per control cycle. `dock` (None: not known, or seen too long ago) and `base`, base_link itself: (x, y,
        heading) in odom [m, m, rad]; `docks`: the docking node drives."""
        now, known = stamp.to_sec(), dock is not None and not docks
        if not known and not self._told:
            return
        if known and 0.0 <= now - self._last < PERIOD - 1e-6:
            return
        points = np.zeros((0, 2)) if dock is None or docks else wall_points(bay, relative(base, dock))
        message = ObstaclePoints(source=SOURCE, x=points[:, 0].tolist(), y=points[:, 1].tolist())
        message.header.stamp, message.header.frame_id = stamp, FRAME
        self._last, self._told = now, known
        self._publisher.publish(message)


def wall_points(bay: Bay, T_base_dock: ArrayLike) -> Array:
    """Points (n, 2) [m] in base_link along the outlines of the bay's walls, those near the chair."""
    points = np.concatenate([_along(outline) for outline in bay.outlines()])
    points = transform_points(T_base_dock, points)
    return np.asarray(points[np.hypot(points[:, 0], points[:, 1]) <= _NEAR])


def _along(outline: Array) -> Array:
    """(n, 2) along the sides of a closed polygon (k, 2), its corners among them."""
    sides = []
    for begin, end in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        count = max(1, math.ceil(math.dist(begin, end) / SPACING))
        sides.append(begin + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (end - begin))
    return np.concatenate(sides)
