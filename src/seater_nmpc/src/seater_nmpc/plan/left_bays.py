"""The walls of docks that the chair has left for another one: on the way there they are obstacles like others.

They are placed by odometry from where the dock was seen last, so they count near it only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Bay, Dock, polygon_distance
from seater_common.se2 import inverse, transform_points

Array = NDArray[np.float64]

_FAR = 5.0  # [m] from the dock, or driven since it was seen: odometry has drifted by the margins (1 to 2 % of the way)
_SAME_WALL = 0.05  # [m] from a wall of the dock in use: docks side by side share it, and its own dock knows it better


@dataclass(frozen=True)
class _Left:
    outlines: list[Array]  # (n, 2) in odom [m]
    at: Array  # (2,) the dock, in odom [m]


class LeftBays:
    """`leave` a dock for another one, then ask for the walls in each cycle. Poses: (x, y, heading) [m, m, rad]."""

    def __init__(self) -> None:
        self._left: dict[str, _Left] = {}

    def forget(self) -> None:
        """The odometry began anew."""
        self._left.clear()

    def leave(self, dock: Dock, T_odom_dock: ArrayLike, blind_distance: float) -> None:
        """The chair looks for another dock from now on; this one is there, seen `blind_distance` [m] ago."""
        outlines = [transform_points(T_odom_dock, outline) for outline in dock.bay.outlines()]
        if blind_distance <= _FAR:
            self._left[dock.name] = _Left(outlines, np.asarray(T_odom_dock, dtype=float)[:2])

    def use(self, dock: Dock) -> None:
        """The chair looks for this dock from now on, whose walls are known from its file."""
        self._left.pop(dock.name, None)

    def in_dock(self, bay: Bay, T_odom_dock: ArrayLike, T_odom_base: ArrayLike) -> list[Array]:
        """Outlines (n, 2) [m] in the frame of the dock in use, whose bay this is."""
        here = np.asarray(T_odom_base, dtype=float)[:2]
        self._left = {name: left for name, left in self._left.items() if math.dist(left.at, here) <= _FAR}
        T_dock_odom, own = inverse(T_odom_dock), bay.outlines()
        walls = [transform_points(T_dock_odom, outline) for left in self._left.values() for outline in left.outlines]
        return [wall for wall in walls if min(polygon_distance(wall, known) for known in own) > _SAME_WALL]
