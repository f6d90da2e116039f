"""How a chair rolls while its brakes are open: on a slope, from a push or turn on until they grip again.

A motor without demand gives way to the slope's pull with a steady speed, so the way is that speed times the time with
open brakes: the time of the push and the time until they grip. Across a slope it turns downhill in the same manner.
Both show in the odometry of each stop (creep.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.se2 import relative
from seater_nmpc.sequence.rest.creep import HOLDS, Creep, Demand, fit, likely_holds

Array = NDArray[np.float64]

_SEEN = (0.002, 0.004)  # [m, rad] from which on it is a roll: two ticks of a coarse encoder
_LIKELY = 0.5  # from which on it is reckoned with
_SD, _SHARE = 0.002, 0.15  # [m], and share of the way, by which a roll differs from the last one
_WORTH_SAYING = 5.0  # [mm]
_USUAL_HOLD = 1.0  # [s] from the end of the demand until brakes grip; of powered chairs 0.3 to 2 s
_NOISE = (0.0008, 0.0015)  # [m, rad] of odometry beside what a fit can follow
_COARSE = 0.6  # of the odometry's resolution: it is noise as well
_DRIFT = 0.004  # [m/s or rad/s] from stop to stop
_CHANGES = 0.008  # the same from docking to docking
_FEWEST = 8  # cycles that are fitted
_LONGEST = 3.0  # [s] after the last command, beyond which the trace is not needed


@dataclass(frozen=True)
class Roll:
    """What is reckoned with; nothing: `speed` and `turning` are zero."""

    speed: float = 0.0  # [m/s] ahead (negative: back) while the brakes are open
    hold: float = _USUAL_HOLD  # [s] after the end of the demand
    turning: float = 0.0  # [rad/s] meanwhile

    def way(self, pushed: float = 0.0) -> float:
        """[m] ahead, of a move that is pushed for so long [s]."""
        return self.speed * (pushed + self.hold)

    def turn(self, pushed: float = 0.0) -> float:
        """[rad] that it turns beside what it is pushed for."""
        return self.turning * (pushed + self.hold)

    @property
    def seen(self) -> bool:
        """Whether it rolls at all."""
        return self.speed != 0.0 or self.turning != 0.0

    @property
    def in_words(self) -> str:
        """For the text of a result; empty where it hardly rolls."""
        way = 1e3 * self.way()
        return f", as it rolls {abs(way):.0f} mm until its brakes hold" if abs(way) >= _WORTH_SAYING else ""

    @property
    def sd(self) -> float:
        """[m] of `way`."""
        return math.hypot(_SD, _SHARE * self.way())


class RollWatch:
    """Of one stop, and of the small move before it: `push` and `see` each cycle, `stop` once."""

    def __init__(self) -> None:
        self._times: list[float] = []  # [s]
        self._ways: list[tuple[float, float]] = []  # ahead, turned [m, rad]
        self._from: Array | None = None
        self._steps: list[tuple[float, float]] = []
        self._ends = self._calm = math.inf

    def push(self, stamp: float, command: float) -> None:
        """Of a small move [m/s or rad/s], along its own axis."""
        self._steps.append((stamp, command))

    def stop(self, stamp: float, motors_stand: float) -> None:
        """From `stamp` on zero is asked for; `motors_stand` [s]: when they have to."""
        if not math.isfinite(self._ends):
            self._ends, self._calm = stamp, motors_stand

    def see(self, stamp: float, pose: ArrayLike) -> None:
        """Where the chair is (3,), in any frame that does not move."""
        if self._from is None:
            self._from = np.array(pose, dtype=float)
        if stamp < self._ends + _LONGEST:
            moved = relative(self._from, pose)
            self._times.append(stamp)
            self._ways.append((float(moved[0]), float(moved[2])))

    def trace(self, axis: int) -> tuple[Array, Array, Demand] | None:
        """Times (n,) and ways (n,) along this axis, and what was asked for; None: too short. How a chair was steered
        until it stopped is not told, so its turning counts from when its motors have to stand."""
        if not math.isfinite(self._ends):
            return None
        times, ways = np.array(self._times), np.array(self._ways).reshape(-1, 2)[:, axis]
        steered = axis == 1 and not self._steps
        of_use = times >= self._calm if steered else times >= times[:1]
        if np.count_nonzero(of_use) < _FEWEST:
            return None
        return times[of_use], ways[of_use], Demand(self._ends, tuple(self._steps))


@dataclass(frozen=True)
class Belief:
    """In how the chair rolls, after the stops so far."""

    creeps: tuple[Creep, Creep] = (Creep(), Creep())  # ahead, turning
    holds: Array | None = field(default=None, compare=False)  # how likely each of HOLDS is; None: no stop yet

    def aged(self) -> Belief:
        """Before another docking."""
        return Belief((self.creeps[0].before(_CHANGES), self.creeps[1].before(_CHANGES)), self.holds)

    def after(self, watch: RollWatch, delay: float, lags: tuple[float, float]) -> Belief:
        """With one more stop of a chair that stands by now. `delay`, `lags` of both axes [s]: believed in."""
        creeps, holds = list(self.creeps), likely_holds(self.holds)
        for axis in (0, 1):
            trace = watch.trace(axis)
            if trace is None:
                continue
            known, noise = creeps[axis].before(_DRIFT), math.hypot(_NOISE[axis], _COARSE * _resolution(trace[1]))
            creeps[axis], likely = fit(*trace, delay, lags[axis], known, holds, noise)
            holds = creeps[axis].probability * likely + (1.0 - creeps[axis].probability) * holds
        return self if tuple(creeps) == self.creeps else Belief((creeps[0], creeps[1]), holds)

    @property
    def roll(self) -> Roll:
        """What is to be reckoned with."""
        if self.holds is None:
            return Roll()
        hold = float(self.holds @ HOLDS)
        ahead, turning = (self._speed(axis, hold) for axis in (0, 1))
        return Roll(ahead, hold, turning) if ahead or turning else Roll()

    def _speed(self, axis: int, hold: float) -> float:
        creep = self.creeps[axis]
        shows = creep.probability > _LIKELY and abs(creep.mean) * hold >= _SEEN[axis]
        return creep.probability * creep.mean if shows else 0.0


def _resolution(ways: Array) -> float:
    """Least difference [m or rad] between two that differ."""
    steps = np.diff(np.unique(np.round(ways, 7)))
    return float(steps.min()) if len(steps) else 0.0
