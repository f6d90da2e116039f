"""Whether a chair that is asked to drive more slowly does, by its odometry.

What the motors make of the commands is predicted with the delay, the lag and the gain that were learned on the way, the
delay taken shorter and longer by what may be wrong with it. Only the change of the speed within a window counts: a
slope, or a gain that is not quite known, is no disobedience. Nor is a stop that takes as long as brakes take, nor what
follows it: a chair may slow down at once, or evenly.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from seater_common.geometry import Limits
from seater_nmpc.drive.prediction import CommandHistory

_DELAYS = (-0.1, 0.0, 0.1)  # [s] added to the learned one
_BRAKES = (0.6, math.inf)  # times a_max: how fast a chair that is told to stop at once slows down
_GUESSES = [(delay, brakes) for delay in _DELAYS for brakes in _BRAKES]
# [s], and the [m/s] by which the chair is asked to slow down within it at least. None of 340 recorded dockings without
# a fault (all rows of independent_chair, some twice the usual) was as far behind, nor with half instead of _FOLLOWS.
_WINDOWS = ((0.3, 0.05), (0.4, 0.06))
_FOLLOWS = 0.4  # times what it is asked to: it slows down by at least this, over the window or its second half
_BEYOND = 0.03  # [m/s] faster than predicted, whatever the delay
_DRIVES = 0.1  # [m/s] below, a chair that starts is slower than the prediction of a delay that is not learned yet
_MEMORY = 1.0  # [s]
# [m/s] slower than predicted, whatever the delay, and [s] after that, in which its delay or lag is not learned yet: one
# of 30 independent chairs was called a runaway 2.5 s after its first command.
_LATE, _LEARNS = 0.05, 1.5
# Motors that have pushed a chair over a sill let it go: one that has sped up by this much [m/s] since it was slowest
# has so long [s] from then to swing back.
_SPED_UP, _LET_GO = 0.03, 0.4
_SAME_TIME = 1e-6  # [s]


@dataclass(frozen=True)
class _Moment:
    stamp: float
    speed: float
    asked: tuple[float, ...]  # for each guess, when its delay is over
    targets: tuple[float, ...]  # for each guess, what the motors follow
    predicted: tuple[float, ...]  # and what they make of it


class Slowing:
    """Tell it the speed in each cycle."""

    def __init__(self, history: CommandHistory, limits: Limits) -> None:
        self._history, self._rates = history, [brakes * limits.a_max for _, brakes in _GUESSES]
        self.restart()

    def restart(self) -> None:
        """What came before does not count."""
        self._moments: deque[_Moment] = deque()
        self._late = -math.inf  # when it was slower to speed up than predicted

    def keeps(self, now: float, speed: float, asked: Callable[[float], float]) -> float | None:
        """The speed [m/s] that was to be expected of a chair that drives at `speed` at message time `now` [s] and does
        not slow down; None: it obeys, or it is not known. `asked(stamp)`: the speed asked for at that time."""
        newest = self._moment(now, speed, asked)
        self._moments.append(newest)
        while self._moments[0].stamp < now - _MEMORY:
            self._moments.popleft()
        forward = math.copysign(1.0, speed)
        predicted = [forward * one for one in newest.predicted]
        # A gain that was learned on a slippery floor ends with it: nobody who drives as asked keeps a speed.
        expected = max(*predicted, *(forward * one for one in newest.asked))
        if abs(speed) < min(predicted) - _LATE:
            self._late = now
        if abs(speed) < _DRIVES or abs(speed) < expected + _BEYOND or now - self._late < _LEARNS:
            return None
        if self._let_go(newest, forward):
            return None
        keeps = any(self._keeps_over(newest, forward, *window) for window in _WINDOWS)
        return forward * expected if keeps else None

    def _moment(self, now: float, speed: float, asked: Callable[[float], float]) -> _Moment:
        delay, drive = self._history.delay, self._history.drive
        told = tuple(asked(now - max(0.0, delay + more)) for more, _ in _GUESSES)
        wanted = tuple(map(drive.v.effective, told))
        last = self._moments[-1] if self._moments else _Moment(now, speed, told, wanted, wanted)
        elapsed = max(now - last.stamp, 0.0)
        decay = math.exp(-elapsed / max(drive.lag_v, _SAME_TIME))
        steps = zip(last.targets, wanted, self._rates, strict=True)
        targets = tuple(b if elapsed == 0.0 else _slower(a, b, rate * elapsed) for a, b, rate in steps)
        predicted = tuple(t + (before - t) * decay for t, before in zip(targets, last.predicted, strict=True))
        return _Moment(now, speed, told, targets, predicted)

    def _keeps_over(self, newest: _Moment, forward: float, duration: float, least: float) -> bool:
        first, middle = (self._at(newest.stamp - share * duration) for share in (1.0, 0.5))
        if first is None or middle is None:
            return False
        slower = min(forward * (p - q) for p, q in zip(first.predicted, newest.predicted, strict=True))
        # In the second half of the window, too: a late chair may have begun to slow down within it.
        follows = max(forward * (first.speed - newest.speed), 2.0 * forward * (middle.speed - newest.speed))
        return slower >= least and follows < _FOLLOWS * slower

    def _let_go(self, newest: _Moment, forward: float) -> bool:
        slowest = min(self._moments, key=lambda moment: forward * moment.speed)
        springs = forward * (newest.speed - slowest.speed) > _SPED_UP
        return springs and newest.stamp - slowest.stamp <= _LET_GO + _SAME_TIME

    def _at(self, stamp: float) -> _Moment | None:
        return next((m for m in reversed(self._moments) if m.stamp <= stamp + _SAME_TIME), None)


def _slower(before: float, wanted: float, most: float) -> float:
    """From one speed to another; where that is slower or the other way, by so much at most."""
    if before * wanted > 0.0 and abs(wanted) >= abs(before):
        return wanted
    return max(wanted, before - most) if before > 0.0 else min(wanted, before + most) if before < 0.0 else wanted
