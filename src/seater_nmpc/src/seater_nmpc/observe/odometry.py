"""Buffered odometry: where the chair was at any recent time, and how it had driven by then."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import arc_length, arc_step, compose, relative
from seater_nmpc.observe.twist import TwistCheck

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


@dataclass(frozen=True)
class Travel:
    """Sums over everything driven since the buffer began: what the drift of the odometry between two times depends on.

    ds and dt are the way (negative backward) and the turn of a short step that takes dtime, q = (1, x, y) with the
    chair's place in odom, c the unit vector of its direction there. All sums stand in one array: they are added up with
    every message and every estimate.
    """

    sums: Array  # (31,)

    def plus(self, other: Travel, fraction: float = 1.0) -> Travel:
        """This, and `fraction` of the other."""
        return Travel(self.sums + fraction * other.sums)

    @property
    def rows(self) -> Array:
        """(3, 3): the sums of q dt, of q ds and of q dtime."""
        return self.sums[:9].reshape(3, 3)

    @property
    def along(self) -> Array:
        """(2, 2) of c c' |ds|."""
        return self.sums[9:13].reshape(2, 2)

    @property
    def by_way(self) -> Array:
        """(3, 3) of q q' |ds|."""
        return self.sums[13:22].reshape(3, 3)

    @property
    def by_turn(self) -> Array:
        """(3, 3) of q q' |dt|."""
        return self.sums[22:31].reshape(3, 3)

    @property
    def driven(self) -> float:
        """Way driven, both ways added up [m]."""
        return float(self.sums[13])

    @property
    def turned(self) -> float:
        """Angle turned, both ways added up [rad]."""
        return float(self.sums[22])


NO_TRAVEL = Travel(np.zeros(31))


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


_LONGER = 4.0  # times as long a time is looked at, where the poses are noisy
_MOST_JUMPS = 10  # that are counted
_FEWEST = 5  # poses by which their noise can be told
_MEDIAN = 0.6745  # of the absolute value, times the standard deviation (normal distribution)
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
            travel = last.travel.plus(_step(last.pose, pose, duration))
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
        if math.isfinite(sd) and math.sqrt(2.0) * _noise(_places(last, newest)) > sd * elapsed:
            last = self._since(newest.stamp - _LONGER * duration)
            times = np.array([sample.stamp - newest.stamp for sample in last])
            speeds = np.polyfit(times, _places(last, newest), 1)[0]
        else:
            speeds = -_places(last[:1], newest)[0] / elapsed
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
            return _ahead(newest, stamp) if stamp - newest.stamp <= self._max_extrapolation else None
        after = newest
        for before in reversed(self._samples):
            if before.stamp <= stamp:
                return _between(before, after, stamp)
            after = before
        return None


def _places(samples: list[Instant], newest: Instant) -> Array:
    """(n, 2): how far along the newest heading [m], and which way [rad], the chair was, seen from where it is now."""
    x, y, heading = newest.pose.tolist()
    c, s = math.cos(heading), math.sin(heading)
    return np.array(
        [
            (c * (each.pose[0] - x) + s * (each.pose[1] - y), math.remainder(each.pose[2] - heading, 2.0 * math.pi))
            for each in samples
        ]
    )


def _noise(places: Array) -> float:
    """Standard deviation of the white noise in `places` [m, rad], the larger one: what no even motion explains, by the
    median of the second differences, whose variance is six times the noise's."""
    if len(places) < _FEWEST:
        return 0.0
    typical = np.median(np.abs(np.diff(places, n=2, axis=0)), axis=0)
    return float(typical.max()) / (_MEDIAN * math.sqrt(6.0))


def _jumps(before: Array, after: Array, duration: float) -> bool:
    way, turn = math.dist(before[:2], after[:2]), abs(math.remainder(float(after[2] - before[2]), 2.0 * math.pi))
    return way > _JUMP[0] + _JUMP[1] * duration or turn > _JUMP[2] + _JUMP[3] * duration


def _step(before: Array, after: Array, duration: float) -> Travel:
    """Of one short step, with the middle of the chord as its place."""
    chord_x, chord_y, turn = relative(before, after).tolist()
    way, (x, y) = arc_length(chord_x, chord_y, turn), (0.5 * (before[:2] + after[:2])).tolist()
    direction, size, turned = float(before[2]) + 0.5 * turn, abs(way), abs(turn)
    c, s = math.cos(direction), math.sin(direction)
    square = (1.0, x, y, x, x * x, x * y, y, y * x, y * y)  # q q'
    sums = [turn, turn * x, turn * y, way, way * x, way * y, duration, duration * x, duration * y]
    sums += [size * (c * c), size * (c * s), size * (s * c), size * (s * s)]
    return Travel(np.array(sums + [size * value for value in square] + [turned * value for value in square]))


def _ahead(last: Instant, stamp: float) -> Instant:
    pose = arc_step(last.pose, last.v, last.omega, stamp - last.stamp)
    return Instant(stamp, pose, last.v, last.omega, last.travel.plus(_step(last.pose, pose, stamp - last.stamp)))


def _between(before: Instant, after: Instant, stamp: float) -> Instant:
    fraction = (stamp - before.stamp) / (after.stamp - before.stamp)
    pose = compose(before.pose, fraction * relative(before.pose, after.pose))
    v = before.v + fraction * (after.v - before.v)
    omega = before.omega + fraction * (after.omega - before.omega)
    travel = before.travel.plus(after.travel.plus(before.travel, -1.0), fraction)
    return Instant(stamp, pose, v, omega, travel)
