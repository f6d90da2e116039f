"""Whether the chair touches somebody who walks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, polygon_distance
from seater_sim.settings import Walker

Array = NDArray[np.float64]

_STANDS = (0.01, 0.02)  # [m/s, rad/s] a chair that is slower is walked into, it touches nobody


class Walkers:
    """Counts how often the moving chair has begun to touch one of them."""

    def __init__(self, chair: Chair, walkers: list[Walker], reach: float) -> None:
        """`reach`: farthest point of the footprint from base_link [m]."""
        self._chair, self._walkers, self._reach = chair, walkers, reach
        self._touching = False
        self.touches = 0

    def update(self, pose: Array, v: float, omega: float, elapsed: float) -> None:
        """The chair's true pose in the dock frame and speeds, `elapsed` [s] after the start of the run."""
        touching = any(self._near(w, pose, elapsed) and self._overlaps(w, pose, elapsed) for w in self._walkers)
        moving = abs(v) > _STANDS[0] or abs(omega) > _STANDS[1]
        self.touches += touching and moving and not self._touching
        self._touching = touching and (moving or self._touching)

    def _near(self, walker: Walker, pose: Array, elapsed: float) -> bool:
        return float(np.hypot(*(walker.position(elapsed) - pose[:2]))) <= self._reach + walker.radius

    def _overlaps(self, walker: Walker, pose: Array, elapsed: float) -> bool:
        return polygon_distance(self._chair.corners_at(pose), walker.polygon(elapsed)) < 0.0
