"""What the motors are told, by the phases and by the sequence itself, and what of it is withheld."""

from __future__ import annotations

import math

from seater_nmpc.control.command import Command
from seater_nmpc.drive.prediction import CommandHistory
from seater_nmpc.plausibility.watch import Watch
from seater_nmpc.sequence.phases.context import STANDING

_KEPT = 0.25  # [s] of silence for which the safety gate keeps to the last request (its request_timeout, as shipped)


class Told:
    """Noted for the prediction (`history`) and for the checks (`watch`)."""

    def __init__(self, history: CommandHistory, watch: Watch) -> None:
        self._history, self._watch = history, watch
        self._passed = self._asked = (-math.inf, STANDING)  # stamp [s] and command: the last that was sent, the newest

    def ask(self, now: float, command: Command) -> None:
        """The motors are told this from message time `now` [s] on."""
        self._passed, self._asked = self._asked, (now, command)
        self._note(now, command)

    def withhold(self, now: float) -> None:
        """The newest command has not been sent: the one before acts on, until the safety gate brakes in the silence."""
        self._asked = self._passed
        stamp, command = self._passed
        self._note(now, command if now - stamp < _KEPT else STANDING)

    def _note(self, now: float, acts: Command) -> None:
        self._history.sent(now, acts.v, acts.omega)
        self._watch.asked(now, acts.v, acts.omega)
