"""One odometry message."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_LARGEST = 1e10  # of [s], [m], [rad] and speeds: the seconds of ROS time and any map are below


@dataclass(frozen=True)
class Odometry:
    """One odometry message: base_link in odom, and the speeds in base_link."""

    stamp: float  # [s]
    pose: Array  # (3,) [m, m, rad]
    v: float  # [m/s]
    omega: float  # [rad/s]

    def is_finite(self) -> bool:
        """Whether every number is finite, and so small that sums of squares and products of them are."""
        return all(abs(value) <= _LARGEST for value in [self.stamp, *self.pose, self.v, self.omega])
