"""From sights to what the chair has to keep clear of.

Of what moves the gate is told and the controller is not: to plan round somebody who walks would turn the chair away
from the dock; it waits until he has passed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair, Dock
from seater_common.se2 import inverse, transform_points
from seater_obstacles.clusters import clusters, outline, pieces, size, thinned
from seater_obstacles.exempt import DockShape, is_chair
from seater_obstacles.memory import Memory
from seater_obstacles.settings import ObstacleSettings
from seater_obstacles.sight import Sight, View
from seater_obstacles.tracks import Tracks

Array = NDArray[np.float64]

_STEP = 0.1  # [m] between the places on the way of a moving thing
_TOO_NEAR = (
    0.6  # [m] from the dock: there depth cameras may measure nothing at all, as their least distance is 0.2 to 0.6
)


@dataclass(frozen=True)
class Found:
    """What stands in the way."""

    outlines: list[Array]  # of what stands: convex, anticlockwise, (k, 2) [m] in odom, the nearest first
    points: Array  # (n, 2) [m] in base_link: all that is seen or remembered, and where moving things will be
    moving: int  # so many things move
    remembered: int  # so many of the points are in blind areas
    blind: float  # part of the full circle that is not seen, 0 .. 1


@dataclass(frozen=True)
class _Mover:
    points: Array  # (n, 2) [m] in odom
    velocity: Array  # (2,) [m/s]


class ObstacleFinder:
    """Tell it each sight, in the order of their stamps."""

    def __init__(self, settings: ObstacleSettings, chair: Chair, dock: Dock) -> None:
        self._settings, self._chair = settings, chair
        self.use_dock(dock)
        self._memory = Memory(settings.track.memory, settings.cluster.cell)
        self._ways = Memory(settings.track.lost, settings.cluster.cell)  # of moving things
        self._tracks = Tracks(settings.track)

    def use_dock(self, dock: Dock) -> None:
        """Another dock is exempted from now on."""
        self._shape = DockShape(dock, self._settings.sense.dock_margin)
        self._near = DockShape(dock, _TOO_NEAR)

    def near_dock(self, sight: Sight, T_odom_base: ArrayLike, T_odom_dock: ArrayLike | None) -> bool:
        """Whether the sensor stands so near to the dock that a depth camera may measure nothing; arguments as
        `update`'s."""
        place = transform_points(T_odom_base, sight.view.origin[None])
        return T_odom_dock is not None and bool(self._near.contains(place, T_odom_dock)[0])

    def update(self, stamp: float, sight: Sight, T_odom_base: ArrayLike, T_odom_dock: ArrayLike | None) -> Found:
        """What is in the way after the sight of `stamp` [s].

        Args:
            stamp: of the measurement; when it goes back, tracks and memory begin anew.
            sight: in base_link.
            T_odom_base: (x, y, heading) of the chair at the stamp.
            T_odom_dock: of the dock; None: not known, and then nothing is taken for the dock.
        """
        own = is_chair(sight.points, self._chair, self._settings.sense.self_margin)
        seen = transform_points(T_odom_base, sight.points[~own])
        if T_odom_dock is not None:
            seen = seen[~self._shape.contains(seen, T_odom_dock)]
        still, movers = self._told_apart(stamp, seen, sight.view, T_odom_base)
        old = self._remembered(self._memory, stamp, sight, T_odom_base, T_odom_dock)
        lost = self._remembered(self._ways, stamp, sight, T_odom_base, T_odom_dock)
        ways = np.vstack([np.empty((0, 2)), *(self._way(mover) for mover in movers)])
        self._memory.add(stamp, still)
        self._ways.add(stamp, ways)
        standing, T_base_odom = np.vstack([still, old]), inverse(T_odom_base)
        return Found(
            outlines=self._outlines(standing, T_base_odom),
            points=transform_points(T_base_odom, np.vstack([standing, ways, lost])),
            moving=len(movers),
            remembered=len(old) + len(lost),
            blind=sight.view.blind,
        )

    def _told_apart(self, stamp: float, seen: Array, view: View, T_odom_base: ArrayLike) -> tuple[Array, list[_Mover]]:
        """Points (n, 2) of what stands, and what moves; all in odom. Clusters of too few points are noise.

        The edge of a shadow moves though nothing does: what is partly hidden is not followed.
        """
        c, t = self._settings.cluster, self._settings.track
        cells, counts = thinned(seen, c.cell)
        groups = [cells[g] for g in clusters(cells, c.link) if counts[g].sum() >= c.min_points]
        T = inverse(T_odom_base)
        small = [g for g in groups if size(g) <= t.max_size and not view.hides(transform_points(T, g))]
        tracks = self._tracks.update(stamp, [0.5 * (g.min(axis=0) + g.max(axis=0)) for g in small])
        movers = [_Mover(g, k.velocity) for g, k in zip(small, tracks, strict=True) if k.moves(t.moving)]
        moving = {id(mover.points) for mover in movers}
        still = [g for g in groups if id(g) not in moving]
        return (np.vstack(still) if still else np.empty((0, 2))), movers

    def _remembered(
        self, memory: Memory, stamp: float, sight: Sight, T_odom_base: ArrayLike, T_odom_dock: ArrayLike | None
    ) -> Array:
        """Of this memory, in odom (n, 2): what lies in blind areas and is neither the chair nor the dock."""
        old = memory.unseen(stamp, sight.view, T_odom_base)
        wrong = is_chair(transform_points(inverse(T_odom_base), old), self._chair, 0.0)
        if T_odom_dock is not None:
            wrong |= self._shape.contains(old, T_odom_dock)
        memory.drop(wrong)
        return old[~wrong]

    def _way(self, mover: _Mover) -> Array:
        """Where its points (n, 2) are and will be."""
        way = self._settings.track.prediction * mover.velocity
        steps = np.linspace(0.0, 1.0, 1 + int(np.ceil(float(np.hypot(*way)) / _STEP)))
        return np.asarray(mover.points[None] + steps[:, None, None] * way).reshape(-1, 2)

    def _outlines(self, standing: Array, T_base_odom: Array) -> list[Array]:
        c = self._settings.cluster
        groups = [piece for g in clusters(standing, c.link) for piece in pieces(standing[g], c.max_length)]
        found = [outline(group, c.thickness) for group in groups]
        found.sort(key=lambda o: float(np.min(np.hypot(*transform_points(T_base_odom, o).T))))
        return found[: c.max_outlines]
