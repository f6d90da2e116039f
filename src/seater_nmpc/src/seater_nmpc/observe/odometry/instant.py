"""The chair at one time, by its odometry; between two of them, and a little ahead of the last one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import arc_step, compose, relative
from seater_nmpc.observe.odometry.travel import Travel, step

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Instant:
    """The chair at one time."""

    stamp: float
    pose: Array  # base_link in odom
    v: float
    omega: float
    travel: Travel  # since the buffer began

    @property
    def driven(self) -> float:
        """Way driven since the buffer began, both ways added up [m]."""
        return self.travel.driven

    @property
    def turned(self) -> float:
        """Angle turned since then, both ways added up [rad]."""
        return self.travel.turned


def ahead(last: Instant, stamp: float) -> Instant:
    """At `stamp` [s], with the last speeds carried on."""
    pose = arc_step(last.pose, last.v, last.omega, stamp - last.stamp)
    return Instant(stamp, pose, last.v, last.omega, last.travel.plus(step(last.pose, pose, stamp - last.stamp)))


def between(before: Instant, after: Instant, stamp: float) -> Instant:
    """At `stamp` [s], on an arc at even speed."""
    fraction = (stamp - before.stamp) / (after.stamp - before.stamp)
    pose = compose(before.pose, fraction * relative(before.pose, after.pose))
    v = before.v + fraction * (after.v - before.v)
    omega = before.omega + fraction * (after.omega - before.omega)
    travel = before.travel.plus(after.travel.plus(before.travel, -1.0), fraction)
    return Instant(stamp, pose, v, omega, travel)
