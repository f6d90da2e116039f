"""Who sends on a topic that one node is to send on. No ROS.

Two that send in turns contradict each other, and whoever listens believes now the one, now the other. Connections do
not show it: rospy keeps those of a node that was killed. So what counts is that a node speaks again after another one
has spoken; a node that takes over from one that has ended is none of the two.
"""

from __future__ import annotations

import time
from collections.abc import Callable

MEMORY = 2.0  # [s] who was silent for longer has ended; so long two that speak in turns are remembered


class Senders:
    """Of one topic; from the threads of its subscriber, asked from any."""

    def __init__(self, topic: str, clock: Callable[[], float] = time.monotonic) -> None:
        """`topic`: its name for people; `clock` [s] that nobody can set."""
        self._topic, self._clock = topic, clock
        self._last: tuple[str, float] | None = None  # sender and time [s] of the last message
        self._before: tuple[str, float] | None = None  # the same of the last one of another sender
        self._together: tuple[str, str, float] | None = None  # two that spoke in turns, and when last [s]

    def heard(self, sender: str) -> None:
        """A message came from the node of this name."""
        now, last, before = self._clock(), self._last, self._before
        if last is not None and last[0] != sender:
            if before is not None and before[0] == sender and now - before[1] <= MEMORY:
                one, other = sorted((last[0], sender))
                self._together = (one, other, now)
            self._before = last
        self._last = (sender, now)

    def forget(self) -> None:
        """Two that spoke in turns until now; they are noticed again as soon as they go on."""
        self._together = None

    def trouble(self) -> str:
        """Empty, or that two nodes send, in words."""
        together = self._together
        if together is None or self._clock() - together[2] > MEMORY:
            return ""
        return f"2 nodes publish {self._topic} in turns, {together[0]} and {together[1]}: one is allowed"


def sender_of(message: object) -> str:
    """Name of the node that sent this message of a rospy subscriber; empty: not told."""
    header = getattr(message, "_connection_header", None) or {}
    return str(header.get("callerid", ""))
