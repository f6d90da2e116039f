"""From commands to the speeds that the motors give: delay, deadband, ramp, lag."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from seater_eval.judge.plant.built import Built
from seater_eval.judge.plant.effects import Drive

_FRICTION = 0.002  # [m/s, rad/s] a motor without demand stands still below this speed
_KEEPS_GOING = 0.5  # share of the deadband above which an axis with stiction that moves goes on moving


class Deadband:
    """Of one axis. jump: beyond it the whole command acts; offset: what exceeds it; stiction: the whole command, which
    has to exceed the deadband to start the axis and half of it to keep it going."""

    def __init__(self, width: float, kind: str) -> None:
        self._width, self._kind, self._going = width, kind, False

    def through(self, command: float) -> float:
        """What is left of the command."""
        size = abs(command)
        threshold = self._width * (_KEEPS_GOING if self._kind == "stiction" and self._going else 1.0)
        self._going = size > threshold
        if not self._going:
            return 0.0
        return command - math.copysign(self._width, command) if self._kind == "offset" else command


class Axis:
    """Deadband, ramp and first-order lag of speed or turning."""

    def __init__(self, deadband: Deadband, ramp: float, lag: float) -> None:
        self._deadband, self._ramp, self._lag = deadband, ramp, lag
        self._wanted = self._demand = self.speed = 0.0

    def take(self, command: float) -> None:
        """A command begins to act."""
        self._wanted = self._deadband.through(command)

    def step(self, duration: float) -> float:
        """The speed after `duration` [s]."""
        change = self._wanted - self._demand
        if self._ramp > 0.0:
            change = max(-self._ramp * duration, min(self._ramp * duration, change))
        self._demand += change
        if self._lag > 0.0:
            self.speed += (1.0 - math.exp(-duration / self._lag)) * (self._demand - self.speed)
        else:
            self.speed = self._demand
        if self._demand == 0.0 and abs(self.speed) < _FRICTION:
            self.speed = 0.0
        return self.speed


class Motors:
    """Both axes behind the delay."""

    def __init__(self, drive: Drive, built: Built, rng: np.random.Generator) -> None:
        self._drive, self._rng = drive, rng
        self._v = Axis(Deadband(drive.deadband_v, drive.deadband_kind), drive.ramp_v, built.lag_v)
        self._omega = Axis(Deadband(drive.deadband_omega, drive.deadband_kind), drive.ramp_omega, built.lag_omega)
        self._on_the_way: deque[tuple[float, float, float]] = deque()  # acts at, v, omega

    def command(self, now: float, v: float, omega: float) -> None:
        """Sent at `now` [s]."""
        jitter = self._drive.delay_jitter
        at = now + self._drive.delay + (self._rng.uniform(0.0, jitter) if jitter > 0.0 else 0.0)
        self._on_the_way.append((at, v, omega))  # a queue: none overtakes the one before it

    def step(self, now: float, duration: float) -> tuple[float, float]:
        """(v [m/s], omega [rad/s]) that the wheels are driven with, at the end of a step that begins at `now`."""
        while self._on_the_way and self._on_the_way[0][0] <= now + 1e-9:
            _, v, omega = self._on_the_way.popleft()
            self._v.take(v)
            self._omega.take(omega)
        return self._v.step(duration), self._omega.step(duration)
