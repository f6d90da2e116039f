"""Buffered odometry: where the chair was at any recent time, and how it had driven by then."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.observe.odometry.instant import Instant, ahead, between
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.observe.odometry.pose_noise import noise, places
from seater_nmpc.observe.odometry.travel import NO_TRAVEL, step
from seater_nmpc.observe.odometry.twist import TwistCheck

Array = NDArray[np.float64]

_LONGER = 4.0  # times as long a time is looked at, where the poses are noisy
_MOST_JUMPS = 10  # that are counted
_JUMP = (0.2, 5.0, 0.5, 6.0)  # [m, m/s, rad, rad/s] beyond a way, and a speed, no chair has moved from pose to pose
_PERIOD_GAIN = 0.1  # weight of the newest message in the usual period


class OdometryBuffer:
    """Keeps `duration` seconds of odometry and interpolates between the messages."""

    def __init__(self, duration: float, max_extrapolation: float) -> None:
        self._duration, self._max_extrapolation = duration, max_extrapolation
        self._samples: deque[Instant] = deque()
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._samples.clear()
        self.period = 0.0  # [s] usual time between two messages, once there are two
        self._twist = TwistCheck()
        self._jumps: deque[float] = deque(maxlen=_MOST_JUMPS)  # stamps of poses that no chair reached from the last one
        self._asked: tuple[float, Instant | None] | None = None  # the last question to `at`, and the answer

    def add(self, odometry: Odometry) -> bool:
        """Take a message; false (and not taken) when it is not finite or not newer than the last one."""
        if not odometry.is_finite():
            return False
        pose, travel = np.asarray(odometry.pose, dtype=float), NO_TRAVEL
        if self._samples:
            last = self._samples[-1]
            if odometry.stamp <= last.stamp:
                return False
            duration = odometry.stamp - last.stamp
            travel = last.travel.plus(step(last.pose, pose, duration))
            if _jumps(last.pose, pose, duration):
                self._jumps.append(odometry.stamp)
            self.period = duration if self.period == 0.0 else self.period + _PERIOD_GAIN * (duration - self.period)
        v, omega = self._twist.speeds(odometry)
        self._asked = None
        self._samples.append(Instant(odometry.stamp, pose, v, omega, travel))
        while self._samples[0].stamp < odometry.stamp - self._duration:
            self._samples.popleft()
        return True

    @property
    def newest(self) -> Instant | None:
        """The last message."""
        return self._samples[-1] if self._samples else None

    def jumps_since(self, stamp: float) -> int:
        """How often the pose has jumped since `stamp` [s] (ten are counted)."""
        return sum(jump > stamp for jump in self._jumps)

    def mean_speeds(self, duration: float, sd: float = math.inf) -> tuple[float, float] | None:
        """(v [m/s], omega [rad/s]) over the last `duration` [s] by the poses, as far as they reach back.

        Where noise of the poses (odometry by a laser scan or by images) leaves that less certain than the standard
        deviation `sd` [m/s, rad/s], the line that fits them best over a longer time.
        """
        if len(self._samples) < 2:
            return None
        newest = self._samples[-1]
        last = self._since(newest.stamp - duration)
        elapsed = newest.stamp - last[0].stamp
        if math.isfinite(sd) and math.sqrt(2.0) * noise(places(last, newest)) > sd * elapsed:
            last = self._since(newest.stamp - _LONGER * duration)
            times = np.array([sample.stamp - newest.stamp for sample in last])
            speeds = np.polyfit(times, places(last, newest), 1)[0]
        else:
            speeds = -places(last[:1], newest)[0] / elapsed
        return float(speeds[0]), float(speeds[1])

    def _since(self, stamp: float) -> list[Instant]:
        """The messages from the last one at or before `stamp` [s] on; all, where none is as old."""
        kept: list[Instant] = []
        for sample in reversed(self._samples):
            kept.append(sample)
            if sample.stamp <= stamp:
                break
        return kept[::-1]

    def at(self, stamp: float) -> Instant | None:
        """The chair at `stamp`; None outside the buffer (a little ahead of it the last speeds are carried on)."""
        if self._asked is None or self._asked[0] != stamp:  # several ask for one time in a cycle
            self._asked = stamp, self._at(stamp)
        return self._asked[1]

    def _at(self, stamp: float) -> Instant | None:
        if not self._samples or not math.isfinite(stamp) or stamp < self._samples[0].stamp:
            return None
        newest = self._samples[-1]
        if stamp == newest.stamp:
            return newest
        if stamp > newest.stamp:
            return ahead(newest, stamp) if stamp - newest.stamp <= self._max_extrapolation else None
        after = newest
        for before in reversed(self._samples):
            if before.stamp <= stamp:
                return between(before, after, stamp)
            after = before
        return None


def _jumps(before: Array, after: Array, duration: float) -> bool:
    way, turn = math.dist(before[:2], after[:2]), abs(math.remainder(float(after[2] - before[2]), 2.0 * math.pi))
    return way > _JUMP[0] + _JUMP[1] * duration or turn > _JUMP[2] + _JUMP[3] * duration
