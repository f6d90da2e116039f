"""What was sent to the motors, and the chair from the last measurement until the next command acts."""

from __future__ import annotations

import itertools
import math
from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.se2 import arc_step
from seater_nmpc.drive.axis import configured
from seater_nmpc.parameters import Prediction

Array = NDArray[np.float64]

_SUBSTEP = 0.01  # [s] longest piece that the prediction rolls at once
_SAME_TIME = 1e-9  # [s] times nearer to each other than this are one
_MEMORY = 2.0  # [s] how long a command that acts already is kept


class _Sent(NamedTuple):
    """One command."""

    number: int
    stamp: float  # of the measurement behind it [s]
    v: float  # [m/s]
    omega: float  # [rad/s]
    wanted: tuple[float, float]  # the speeds that it was to bring about: not the same in a deadband


class CommandHistory:
    """All commands that were sent to one chair, and when each of them acts. Readers have a CommandView of it."""

    def __init__(self, prediction: Prediction) -> None:
        self.prediction = prediction
        self.forget_response()
        self._sent: deque[_Sent] = deque()
        self._count = 0  # of all that were ever sent

    def forget_response(self) -> None:
        """What the motors make of the commands is again as configured."""
        self.drive = configured(self.prediction)
        self.delay = self.prediction.solve_latency + self.prediction.command_delay  # [s] from measurement to effect

    def clear(self) -> None:
        """Forget everything that was sent: nothing is known to be on its way."""
        self._sent.clear()

    def sent(self, stamp: float, v: float, omega: float, wanted: tuple[float, float] | None = None) -> None:
        """A command computed from the measurement at `stamp` [s] was sent. Of two for one stamp the later one acts.

        `wanted`: speeds (v, omega) that it was to bring about; None: the command itself. When time goes backward, what
        was sent before is forgotten.
        """
        if self._sent and self._sent[-1].stamp > stamp:
            self._sent.clear()
        elif self._sent and self._sent[-1].stamp == stamp:
            before = self._sent.pop()
            if wanted is None and (before.v, before.omega) == (v, omega):
                wanted = before.wanted  # the same command, noted once more
        while self._sent and self._sent[0].stamp < stamp - _MEMORY:
            self._sent.popleft()
        self._sent.append(_Sent(self._count, stamp, v, omega, (v, omega) if wanted is None else wanted))
        self._count += 1

    def acts_at(self, stamp: float) -> float:
        """When a command computed from the measurement at `stamp` acts [s]."""
        return stamp + self.delay

    def view(self) -> CommandView:
        """Of the commands that are sent from now on."""
        return CommandView(self)

    def since(self, number: int) -> list[_Sent]:
        """The commands from this number on, in the order in which they act."""
        if not self._sent or self._sent[0].number >= number:  # the rule, once a goal is older than the memory
            return list(self._sent)
        return [command for command in self._sent if command.number >= number]

    def last(self, number: int) -> _Sent | None:
        """The last command, unless its number is less than this."""
        return self._sent[-1] if self._sent and self._sent[-1].number >= number else None

    @property
    def next_number(self) -> int:
        """Of the command that will be sent next."""
        return self._count


class CommandView:
    """The commands of a history since `restart`, and what the motors make of them."""

    def __init__(self, history: CommandHistory) -> None:
        self._history = history
        self.restart()

    def restart(self) -> None:
        """From now on only what is sent later counts."""
        self._first = self._history.next_number

    @property
    def last(self) -> tuple[float, float] | None:
        """(v, omega) of the command sent last."""
        last = self._history.last(self._first)
        return (last.v, last.omega) if last is not None else None

    @property
    def last_wanted(self) -> tuple[float, float] | None:
        """Speeds (v, omega) that the command sent last was to bring about."""
        last = self._history.last(self._first)
        return last.wanted if last is not None else None

    def mean(self, start: float, end: float) -> tuple[float, float]:
        """Mean (v, omega) of what was sent between two times [s], whenever it acts; zero before the first command."""
        commands = self._history.since(self._first)
        times = [start, *(command.stamp for command in commands if start < command.stamp < end), end]
        v = omega = 0.0
        for begin, stop in itertools.pairwise(times):
            index = _later(commands, begin)
            if index > 0:
                command, duration = commands[index - 1], stop - begin
                v, omega = v + duration * command.v, omega + duration * command.omega
        return v / (end - start), omega / (end - start)

    def acceleration(self, period: float) -> tuple[float, float]:
        """(dv/dt, domega/dt) between the last two commands, `period` [s] apart; zero where there are not two."""
        commands = self._history.since(self._first)
        if len(commands) < 2:
            return 0.0, 0.0
        before, last = commands[-2:]
        return (last.wanted[0] - before.wanted[0]) / period, (last.wanted[1] - before.wanted[1]) / period

    def roll(self, stamp: float, pose: ArrayLike, v: float, omega: float) -> tuple[Array, float, float]:
        """Pose, v and omega at the time when the next command acts, from a measurement at `stamp`.

        The motors follow each command, as far as the deadband lets it through, with a first-order lag. The measured
        speeds hold until the first command that acts.
        """
        return self._advance(stamp, self._history.acts_at(stamp), np.asarray(pose, dtype=float), v, omega)

    def speeds(self, start: float, end: float, v: float, omega: float) -> tuple[float, float]:
        """v and omega at `end`, from those at `start`; as in `roll`."""
        return self._advance(start, end, np.zeros(3), v, omega)[1:]

    def _advance(self, time: float, end: float, pose: Array, v: float, omega: float) -> tuple[Array, float, float]:
        drive, delay, commands = self._history.drive, self._history.delay, self._history.since(self._first)
        while time < end - _SAME_TIME:
            began = time - delay  # of what acts now
            first = _later(commands, began)
            acting = commands[first - 1] if first > 0 else None
            step = min(end - time, _SUBSTEP)
            if first < len(commands):
                step = min(step, commands[first].stamp - began)
            v, mean_v = _follow(v, None if acting is None else drive.v.effective(acting.v), step, drive.lag_v)
            asked = None if acting is None else drive.omega.effective(acting.omega) + drive.curvature * v
            omega, mean_omega = _follow(omega, asked, step, drive.lag_omega)
            pose = arc_step(pose, mean_v, mean_omega, step)
            time += step
        return pose, v, omega


def coasting_pose(pose: ArrayLike, v: float, omega: float, lag: float, lag_omega: float | None = None) -> Array:
    """Where the chair would come to rest if zero were commanded now and the motors lag by the time constant `lag`
    (turning: by `lag_omega`, None: the same).

    Along a straight line p + lag * v moves exactly with the commanded speed, since d/dt (p + lag * v) = v + (c - v); so
    planning from this pose with the commands as speeds takes the lag into account at no cost to the solver.
    """
    return arc_step(pose, v * lag, omega * (lag if lag_omega is None else lag_omega), 1.0)


def _later(commands: list[_Sent], time: float) -> int:
    """Index of the first command that was sent later."""
    for index in range(len(commands), 0, -1):  # the last ones are asked for
        if commands[index - 1].stamp <= time + _SAME_TIME:
            return index
    return 0


def _follow(speed: float, asked: float | None, step: float, lag: float) -> tuple[float, float]:
    """Speed after `step` and its mean over the step, for a first-order lag behind `asked` (None: keeps its speed)."""
    if asked is None:
        return speed, speed
    if lag <= 0.0:
        return asked, asked
    decay = math.exp(-step / lag)
    return asked + (speed - asked) * decay, asked + (speed - asked) * (1.0 - decay) * lag / step
