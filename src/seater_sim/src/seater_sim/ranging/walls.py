"""Rays against upright walls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Dock
from seater_sim.settings import Obstacle, Walker
from seater_sim.world.scene import ROOM_HALF, ROOM_HEIGHT

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Walls:
    """Upright faces on the floor in the dock frame: m of them."""

    a: Array  # (m, 2) [m], one end
    b: Array  # (m, 2), the other
    height: Array  # (m,)

    def __add__(self, other: Walls) -> Walls:
        return Walls(np.vstack([self.a, other.a]), np.vstack([self.b, other.b]), np.append(self.height, other.height))


def prism(polygon: Array, height: float) -> Walls:
    """The sides of an upright prism over a polygon (n, 2)."""
    return Walls(polygon, np.roll(polygon, -1, axis=0), np.full(len(polygon), height))


def standing(dock: Dock, obstacles: list[Obstacle]) -> Walls:
    """The room, the bay and the obstacles."""
    far = dock.bay.back_wall_x + 1.2
    near = dock.bay.back_wall_x - 2.0 * ROOM_HALF
    room = np.array([[near, -ROOM_HALF], [far, -ROOM_HALF], [far, ROOM_HALF], [near, ROOM_HALF]])
    walls = prism(room, ROOM_HEIGHT)
    for outline in dock.bay.outlines():
        walls += prism(outline, dock.bay.wall_height)
    for obstacle in obstacles:
        walls += prism(obstacle.polygon(), obstacle.height)
    return walls


def walking(walkers: list[Walker], positions: Array) -> Walls:
    """Who walks, at these positions (n, 2) [m]."""
    walls = Walls(np.empty((0, 2)), np.empty((0, 2)), np.empty(0))
    for walker, position in zip(walkers, positions, strict=True):
        walls += prism(position + walker.polygon(0.0) - walker.position(0.0), walker.height)
    return walls


def cast(origin: Array, directions: Array, walls: Walls) -> Array:
    """How far each ray gets, in lengths of its direction: (n,), infinite where it meets nothing.

    `origin` (3,) [m] and `directions` (n, 3) in the dock frame. Walls are met from both sides; the floor is met too.
    """
    edges, offsets = walls.b - walls.a, walls.a - origin[:2]
    dx, dy, dz = directions[:, 0, None], directions[:, 1, None], directions[:, 2, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = dx * edges[:, 1] - dy * edges[:, 0]
        t = (offsets[:, 0] * edges[:, 1] - offsets[:, 1] * edges[:, 0]) / crossing
        along = (offsets[:, 0] * dy - offsets[:, 1] * dx) / crossing
        z = origin[2] + t * dz
        met = (t > 0.0) & (along >= 0.0) & (along <= 1.0) & (z >= 0.0) & (z <= walls.height)
        floor = np.where(directions[:, 2] < 0.0, -origin[2] / directions[:, 2], np.inf)
    return np.minimum(np.where(met, t, np.inf).min(axis=1), floor)
