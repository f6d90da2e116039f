"""Whether an emergency stop is pressed: of readings of its contacts, debounced one way only."""

from __future__ import annotations

import math
from collections.abc import Sequence

from seater_controls.settings import ContactSettings


class Contact:
    """Pressed from the start. Open once, at any contact, or not to be read, is pressed; released is closed at all of
    them for `release`, looked at without a break."""

    def __init__(self, settings: ContactSettings) -> None:
        self._settings = settings
        self._closed_since, self._read_at = math.inf, -math.inf
        self.why = "not read yet"  # in words; empty: released

    def read(self, levels: Sequence[int] | None, now: float, error: str = "") -> bool:
        """Whether it is pressed, by the levels of all lines at `now` [s] by the steady clock; None: `error`."""
        s = self._settings
        gap = bool(self.why) and now - self._read_at > 0.5 * s.release  # it may have been open meanwhile
        self._read_at = now
        if levels is None or len(levels) != len(s.lines):
            return self._pressed(error or "not every line was read")
        opened = [line for line, level in zip(s.lines, levels, strict=True) if level != s.closed]
        if opened:
            return self._pressed(f"line {', '.join(map(str, opened))} is open")
        self._closed_since = now if gap else min(self._closed_since, now)
        if now - self._closed_since < s.release:
            self.why = self.why or "closed for too short a time"
            return True
        self.why = ""
        return False

    def _pressed(self, why: str) -> bool:
        self._closed_since, self.why = math.inf, why
        return True
