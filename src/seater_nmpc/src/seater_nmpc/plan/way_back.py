"""Backing out of the bay, where as a rule no sensor looks: what was seen there last, and for how long it is waited for.

Poses: base_link in the dock's frame, of a chair that docks forward (see sequence/vehicle.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock, polygon_distances
from seater_common.se2 import inverse, transform_points, wrap_angle

Array = NDArray[np.float64]

_AHEAD = 0.3  # [m] of the way back that has to be clear: from 0.15 m/s the chair stops within 0.12
_PROGRESS, _TURN = 0.1, 0.2  # [m, rad] farther is getting on
_NEAR = 0.3  # [m] what is farther from the footprint does not explain why it gets nowhere
_ENDS = {"front": "rear", "rear": "front", "left side": "right side", "right side": "left side"}


class WayBack:
    """Restart it with each phase in which the chair backs out, then `update` it in each cycle."""

    def __init__(self, chair: Chair, dock: Dock, margin: float) -> None:
        """`margin` [m]: distance that the footprint keeps on its way straight back."""
        self._chair, self._turned = chair, dock.direction == "backward"
        half, rear = 0.5 * chair.width + margin, -chair.length_rear
        self._lane = np.array([[rear - _AHEAD, -half], [rear, -half], [rear, half], [rear - _AHEAD, half]])
        self.restart()

    def restart(self) -> None:
        """The chair begins to back out."""
        self._place: Array | None = None
        self._since = 0.0

    def update(self, now: float, here: Array) -> float:
        """For how long [s] the chair has got nowhere, at the time `now` [s] and the pose `here` (3,)."""
        place = self._place
        if place is None or math.dist(here[:2], place[:2]) > _PROGRESS or abs(wrap_angle(here[2] - place[2])) > _TURN:
            self._place, self._since = here, now
        return now - self._since

    def obstacle(self, here: Array, outlines: Sequence[Array]) -> str:
        """What stands in the next part of the straight way back, in words; empty: nothing."""
        lane = transform_points(here, self._lane)
        return self._nearest(here, [outline for outline in outlines if _distance(lane, outline) <= 0.0])

    def cause(self, here: Array, outlines: Sequence[Array]) -> str:
        """What stands so near that the chair may not get on, in words; empty: nothing."""
        footprint = self._chair.corners_at(here)
        return self._nearest(here, [outline for outline in outlines if _distance(footprint, outline) <= _NEAR])

    def _nearest(self, here: Array, outlines: Sequence[Array]) -> str:
        if not outlines:
            return ""
        footprint = self._chair.corners_at(here)
        distance, index = min((_distance(footprint, outline), i) for i, outline in enumerate(outlines))
        side = self._side(transform_points(inverse(here), outlines[index]))
        return f"something stands {max(0.0, distance):.2f} m from the chair's {_ENDS[side] if self._turned else side}"

    def _side(self, outline: Array) -> str:
        """Of the chair as it docks forward, where the outline (n, 2) in its base_link is."""
        if np.max(outline[:, 0]) < -self._chair.length_rear:
            return "rear"
        if np.min(outline[:, 0]) > self._chair.length_front:
            return "front"
        return "left side" if float(np.mean(outline[:, 1])) > 0.0 else "right side"


def _distance(shape: Array, outline: Array) -> float:
    return float(polygon_distances(shape, outline[None])[0])
