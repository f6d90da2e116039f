"""When an episode begins and ends: with a goal, and a little after its result."""

from __future__ import annotations

import datetime
import re
from collections import deque
from dataclasses import dataclass

from seater_nmpc.sequence.goal.results import ResultCode
from seater_tools.episodes.ring import Entry, Ring


@dataclass(frozen=True, kw_only=True)
class Episode:
    """One docking or undocking that has ended."""

    name: str  # of the file, without its ending
    entries: list[Entry]
    dropped: int  # messages that found no room in memory


class Episodes:
    """Goals by their ids. A goal that replaces another one is one episode with it."""

    def __init__(self, ring: Ring, after: float) -> None:
        """`after`: [s] that belong to an episode behind its result, unless the next goal is given meanwhile."""
        self._ring, self._after = ring, after
        self._active: set[str] = set()
        self._over: deque[str] = deque(maxlen=20)
        self._ended: float | None = None
        self._followed = False  # by another goal, before it was written
        self._name = ""

    def goes_on(self, id: str) -> None:
        """A goal is active. What is heard after its result is late."""
        if id in self._over or id in self._active:
            return
        if not self._active:
            self._followed = self._ended is not None
            if not self._followed:
                self._ring.hold()
        self._active.add(id)

    def result(self, id: str, action: str, code: int, now: float) -> None:
        """It has ended; of a goal that was over at once, what is in the ring counts."""
        self._active.discard(id)
        self._over.append(id)
        self._ended, self._name = now, f"{action}_{_name(code)}"

    def due(self, now: float, date: datetime.datetime) -> Episode | None:
        """The episode that is complete; `date`: for its name."""
        if self._ended is None or not (self._followed or self._is_over(now)):
            return None
        stamp = date.astimezone(datetime.UTC).strftime("%Y%m%dT%H%M%SZ")
        found = Episode(name=f"{stamp}_{self._name}", entries=list(self._ring.taken()), dropped=self._ring.dropped)
        self._ended, self._followed = None, False
        self._ring.release()
        if self._active:
            self._ring.hold()
        return found

    def _is_over(self, now: float) -> bool:
        """Its result is `after` ago, or the clock was set back."""
        return not self._active and self._ended is not None and not 0.0 <= now - self._ended < self._after


def _name(code: int) -> str:
    text = ResultCode(code).name if code in set(map(int, ResultCode)) else str(code)
    return re.sub(r"\W", "", text)
