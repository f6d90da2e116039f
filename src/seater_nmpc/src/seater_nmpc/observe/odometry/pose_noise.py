"""How noisy the poses of an odometry are: one by a laser scan or by images is, one by wheels is not."""

from __future__ import annotations

import math
import statistics

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.observe.odometry.instant import Instant

Array = NDArray[np.float64]

_FEWEST = 5  # poses by which their noise can be told
_MEDIAN = 0.6745  # of the absolute value, times the standard deviation (normal distribution)


def places(samples: list[Instant], newest: Instant) -> Array:
    """(n, 2): how far along the newest heading [m], and which way [rad], the chair was, seen from where it is now."""
    x, y, heading = newest.pose.tolist()
    c, s = math.cos(heading), math.sin(heading)
    return np.array(
        [
            (c * (each.pose[0] - x) + s * (each.pose[1] - y), math.remainder(each.pose[2] - heading, 2.0 * math.pi))
            for each in samples
        ]
    )


def noise(placed: Array) -> float:
    """Standard deviation of the white noise in `placed` (n, 2) [m, rad], the larger one: what no even motion explains,
    by the median of the second differences, whose variance is six times the noise's."""
    if len(placed) < _FEWEST:
        return 0.0
    second = np.abs(placed[2:] - 2.0 * placed[1:-1] + placed[:-2])
    typical = max(statistics.median(column) for column in second.T.tolist())
    return typical / (_MEDIAN * math.sqrt(6.0))
