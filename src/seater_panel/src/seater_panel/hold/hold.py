"""Which page holds a button of the panel, and until when that counts.

The server sends numbered ticks to each page. A page whose button is held answers them. An answer proves that the
finger was there after its tick was sent, however long the answer was on its way. So the button counts as held until
`timeout` after the newest tick that was answered: a connection that is late, broken, or full of old answers cannot make
it longer.

All times are seconds of one steady clock. Safe to use from several threads.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass

ACTIONS = ("dock", "undock")


@dataclass(frozen=True, kw_only=True)
class Order:
    """A button is held: this is wanted as long as it is."""

    action: str
    dock: str  # that it is about; empty: the configured one
    number: int  # of the press, never used twice
    since: float  # when it was pressed
    client: str


class Hold:
    """At most one page holds, and each press ends once: after that only a new press begins anew."""

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._lock = threading.Lock()
        self._order: Order | None = None
        self._deadline = 0.0
        self._number = 0
        self._presses: dict[str, int] = {}  # client -> its newest press
        self._ended = ""

    def press(self, client: str, press: int, action: str, proven: float, now: float, dock: str = "") -> str:
        """`client` begins its press number `press`; `proven`: when the tick was sent that it answers.

        Returns why nothing begins; empty: the button is held from now on.
        """
        with self._lock:
            self._expire(now)
            if action not in ACTIONS:
                return f"there is no action {action!r}"
            if press <= self._presses.get(client, 0):
                return "this press is over: let go and press again"
            self._presses[client] = press
            if self._order is not None:
                return "the button is held already" if self._order.client == client else "somebody else holds a button"
            if now - proven > self._timeout:
                return "the connection is too slow"
            self._number += 1
            self._order = Order(action=action, dock=dock, number=self._number, since=now, client=client)
            self._deadline, self._ended = proven + self._timeout, ""
            return ""

    def keep(self, client: str, press: int, proven: float, now: float) -> None:
        """An answer of the page whose finger is still on the button. Without effect for a press that is over."""
        with self._lock:
            self._expire(now)
            if self._order is not None and self._order.client == client and self._presses[client] == press:
                self._deadline = max(self._deadline, proven + self._timeout)

    def release(self, client: str, reason: str = "the button was let go") -> None:
        """The finger of this page is off, or the page is gone."""
        with self._lock:
            if self._order is not None and self._order.client == client:
                self._end(reason)

    def end(self, reason: str, number: int | None = None) -> None:
        """Whoever holds, holds no more; with a number: only if it is this press."""
        with self._lock:
            if self._order is not None and number in (None, self._order.number):
                self._end(reason)

    def forget(self, client: str) -> None:
        """The page is gone for good; its name is not used again."""
        self.release(client, "the connection to the page is lost")
        with self._lock:
            self._presses.pop(client, None)

    def current(self, now: float) -> Order | None:
        """What is wanted now; None: no button is held."""
        with self._lock:
            self._expire(now)
            return self._order

    @property
    def ended(self) -> str:
        """Why the last press ended; empty: one is held, or none has been yet."""
        with self._lock:
            return self._ended

    def _expire(self, now: float) -> None:
        if self._order is not None and now >= self._deadline:
            self._end("the connection to the page is too slow or lost")

    def _end(self, reason: str) -> None:
        self._order, self._ended = None, reason
