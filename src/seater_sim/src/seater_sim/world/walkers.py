"""Who walks about, and whether the chair touches him."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, polygon_distance
from seater_sim.settings import Walker

Array = NDArray[np.float64]


class Walkers:
    """They look at nothing: who comes to the chair stops only when he would nearly walk into it, and goes on when it
    has gone. So what overlaps has been run into by the chair."""

    def __init__(self, chair: Chair, walkers: list[Walker], reach: float) -> None:
        """`reach`: farthest point of the footprint from base_link [m]."""
        self._chair, self._walkers, self._reach = chair, walkers, reach
        self._walked = [0.0] * len(walkers)  # [s] of his way
        self._touching, self._last = False, 0.0
        self.touches = 0

    @property
    def positions(self) -> Array:
        """(n, 2) [m] in the dock frame."""
        places = [walker.position(walked) for walker, walked in zip(self._walkers, self._walked, strict=True)]
        return np.array(places).reshape(-1, 2)

    def update(self, pose: Array, elapsed: float) -> None:
        """The chair has moved to this true pose in the dock frame, `elapsed` [s] after the start of the run."""
        touching = any(self._gap(i, walked, pose) < 0.0 for i, walked in enumerate(self._walked))
        self.touches += touching and not self._touching
        self._touching = touching
        for i, walker in enumerate(self._walkers):
            begun = max(0.0, elapsed - max(self._last, walker.begin))
            then = min(self._walked[i] + begun, walker.duration)
            if self._gap(i, then, pose) >= min(walker.keeps, self._gap(i, self._walked[i], pose)):
                self._walked[i] = then
        self._last = elapsed

    def _gap(self, i: int, walked: float, pose: Array) -> float:
        """Between walker and footprint [m]; negative where they overlap, large where they are far apart."""
        walker = self._walkers[i]
        far = float(np.hypot(*(walker.position(walked) - pose[:2]))) - self._reach - walker.radius
        return far if far > walker.keeps else polygon_distance(self._chair.corners_at(pose), walker.polygon(walked))
