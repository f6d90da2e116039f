"""Cells of the floor where something stood when it was last seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.se2 import inverse, transform_points
from seater_obstacles.sight import View

Array = NDArray[np.float64]


class Memory:
    """Keeps things that stand while they are in a blind area; what is seen again, or seen through, is forgotten."""

    def __init__(self, duration: float, cell: float) -> None:
        """`duration` [s]: for how long at most. `cell` [m]: side of a cell; a measured distance may be two off."""
        self._duration, self._cell, self._tolerance = duration, cell, 2.0 * cell
        self._points, self._seen = np.empty((0, 2)), np.empty(0)

    def unseen(self, stamp: float, view: View, T_odom_base: ArrayLike) -> Array:
        """The remembered points (n, 2) [m] in odom that the view at `stamp` [s] neither confirms nor refutes."""
        recent = (stamp - self._seen <= self._duration) & (stamp >= self._seen)
        self._points, self._seen = self._points[recent], self._seen[recent]
        local = transform_points(inverse(T_odom_base), self._points)
        keep = ~view.sees(local, self._tolerance)
        self._points, self._seen = self._points[keep], self._seen[keep]
        return self._points

    def drop(self, which: NDArray[np.bool_]) -> None:
        """Forget these (n,) of the points that `unseen` gave."""
        self._points, self._seen = self._points[~which], self._seen[~which]

    def add(self, stamp: float, points: Array) -> None:
        """Remember points (n, 2) [m] in odom that are seen now, one in each cell."""
        points = np.vstack([points, self._points])
        seen = np.append(np.full(len(points) - len(self._points), stamp), self._seen)
        _, newest = np.unique(np.floor(points / self._cell), axis=0, return_index=True)  # the first of each cell
        self._points, self._seen = points[newest], seen[newest]
