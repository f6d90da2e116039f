"""What small moves do beside what they are for, learned from one to the next.

Castors that a turn on the spot has swung out turn the chair as it drives on, by about as much per metre as the last
time: per metre that the motors drive it, which on a slope is more or less than it gets, as it rolls meanwhile. And
while its brakes are open for a turn, such a chair rolls, or the castors push it. So a turn that is to be followed by a
push leaves what that push will turn.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import wrap_angle
from seater_nmpc.sequence.rest.roll import Roll

Array = NDArray[np.float64]

_SHORTEST = 0.002  # [m] of a push, from which its turn per metre is learned
_MOST = (3.0, 0.03)  # [rad/m, m] that is believed
_PUSHED = 0.3  # [s] about, before the first push
_NEWEST = 0.5  # weight of the newest move
_HELD, _HELD_FROM = 0.15, 0.01  # share of an error of so many [rad], at least, that a turn mends: less, and it was held
_HELD_TURNS = 2  # in a row
_IN_VAIN = 0.7  # of the error before a turn, when the pushes after it have led to another one


class AfterEffects:
    """Of the moves at one dock. Errors (3,): the standing chair in the dock's frame [m, m, rad]."""

    def __init__(self) -> None:
        self.turn_per_way: float | None = None  # [rad/m] of a push
        self.roll = Roll()  # as stops have shown
        self._way_per_turn: float | None = None  # [m] of a turn on the spot
        self._held = 0  # turns in a row that hardly turned the chair
        self._turned_from: float | None = None  # [rad] off before the last turn
        self._pushed = False  # since the last turn
        self._pushed_for = _PUSHED  # [s] the last time

    def learn(self, turning: bool, before: Array, after: Array, pushed: float = _PUSHED) -> None:
        """A move, of `pushed` [s], has brought the chair from one error to the other; it has rolled meanwhile."""
        way, turn = float(after[0] - before[0]), wrap_angle(float(after[2] - before[2]))
        if turning:
            self._way_per_turn = _mean(self._way_per_turn, way, _MOST[1])
            held = abs(before[2]) >= _HELD_FROM and abs(turn) < _HELD * abs(before[2])
            self._held = self._held + 1 if held else 0
            self._turned_from, self._pushed = abs(float(before[2])), False
            return
        self._pushed, self._pushed_for = True, pushed
        driven = way - self.roll.way(pushed)
        if abs(driven) >= _SHORTEST:
            self.turn_per_way = _mean(self.turn_per_way, (turn - self.roll.turn(pushed)) / driven, _MOST[0])

    @property
    def in_words(self) -> str:
        """For the text of a result; empty where turns on the spot turn the chair."""
        if self._held < _HELD_TURNS:
            return ""
        return f", as {self._held} turns on the spot in a row hardly moved it (castors, soft floor, weak motors?)"

    @property
    def way_per_turn(self) -> float:
        """[m] that a turn on the spot shifts the chair along the dock's axis."""
        return self.roll.way(_PUSHED) if self._way_per_turn is None else self._way_per_turn

    def shifts(self, most: float) -> bool:
        """Whether a turn on the spot shifts the chair along the dock's axis by more than that [m]."""
        return abs(self.way_per_turn) > most

    def are_in_vain(self, heading: float, most: float) -> bool:
        """Whether turns on the spot are: the last one shifted the chair by more than `most` [m], and the pushes that
        mended it have turned it back again, to `heading` [rad]."""
        undone = self._turned_from is not None and abs(heading) > _IN_VAIN * self._turned_from
        return undone and self._pushed and self.shifts(most)

    def turn_of_push(self, x: float) -> float:
        """[rad] that the chair will turn as it is driven from `x` [m] to the dock."""
        driven = -x - self.roll.way(self._pushed_for)
        return driven * (self.turn_per_way or 0.0) + self.roll.turn(self._pushed_for)


def _mean(before: float | None, newest: float, most: float) -> float:
    newest = min(max(newest, -most), most)
    return newest if before is None else (1.0 - _NEWEST) * before + _NEWEST * newest
