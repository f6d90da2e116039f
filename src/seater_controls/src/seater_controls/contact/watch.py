"""A thread that reads the contacts and tells what it finds, with each change to pressed at once, else at its rate."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Protocol

from seater_controls.background import Background
from seater_controls.contact.contact import Contact
from seater_controls.contact.lines import LineError, Lines
from seater_controls.settings import ContactSettings

_PAUSE = 0.5  # [s] before the lines are asked for anew


class Readable(Protocol):
    """Lines, or others in tests."""

    def levels(self) -> list[int]: ...
    def close(self) -> None: ...


class Watch(Background):
    """`tell(pressed)` is called in its thread alone: one that hangs or has failed is silent, which the gate notices.
    The last word, after `stop`, is: pressed."""

    def __init__(
        self,
        settings: ContactSettings,
        tell: Callable[[bool], None],
        open_lines: Callable[[ContactSettings], Readable] = Lines,
    ) -> None:
        super().__init__()
        self._settings, self._tell, self._open = settings, tell, open_lines
        self._contact = Contact(settings)
        self._lines: Readable | None = None
        self._asked = self._told_at = -math.inf
        self._told = False
        self._error = ""

    @property
    def why(self) -> str:
        """It is pressed, in words; empty: released."""
        return self._contact.why

    def step(self, now: float) -> None:
        """One reading at `now` [s]."""
        pressed = self._contact.read(self._levels(now), now, self._error)
        if (pressed and not self._told) or now - self._told_at >= 1.0 / self._settings.rate:
            self._told, self._told_at = pressed, now
            self._tell(pressed)

    def _levels(self, now: float) -> list[int] | None:
        try:
            if self._lines is None and now - self._asked >= _PAUSE:
                self._asked = now
                self._lines = self._open(self._settings)
            return None if self._lines is None else self._lines.levels()
        except LineError as error:
            self._error = str(error)
            self._close()
            return None

    def _close(self) -> None:
        lines, self._lines = self._lines, None
        if lines is not None:
            lines.close()

    def _run(self) -> None:
        period = 1.0 / self._settings.sampling
        try:
            while not self._stop.is_set():
                self.step(time.monotonic())
                self._stop.wait(period)
        finally:
            self._tell(True)
            self._close()
