"""Buffered odometry: where the chair was at any recent time, and how far it had driven by then."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import arc_step, compose, relative

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Odometry:
    """One odometry message: base_link in odom, and the speeds in base_link."""

    stamp: float  # [s]
    pose: Array  # (3,) [m, m, rad]
    v: float  # [m/s]
    omega: float  # [rad/s]

    def is_finite(self) -> bool:
        """Whether every number is finite."""
        return all(math.isfinite(value) for value in [self.stamp, *self.pose, self.v, self.omega])


@dataclass(frozen=True)
class Instant:
    """The chair at one time."""

    stamp: float
    pose: Array  # base_link in odom
    v: float
    omega: float
    driven: float  # way driven since the buffer began [m]
    turned: float  # angle turned since then, both ways added up [rad]


class OdometryBuffer:
    """Keeps `duration` seconds of odometry and interpolates between the messages."""

    def __init__(self, duration: float, max_extrapolation: float) -> None:
        self._duration, self._max_extrapolation = duration, max_extrapolation
        self._samples: deque[Instant] = deque()

    def clear(self) -> None:
        """Forget everything."""
        self._samples.clear()

    def add(self, odometry: Odometry) -> bool:
        """Take a message; false (and not taken) when it is not finite or not newer than the last one."""
        if not odometry.is_finite():
            return False
        driven = turned = 0.0
        if self._samples:
            last = self._samples[-1]
            if odometry.stamp <= last.stamp:
                return False
            step = relative(last.pose, odometry.pose)
            driven = last.driven + math.hypot(step[0], step[1])
            turned = last.turned + abs(step[2])
        pose = np.asarray(odometry.pose, dtype=float)
        self._samples.append(Instant(odometry.stamp, pose, odometry.v, odometry.omega, driven, turned))
        while self._samples[0].stamp < odometry.stamp - self._duration:
            self._samples.popleft()
        return True

    @property
    def newest(self) -> Instant | None:
        """The last message."""
        return self._samples[-1] if self._samples else None

    def at(self, stamp: float) -> Instant | None:
        """The chair at `stamp`; None outside the buffer (a little ahead of it the last speeds are carried on)."""
        if not self._samples or not math.isfinite(stamp) or stamp < self._samples[0].stamp:
            return None
        newest = self._samples[-1]
        if stamp >= newest.stamp:
            return _ahead(newest, stamp) if stamp - newest.stamp <= self._max_extrapolation else None
        after = newest
        for before in reversed(self._samples):
            if before.stamp <= stamp:
                return _between(before, after, stamp)
            after = before
        return None


def _ahead(last: Instant, stamp: float) -> Instant:
    duration = stamp - last.stamp
    pose = arc_step(last.pose, last.v, last.omega, duration)
    driven, turned = last.driven + abs(last.v) * duration, last.turned + abs(last.omega) * duration
    return Instant(stamp, pose, last.v, last.omega, driven, turned)


def _between(before: Instant, after: Instant, stamp: float) -> Instant:
    share = (stamp - before.stamp) / (after.stamp - before.stamp)
    pose = compose(before.pose, share * relative(before.pose, after.pose))

    def mix(first: float, second: float) -> float:
        return first + share * (second - first)

    return Instant(
        stamp,
        pose,
        mix(before.v, after.v),
        mix(before.omega, after.omega),
        mix(before.driven, after.driven),
        mix(before.turned, after.turned),
    )
