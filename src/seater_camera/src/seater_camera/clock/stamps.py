"""The stamp of an image: when it was exposed, by ROS time. Never in the future, never backwards, never made up."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from enum import Enum

import numpy as np

from seater_camera.frames import Clock, Frame
from seater_camera.settings import ClockSettings
from seater_common.device_clock import DeviceClock

_TRIES = 3  # to read two clocks at once
_AT_ONCE = 20e-6  # [s] that the reading may take
_ROWS = 8  # every so manieth row is compared with the last image's


class Refusal(Enum):
    """Why a frame is not published."""

    REPEATED = "came twice"
    FROZEN = "is equal to the last in all pixels: the camera repeats it"
    OLD = "is too old"
    FUTURE = "is of the future: the camera's clock is wrong"
    BACKWARDS = "is not newer than the last: a clock was set back"
    NO_TIME = "has no time"


class RefusedError(Exception):
    """A frame must not be published."""

    def __init__(self, refusal: Refusal) -> None:
        super().__init__(refusal.value)
        self.refusal = refusal


class Stamper:
    """Gives stamps to frames of one source."""

    def __init__(
        self,
        settings: ClockSettings,
        *,
        steady: Callable[[], float] = time.monotonic,
        wall: Callable[[], float] = time.time,
    ) -> None:
        """`steady`: the clock of Frame.arrival and of the kernel [s]. `wall`: ROS time [s]."""
        self._settings, self._steady, self._wall = settings, steady, wall
        self._device = DeviceClock()
        self._stamp, self._seen = -math.inf, -math.inf  # last stamp; last frame's own time
        self._rows = np.empty(0, np.uint8)  # some of the last image
        self.clock: Clock | None = None  # of the last frame

    @property
    def device(self) -> DeviceClock:
        """How the device's clock is mapped, where it has one."""
        return self._device

    def connected(self, clock_period: float) -> None:
        """The source was opened: its clock may have begun anew; stamps go on after the last one."""
        restarts = self._device.restarts
        self._device = DeviceClock(clock_period)
        self._device.restarts = restarts
        self._seen = -math.inf

    def stamp(self, frame: Frame) -> float:
        """When the frame was exposed, by ROS time [s].

        Raises:
            RefusedError: it must not be published.
        """
        self.clock = frame.clock
        self._refuse_repeated(frame)
        offset = self._wall_minus_steady()
        taken = self._host_time(frame, offset) - self._settings.delay
        age = self._steady() - taken
        if not math.isfinite(age):
            raise RefusedError(Refusal.NO_TIME)
        if age < 0.0:
            raise RefusedError(Refusal.FUTURE)
        if age > self._settings.max_age:
            raise RefusedError(Refusal.OLD)
        stamp = taken + offset
        if stamp <= self._stamp or stamp > self._wall():  # the wall clock was set meanwhile
            raise RefusedError(Refusal.BACKWARDS)
        self._stamp = stamp
        return stamp

    def age(self, stamp: float) -> float:
        """Of a stamp, now [s]."""
        return self._wall() - stamp

    def _refuse_repeated(self, frame: Frame) -> None:
        seen = frame.arrival if frame.clock is Clock.ARRIVAL else frame.time
        repeated, self._seen = seen == self._seen, seen
        rows = frame.image[::_ROWS]
        frozen = np.array_equal(rows, self._rows)
        self._rows = rows.copy()
        if repeated:
            raise RefusedError(Refusal.REPEATED)
        if frozen:
            raise RefusedError(Refusal.FROZEN)

    def _host_time(self, frame: Frame, offset: float) -> float:
        """By the steady clock [s]."""
        if frame.clock is Clock.ARRIVAL:
            return frame.arrival
        if not math.isfinite(frame.time):
            raise RefusedError(Refusal.NO_TIME)
        if frame.clock is Clock.MONOTONIC:
            return frame.time
        if frame.clock is Clock.WALL:
            return frame.time - offset
        return self._device.to_host(frame.time, frame.arrival)

    def _wall_minus_steady(self) -> float:
        """[s]; both clocks are slewed alike (NTP), so it changes only when the wall clock is set."""
        best, least = 0.0, math.inf
        for _ in range(_TRIES):
            before, wall, after = self._steady(), self._wall(), self._steady()
            if after - before < least:
                best, least = wall - 0.5 * (before + after), after - before
            if least < _AT_ONCE:
                break
        return best
