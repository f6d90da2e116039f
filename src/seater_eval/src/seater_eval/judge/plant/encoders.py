"""Odometry messages from encoder ticks, as a driver with the nominal radius and track makes them."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from seater_eval.judge.plant.built import TRACK
from seater_eval.judge.plant.effects import Encoders
from seater_nmpc.observe.odometry.message import Odometry

_SHORTEST = 0.02  # [s] speeds are taken over at least so long: over 5 ms a tick would be 2 cm/s
_EPSILON = 1e-9  # [s]


class WheelOdometry:
    """Integrates ticks; `messages` hands out those that have arrived."""

    def __init__(
        self, settings: Encoders, start: float, origin: tuple[float, float, float], rng: np.random.Generator
    ) -> None:
        """`start` [s]: time of the first sample; `origin`: base_link in odom then."""
        self._settings, self._rng = settings, rng
        self._period = 1.0 / settings.rate
        self._begin, self._count = start, 0
        self.x, self.y, self.heading = origin
        self._ticks = [0, 0]
        self._past: deque[tuple[float, float, float]] = deque()  # time, way and turn until then
        self._way = self._turn = 0.0
        self._on_the_way: list[tuple[float, Odometry]] = []  # with the time of arrival

    def look(self, now: float, rolled: list[float]) -> None:
        """The wheels have `rolled` so far [m]: a sample is taken when it is time."""
        if now < self._begin + self._count * self._period - _EPSILON:
            return
        self._count += 1
        self._advance(now, rolled)
        late = self._rng.uniform(0.0, self._settings.jitter) if self._settings.jitter > 0.0 else 0.0
        before = [arrival for arrival, _ in self._on_the_way] if self._settings.ordered else []
        self._on_the_way.append((max([now + late, *before]), self._message(now)))

    def messages(self, now: float) -> list[Odometry]:
        """Those that have arrived by `now` [s] since the last call, in the order of their arrival."""
        arrived = sorted((e for e in self._on_the_way if e[0] <= now + _EPSILON), key=lambda entry: entry[0])
        self._on_the_way = [entry for entry in self._on_the_way if entry[0] > now + _EPSILON]
        return [message for _, message in arrived]

    def _advance(self, now: float, rolled: list[float]) -> None:
        tick = self._settings.tick
        ticks = [math.floor(way / tick) for way in rolled]
        left, right = ((new - old) * tick for new, old in zip(ticks, self._ticks, strict=True))
        self._ticks = ticks
        way, turn = 0.5 * (left + right), (right - left) / TRACK
        if self._settings.gyro_in_pose and self._past:
            turn += self._settings.gyro_bias * (now - self._past[-1][0])
        self.x += way * math.cos(self.heading + 0.5 * turn)
        self.y += way * math.sin(self.heading + 0.5 * turn)
        self.heading = math.remainder(self.heading + turn, 2.0 * math.pi)
        self._way, self._turn = self._way + way, self._turn + (right - left) / TRACK
        self._past.append((now, self._way, self._turn))
        while len(self._past) > 2 and now - self._past[1][0] >= _SHORTEST - _EPSILON:
            self._past.popleft()

    def _message(self, now: float) -> Odometry:
        then, way, turn = self._past[0]
        v = omega = 0.0
        if now > then:
            v, omega = (self._way - way) / (now - then), (self._turn - turn) / (now - then)
        omega += self._settings.gyro_bias
        if self._settings.zero_twist:
            v = omega = 0.0
        return Odometry(now, np.array([self.x, self.y, self.heading]), v, omega)
