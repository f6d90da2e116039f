"""Obstacles that others report: checked once, held in odom or with the dock, given to the controller every cycle."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.se2 import inverse, transform_points
from seater_common.separation import convex_outline

Array = NDArray[np.float64]


_THIN = 0.025 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])  # [m] round a point or line


_MOST = (100, 10_000)  # polygons, corners of all of them: with more a control cycle would come too late


def usable_outlines(polygons: Iterable[ArrayLike]) -> tuple[list[Array], list[str]]:
    """The convex hulls (n, 2) of the polygons, and a complaint (index: reason) about each one that says no place.

    A point or a line stands for a thin thing. Of more than a control cycle has time for none is taken.
    """
    given = [np.asarray(polygon, dtype=float).reshape(-1, 2) for polygon in polygons]
    size = len(given), sum(len(corners) for corners in given)
    if size[0] > _MOST[0] or size[1] > _MOST[1]:
        return [], [
            f"{size[0]} polygons with {size[1]} corners, at most {_MOST[0]} with {_MOST[1]} can be kept clear of"
        ]
    outlines, complaints = [], []
    for index, corners in enumerate(given):
        try:
            outlines.append(_outline(corners))
        except ValueError as error:
            complaints.append(f"polygon {index}: {error}")
    return outlines, complaints


def _outline(corners: Array) -> Array:
    """Raises ValueError: no corners, not finite, or so far away that a thin thing has no area."""
    if not len(corners) or not np.all(np.isfinite(corners)):
        raise ValueError("has no corners, or one that is not finite")
    try:
        return convex_outline(corners)
    except ValueError:
        return convex_outline((corners[:, None] + _THIN).reshape(-1, 2))


class ObstacleMemory:
    """The obstacles that count now. When the dock's estimate moves, those in odom stay and those of the dock follow."""

    def __init__(self, timeout: float) -> None:
        """`timeout` [s]: how long they may be without news; 0: for ever."""
        self._timeout = timeout
        self._outlines: list[Array] = []
        self._bound_to_dock = False
        self._since: float | None = None
        self._told = False

    def replace(self, outlines: list[Array], *, bound_to_dock: bool) -> None:
        """Forget those before; outlines (n, 2) [m] in the dock's frame (`bound_to_dock`) or in odom."""
        self._outlines, self._bound_to_dock, self._since = list(outlines), bound_to_dock, None
        self._told = True

    def leave_dock(self, T_odom_dock: ArrayLike | None) -> None:
        """Another dock is looked for: what was bound to the one before stays where it is, as far as that is known."""
        if not self._bound_to_dock:
            return
        self._bound_to_dock, bound = False, self._outlines
        self._outlines = [] if T_odom_dock is None else [transform_points(T_odom_dock, outline) for outline in bound]

    def stale(self, now: float) -> bool:
        """Whether what was told is older than the time-out at message time `now` [s]; it holds all the same.

        The age counts from the first call after `replace`, and anew when time goes backward.
        """
        if not self._told:
            return False
        if self._since is None or now < self._since:
            self._since = now
        return 0.0 < self._timeout < now - self._since

    def in_dock(self, T_odom_dock: ArrayLike | None) -> list[Array]:
        """Outlines (n, 2) in the dock's frame; none of those in odom while the dock is not known (None)."""
        if self._bound_to_dock:
            return self._outlines
        if T_odom_dock is None:
            return []
        T_dock_odom = inverse(T_odom_dock)
        return [transform_points(T_dock_odom, outline) for outline in self._outlines]
