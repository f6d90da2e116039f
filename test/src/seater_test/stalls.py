"""A machine that stands still for a moment, as virtual ones do, ends a docking on the clock on the wall: rightly.

What a test did while that happened says nothing of seater. `Stalls` notes how long the simulated plant was silent;
`undisturbed` does it again then, and only then: a wrong outcome of an undisturbed try stays one.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, TypeVar

import rospy

_NOTICED = 0.15  # [s] without a word of the plant; the chair's nodes stop the chair at 0.3 s
_TRIES = 5

Outcome = TypeVar("Outcome")


class Stalls:
    """Hears a topic that the plant publishes at least 40 times a second."""

    def __init__(self) -> None:
        self.longest = 0.0  # [s] of silence, since the last `forget`
        self._last: float | None = None

    def heard(self, _message: Any = None) -> None:
        """The topic's callback."""
        now = time.monotonic()
        if self._last is not None:
            self.longest = max(self.longest, now - self._last)
        self._last = now

    def forget(self) -> None:
        self.longest = 0.0
        self._last = None

    def undisturbed(self, act: Callable[[], Outcome], right: Callable[[Outcome], bool]) -> Outcome:
        """What `act` returns: of the first try that is `right` or during which the plant was heard throughout."""
        for left in reversed(range(_TRIES)):
            self.forget()
            outcome = act()
            if right(outcome) or self.longest < _NOTICED or left == 0:
                return outcome
            rospy.logwarn("the machine stood still for %.2f s: once more", self.longest)
        raise AssertionError("unreachable")
