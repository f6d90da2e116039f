"""Charging contact and walls: what the chair touches."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Bay, Chair, Dock, clearance, polygon_distance
from seater_sim.settings import ContactSettings

Array = NDArray[np.float64]


class ChargingContact:
    """Closes when the chair stands within the dock's contact_tolerance; opens as soon as it is outside."""

    def __init__(self, settings: ContactSettings, dock: Dock) -> None:
        self._settings = settings
        self._dock, self._tolerance = dock, dock.contact_tolerance
        self.closed = False

    def update(self, pose: ArrayLike, v: float, omega: float) -> bool:
        """The contact for the true pose (x, y, heading) in the dock frame and the true speeds."""
        x, y, heading = self._dock.docking_error(pose)
        tolerance = self._tolerance
        inside = math.hypot(x, y) <= tolerance.position and abs(heading) <= tolerance.heading
        slow = abs(v) <= self._settings.max_speed and abs(omega) <= self._settings.max_omega
        self.closed = inside and (self.closed or slow)
        return self.closed


class Walls:
    """Distance of the chair's footprint from the bay's walls and the obstacles."""

    def __init__(self, chair: Chair, bay: Bay, obstacles: list[Array]) -> None:
        """`obstacles`: convex polygons, (n, 2) [m] each, anticlockwise, in the dock frame."""
        self._chair = chair
        self._bay = bay
        self._obstacles = obstacles
        self._reach = float(np.max(np.linalg.norm(chair.corners(), axis=1)))
        middles = [outline.mean(axis=0) for outline in obstacles]
        # Circle around each: x, y, radius.
        self._circles = [
            (float(x), float(y), float(np.max(np.linalg.norm(outline - [x, y], axis=1))))
            for outline, (x, y) in zip(obstacles, middles, strict=True)
        ]
        # All walls lie along the axes: (x0, x1, y0, y1) of each.
        corners = [(wall.min(axis=0).tolist(), wall.max(axis=0).tolist()) for wall in bay.outlines()]
        self._boxes = [(low[0], high[0], low[1], high[1]) for low, high in corners]

    def distance(self, pose: ArrayLike) -> float:
        """Smallest distance [m]; negative when something overlaps. Obstacles whose circle is farther than what was
        nearest so far are skipped."""
        return self._to_obstacles(pose, clearance(self._chair, self._bay, pose))

    def _to_obstacles(self, pose: ArrayLike, nearest: float) -> float:
        """The smaller one of `nearest` [m] and the distance of the obstacles."""
        if not self._obstacles:
            return nearest
        corners, (px, py, _) = self._chair.corners_at(pose), np.asarray(pose, dtype=float).tolist()
        for outline, (x, y, radius) in zip(self._obstacles, self._circles, strict=True):
            if math.hypot(x - px, y - py) - radius - self._reach < nearest:
                nearest = min(nearest, polygon_distance(corners, outline))
        return nearest

    def distance_if_free(self, pose: Array) -> float:
        """As `distance`, an order of magnitude faster, for a chair that reached `pose` by a small step from free
        ground.

        Two convex polygons that do not overlap are nearest at a corner of one of them; when a corner lies in the other
        one, the exact function decides.
        """
        chair = self._chair
        x, y, c, s = float(pose[0]), float(pose[1]), math.cos(pose[2]), math.sin(pose[2])
        front, rear, half = chair.length_front, -chair.length_rear, 0.5 * chair.width
        corners = [
            (x + c * a - s * b, y + s * a + c * b)
            for a, b in ((front, half), (rear, half), (rear, -half), (front, -half))
        ]
        nearest = math.inf
        for x0, x1, y0, y1 in self._boxes:
            for px, py in corners:
                nearest = min(nearest, _from_box(px, py, x0, x1, y0, y1))
            for wx, wy in ((x0, y0), (x1, y0), (x1, y1), (x0, y1)):
                dx, dy = wx - x, wy - y
                nearest = min(nearest, _from_box(c * dx + s * dy, c * dy - s * dx, rear, front, -half, half))
        return self.distance(pose) if nearest == 0.0 else self._to_obstacles(pose, math.sqrt(nearest))


def _from_box(x: float, y: float, x0: float, x1: float, y0: float, y1: float) -> float:
    """Squared distance of a point from an axis-aligned box; 0 inside."""
    dx = x0 - x if x < x0 else (x - x1 if x > x1 else 0.0)
    dy = y0 - y if y < y0 else (y - y1 if y > y1 else 0.0)
    return dx * dx + dy * dy


class CollisionMonitor:
    """Smallest clearance of a run, and whether a step ran into something."""

    # Farther away than NEAR the clearance is computed only after having come closer by COARSE [m]; nearer, at every
    # step.
    NEAR = 0.3
    COARSE = 0.01

    def __init__(self, walls: Walls, pose: Array, reach: float) -> None:
        """`reach`: farthest point of the footprint from base_link [m]."""
        self._walls = walls
        self._reach = reach
        self.clearance = walls.distance(pose)  # at the last look, less the way since then: a lower bound
        self.smallest = self.clearance
        self.touching = False
        self.collisions = 0

    def blocks(self, pose: Array, way: float, turn: float) -> bool:
        """True when the step to `pose` runs into something; the caller then takes the step back."""
        before = self.clearance
        bound = before - abs(way) - abs(turn) * self._reach
        if bound > max(self.NEAR, self.smallest - self.COARSE):
            self.clearance = bound
            self.touching = False
            return False
        after = self._walls.distance_if_free(pose)  # steps that overlap are taken back, so the way here was free
        if after < 0.0:
            self.collisions += not self.touching
            self.touching = True
            self.smallest = min(self.smallest, 0.0)
            return True
        self.clearance = after
        self.smallest = min(self.smallest, after)
        self.touching = self.touching and after <= before
        return False
