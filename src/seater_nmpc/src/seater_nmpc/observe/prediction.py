"""From the last measurement to the time when the next command acts: delay, latency and motor lag."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.se2 import arc_step
from seater_nmpc.parameters import Prediction

Array = NDArray[np.float64]

_SUBSTEP = 0.01  # [s] longest piece that the prediction rolls at once
_MEMORY = 2.0  # [s] how long a command that acts already is kept


class CommandHistory:
    """The commands that were sent, and when each of them acts."""

    def __init__(self, parameters: Prediction) -> None:
        self._parameters = parameters
        self._sent: deque[tuple[float, float, float]] = deque()  # acts at [s], v, omega

    @property
    def last(self) -> tuple[float, float] | None:
        """(v, omega) of the command sent last."""
        return self._sent[-1][1:] if self._sent else None

    def acceleration(self, period: float) -> tuple[float, float]:
        """(dv/dt, domega/dt) between the last two commands, `period` [s] apart; zero where there are not two."""
        if len(self._sent) < 2:
            return 0.0, 0.0
        (_, v0, w0), (_, v1, w1) = self._sent[-2], self._sent[-1]
        return (v1 - v0) / period, (w1 - w0) / period

    def clear(self) -> None:
        """Forget everything: nothing is known to be on its way."""
        self._sent.clear()

    def sent(self, stamp: float, v: float, omega: float) -> None:
        """A command computed from the measurement at `stamp` [s] was sent."""
        while self._sent and self._sent[0][0] < stamp - _MEMORY:
            self._sent.popleft()
        self._sent.append((self.acts_at(stamp), v, omega))

    def acts_at(self, stamp: float) -> float:
        """When a command computed from the measurement at `stamp` acts [s]."""
        return stamp + self._parameters.solve_latency + self._parameters.command_delay

    def roll(self, stamp: float, pose: ArrayLike, v: float, omega: float) -> tuple[Array, float, float]:
        """Pose, v and omega at the time when the next command acts, from a measurement at `stamp`.

        The motors follow each command with a first-order lag; without lag the measured speeds hold until the first
        command that acts.
        """
        return self._advance(stamp, self.acts_at(stamp), np.asarray(pose, dtype=float), v, omega)

    def speeds(self, start: float, end: float, v: float, omega: float) -> tuple[float, float]:
        """v and omega at `end`, from those at `start`; as in `roll`."""
        return self._advance(start, end, np.zeros(3), v, omega)[1:]

    def _advance(self, time: float, end: float, pose: Array, v: float, omega: float) -> tuple[Array, float, float]:
        lag = self._parameters.motor_lag
        while time < end - 1e-9:
            changes = [at for at, _, _ in self._sent if at > time + 1e-9]
            step = min([end - time, _SUBSTEP, *(at - time for at in changes)])
            asked = self._acting(time)
            v, mean_v = _follow(v, None if asked is None else asked[0], step, lag)
            omega, mean_omega = _follow(omega, None if asked is None else asked[1], step, lag)
            pose = arc_step(pose, mean_v, mean_omega, step)
            time += step
        return pose, v, omega

    def _acting(self, time: float) -> tuple[float, float] | None:
        acting = [command for command in self._sent if command[0] <= time + 1e-9]
        return acting[-1][1:] if acting else None


def coasting_pose(pose: ArrayLike, v: float, omega: float, lag: float) -> Array:
    """Where the chair would come to rest if zero were commanded now and the motors lag by the time constant `lag`.

    Along a straight line p + lag * v moves exactly with the commanded speed, since d/dt (p + lag * v) = v + (c - v); so
    planning from this pose with the commands as speeds takes the lag into account at no cost to the solver.
    """
    return arc_step(pose, v, omega, lag)


def _follow(speed: float, asked: float | None, step: float, lag: float) -> tuple[float, float]:
    """Speed after `step` and its mean over the step, for a first-order lag behind `asked` (None: keeps its speed)."""
    if asked is None:
        return speed, speed
    if lag <= 0.0:
        return asked, asked
    decay = math.exp(-step / lag)
    return asked + (speed - asked) * decay, asked + (speed - asked) * (1.0 - decay) * lag / step
