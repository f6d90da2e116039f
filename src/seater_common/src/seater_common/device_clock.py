"""From a device's own clock to the host's, drift-free, out of arrival times alone."""

from __future__ import annotations

import itertools
import math
from collections import deque

Point = tuple[float, float]

_BIN = 1.0  # [s] of which the fastest arrival is kept
_BINS = 60  # that are kept: drift changes with temperature, within minutes
_SHORT = 8  # bins from which on the drift is estimated: less of them tell more of the jitter
_MAX_DRIFT = 500e-6  # of a quartz: 100e-6 for bad ones
_JUMP = 0.05  # [s] earlier than any drift allows: the device's clock has leapt ahead
_SETTLED = 60  # events in a row that are all late by more than _JUMP: the device's clock has stood or leapt back


class DeviceClock:
    """The line that lies below all points (device time, arrival) and nearest to them.

    An arrival is the time of the event plus a delay which is never below some least delay. So the points lie above a
    line, whose slope is the ratio of the clocks: the lower convex hull's edge at the points' mean (Zhang, Liu and Xia,
    "Clock synchronization algorithms for network measurements", INFOCOM 2002). What `to_host` returns contains the
    least delay, which nobody can see from one side.
    """

    def __init__(self, period: float = math.inf) -> None:
        """`period` [s]: the device's clock begins anew at 0 after it."""
        self._period, self.restarts = period, 0
        self._begin()

    def _begin(self) -> None:
        self._points: deque[Point] = deque(maxlen=_BINS)  # device time, arrival - device time
        self._bin, self._wraps = -math.inf, 0.0
        self._last, self._late = -math.inf, 0
        self._slope, self._offset = 0.0, math.nan  # arrival - device time = slope * (device time - origin) + offset
        self._origin = math.nan

    @property
    def drift(self) -> float:
        """How much faster than the device's the host's clock runs (1e-6: ppm)."""
        return self._slope

    def to_host(self, device: float, arrival: float) -> float:
        """Time of the event [s] by the host's clock, never later than `arrival`.

        Args:
            device: time of the event by the device's clock [s], as it came.
            arrival: by the host's clock [s].
        """
        time = self._unwrapped(device)
        if self._has_leapt(time, arrival):
            self._begin()
            self.restarts += 1
            time = device
        self._last = time
        self._add(time, arrival - time)
        return min(self._line(time), arrival)

    def _unwrapped(self, device: float) -> float:
        time = device + self._wraps
        if math.isfinite(self._period) and time < self._last - 0.5 * self._period:
            self._wraps += self._period
            time += self._period
        return time

    def _has_leapt(self, time: float, arrival: float) -> bool:
        if not self._points:
            return False
        delay = arrival - self._line(time)
        self._late = self._late + 1 if delay > _JUMP else 0
        return time < self._last or delay < -_JUMP or self._late >= _SETTLED

    def _add(self, time: float, difference: float) -> None:
        """`difference`: arrival - device time [s]. The slope is fitted once per bin, the line is lowered at once."""
        if not self._points:
            self._origin = time
        begins = math.floor(time / _BIN) != self._bin
        if begins:
            self._bin = math.floor(time / _BIN)
            self._points.append((time, difference))
        elif difference < self._points[-1][1]:
            self._points[-1] = (time, difference)
        if begins:
            self._fit()
        else:
            self._offset = min(self._offset, difference - self._slope * (time - self._origin))

    def _fit(self) -> None:
        points = list(self._points)
        slope = _lower_slope(points) if len(points) >= _SHORT else 0.0
        self._slope = min(max(slope, -_MAX_DRIFT), _MAX_DRIFT)
        self._offset = min(y - self._slope * (x - self._origin) for x, y in points)

    def _line(self, time: float) -> float:
        return time + self._slope * (time - self._origin) + self._offset


def _lower_slope(points: list[Point]) -> float:
    """Of the lower convex hull's edge below the mean of x; points (x, y) in ascending order of x."""
    hull: list[Point] = []
    for point in points:
        while len(hull) > 1 and _turns_right(hull[-2], hull[-1], point):
            hull.pop()
        hull.append(point)
    mean = sum(x for x, _ in points) / len(points)
    a, b = next((a, b) for a, b in itertools.pairwise(hull) if b[0] >= mean)
    return (b[1] - a[1]) / (b[0] - a[0])


def _turns_right(a: Point, b: Point, c: Point) -> bool:
    return (b[0] - a[0]) * (c[1] - a[1]) <= (b[1] - a[1]) * (c[0] - a[0])
