"""Where the chair may stand and turn."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_common.separation import edge_distances, footprints

Array = NDArray[np.float64]

FINAL_STRAIGHT = 0.3  # [m] of the way to the dock at least: on less, no lateral error is corrected any more


class FreeSpace:
    """Checks whole footprints against convex polygons."""

    def __init__(self, chair: Chair, margin: float) -> None:
        """`margin` [m] to keep."""
        self.margin = margin
        self._corners = chair.corners()
        self._reach = math.hypot(max(chair.length_front, chair.length_rear), 0.5 * chair.width) + margin

    def clear(self, poses: Array, polygons: list[Array]) -> NDArray[np.bool_]:
        """(n,) whether the footprint at each pose (n, 3) keeps the margin from the anticlockwise polygons."""
        result = np.ones(len(poses), dtype=bool)
        for polygon in polygons:
            low, high = polygon.min(axis=0) - self._reach, polygon.max(axis=0) + self._reach
            near = np.flatnonzero(np.all((poses[:, :2] > low) & (poses[:, :2] < high), axis=1))
            result[near] &= edge_distances(footprints(self._corners, poses[near]), polygon) >= self.margin
        return result


def final_straight_x(chair: Chair, dock: Dock) -> float:
    """The largest x of base_link [m] at which the chair may still turn: ahead of the side walls and, where these are
    short or missing, FINAL_STRAIGHT ahead of the dock."""
    return min(dock.bay.entrance_x - chair.length_front, -FINAL_STRAIGHT)
