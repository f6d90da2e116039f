"""The small moves of one attempt: which one is made next, by what those before it have shown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Limits
from seater_nmpc.drive.prediction import CommandHistory
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.sequence.rest.after_effects import AfterEffects
from seater_nmpc.sequence.rest.correction import Correction, is_off, judge, surely
from seater_nmpc.sequence.rest.fine_move import FineMove
from seater_nmpc.sequence.rest.roll import Roll

Array = NDArray[np.float64]

_EARLY = 3  # moves that may be made for a few millimetres
_LEARNT = 4  # moves after which what the chair makes of them should be known


class SmallMoves:
    """`choose` for a standing chair; `begin` the `move` that was chosen. Errors (3,): the chair in the dock's frame."""

    def __init__(self, limits: Limits, history: CommandHistory, parameters: SequenceParameters) -> None:
        self._limits, self._history, self._parameters = limits, history, parameters
        self._made = 0
        self.move: FineMove | None = None
        self._moved_from: Array | None = None  # error before it
        self._effects = AfterEffects()

    def leave(self, *, back_soon: bool) -> None:
        """The chair leaves the dock: what moves there have shown of its motors is kept in part, but not what its
        castors did. `back_soon`: the moves still count."""
        if self.move is not None:
            self.move.leave()
        self._made = self._made if back_soon else 0
        self._moved_from, self._effects = None, AfterEffects()

    def choose(self, error: Array, roll: Roll, period: float) -> Correction:
        """What is to be done; `move` is the one, if it is one. `roll`: as stops have shown; `period`: of cycles [s]."""
        p, before, effects = self._parameters, self.move, self._effects
        effects.roll = roll
        if before is not None and self._moved_from is not None:
            effects.learn(before.turning, self._moved_from, error, before.pushed)
            before.learn(error)
            self._moved_from = None
        if effects.shifts(p.hold_position):  # a turn costs another push or two: only where it must be
            p = replace(p, hold_heading=max(p.hold_heading, p.release_heading))
        use = {"turn": True, "move": True}
        while True:
            pushed = use["move"] and self._made < p.max_moves and is_off(float(error[0]), p)
            turn = effects.turn_of_push(float(error[0])) if pushed else 0.0
            verdict = judge(error + [0.0, 0.0, turn], self._made, p, **use)
            if not verdict.is_move:
                return verdict
            move = self._plan(error, verdict is Correction.TURN, before, roll, period)
            if move.is_worthwhile:
                self.move = move
                return verdict
            use["turn" if verdict is Correction.TURN else "move"] = False

    def are_surely_needed(self, error: Array, covariance: Array) -> bool:
        """Whether what is wrong of the error beyond doubt, given its covariance (3, 3), asks for another one."""
        return judge(surely(error, covariance), self._made, self._parameters).is_move

    def begin(self, error: Array) -> None:
        """The move that was chosen begins, at this error."""
        self._made, self._moved_from = self._made + 1, error

    def turn_in_vain(self, heading: float) -> bool:
        """Whether turns on the spot would be, of a chair at `heading` [rad]."""
        return self._effects.are_in_vain(heading, self._parameters.release_position)

    @property
    def turns_shift(self) -> bool:
        """Whether a turn on the spot takes the chair out of where it may stay."""
        return self._effects.shifts(self._parameters.release_position)

    @property
    def in_words(self) -> str:
        """What they have shown, for the text of a result; empty: nothing."""
        return self._effects.in_words

    def _plan(self, error: Array, turning: bool, before: FineMove | None, roll: Roll, period: float) -> FineMove:
        """A turn leaves what the push after it will turn."""
        p, after = self._parameters, float(error[0]) + self._effects.way_per_turn
        leave = -self._effects.turn_of_push(after) if turning and is_off(after, p) else 0.0
        off = abs(error[2]) > p.release_heading if turning else abs(error[0]) > p.release_position
        must, early = bool(off) and self._made < _LEARNT, self._made < _EARLY
        drive, limits = self._history.drive, self._limits
        return FineMove(error, turning, drive, limits, period, before, roll=roll, leave=leave, must=must, early=early)
