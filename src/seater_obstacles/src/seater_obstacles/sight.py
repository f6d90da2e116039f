"""One measurement: the points that stand in the way, and what of the surroundings it has seen."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

FINEST = math.radians(0.5)  # [rad] of the bearings that are told apart
_NEARER = 0.3  # [m] by which what hides a thing is nearer than it


class View:
    """For bearings all round a sensor: from `near` to `free` [m] from it, nothing stands in the way.

    Bearings are those of base_link, counted from the sensor's place in it. What is nearer than `near`, farther than
    `free`, or at a bearing without a measurement is a blind area.
    """

    def __init__(self, origin: ArrayLike, bearings: Array, near: Array, free: Array, step: float = FINEST) -> None:
        """`origin` (2,) [m] in base_link; of n rays bearing [rad], near and free [m], not NaN; `step` [rad] between
        rays."""
        self.origin = np.asarray(origin, dtype=float)
        count = max(8, int(2.0 * math.pi / max(FINEST, 1.5 * abs(step))))
        self.near, self.free = np.zeros(count), np.full(count, np.inf)
        bins = self.bins(bearings)
        np.maximum.at(self.near, bins, near)
        np.minimum.at(self.free, bins, free)
        self.free[np.bincount(bins, minlength=count) == 0] = -np.inf

    def bins(self, bearings: Array) -> NDArray[np.intp]:
        """Indices (n,) into `near` and `free` of bearings (n,) [rad]."""
        count = len(self.free)
        return np.asarray(np.floor(np.asarray(bearings) * (count / (2.0 * math.pi))), dtype=np.intp) % count

    def sees(self, points: ArrayLike, tolerance: float) -> NDArray[np.bool_]:
        """Whether a thing at each of the points (n, 2) [m] in base_link would have been seen: (n,).

        A thing up to `tolerance` [m] behind what was measured is the same thing.
        """
        offsets = np.asarray(points, dtype=float).reshape(-1, 2) - self.origin
        distance, bins = np.hypot(offsets[:, 0], offsets[:, 1]), self.bins(np.arctan2(offsets[:, 1], offsets[:, 0]))
        return np.asarray((distance >= self.near[bins]) & (distance <= self.free[bins] + tolerance))

    def hides(self, points: ArrayLike) -> bool:
        """Whether a part of the thing at these points (n, 2) [m] in base_link may be out of sight: behind something
        nearer, or beside what is measured."""
        offsets = np.asarray(points, dtype=float).reshape(-1, 2) - self.origin
        distance, bins = np.hypot(offsets[:, 0], offsets[:, 1]), self.bins(np.arctan2(offsets[:, 1], offsets[:, 0]))
        beside = self.free[(bins[:, None] + np.arange(-2, 3)) % len(self.free)]
        return bool(np.any(beside < distance[:, None] - _NEARER))

    @property
    def blind(self) -> float:
        """Part of the full circle without any measurement, 0 .. 1."""
        return float(np.mean(np.isneginf(self.free)))


@dataclass(frozen=True)
class Sight:
    """What one measurement says."""

    points: Array  # (n, 2) [m] in base_link, of what stands in the way
    view: View
    met: int  # so many rays or pixels met something, be it floor, dock or the chair itself
