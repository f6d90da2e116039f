"""What a sensor sees and the chair need not keep clear of: itself, and the dock that it drives into."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair, Dock, Marker
from seater_common.se2 import inverse, transform_points

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SHEET = 0.5  # times its side: the margin of a marker's sheet or board


def is_chair(points: Array, chair: Chair, margin: float) -> Mask:
    """(n,) of points (n, 2) [m] in base_link: within the footprint and `margin` [m]."""
    x, y = points[:, 0], points[:, 1]
    along = (x >= -chair.length_rear - margin) & (x <= chair.length_front + margin)
    return np.asarray(along & (np.abs(y) <= 0.5 * chair.width + margin))


class DockShape:
    """The dock's side walls, back wall and boards of markers as convex outlines in its frame."""

    def __init__(self, dock: Dock, margin: float) -> None:
        """`margin` [m]: a point so near to one of them is the dock."""
        outlines = [*dock.bay.outlines(), *(_board(marker) for marker in dock.markers)]
        self._edges = [_half_planes(outline) for outline in outlines]
        self._margin = margin

    def contains(self, points: Array, T_odom_dock: ArrayLike) -> Mask:
        """(n,) of points (n, 2) [m] in odom."""
        local = transform_points(inverse(T_odom_dock), points)
        inside = np.zeros(len(local), dtype=bool)
        for normals, offsets in self._edges:
            inside |= np.all(local @ normals.T <= offsets + self._margin, axis=1)
        return inside


def _board(marker: Marker) -> Array:
    """The floor below a marker's board, anticlockwise; it has no thickness of its own."""
    T, half = marker.T_dock_marker(), marker.size * (0.5 + _SHEET)
    along, back = T[:2, 0], -1e-3 * T[:2, 2]
    left, right = T[:2, 3] - half * along, T[:2, 3] + half * along
    return np.array([left, right, right + back, left + back])


def _half_planes(outline: Array) -> tuple[Array, Array]:
    """Outward unit normals (k, 2) and offsets (k,) of a convex anticlockwise outline: inside is n . p <= offset."""
    edges = np.roll(outline, -1, axis=0) - outline
    normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.hypot(edges[:, 0], edges[:, 1])[:, None]
    if np.sum(outline[:, 0] * np.roll(outline[:, 1], -1) - outline[:, 1] * np.roll(outline[:, 0], -1)) < 0.0:
        normals = -normals
    return normals, np.sum(normals * outline, axis=1)
