"""What the chair is told: whether a button is held, and the goals that belong to it."""

from __future__ import annotations

import threading
from typing import Protocol

from seater_panel.hold.hold import Hold, Order

LEAD = 0.1  # [s] the gate is told of the button this long before the goal, which it would refuse otherwise
GRACE = 0.1  # [s] for the gate to end the goal of a button that was let go, with its own reason
REPEAT = 0.2  # [s] between two cancellations of a goal that does not end


class Chair(Protocol):
    """The way to the chair; no method may block."""

    def tell(self, held: bool) -> None:
        """Say on `hold_to_run` whether the button is held."""

    def refusal(self) -> str:
        """Why no goal can be given now; empty: it can."""

    def send(self, action: str, dock: str) -> None:
        """Give a goal to the action `dock` (empty: to the configured dock) or `undock`."""

    def cancel(self) -> None:
        """Cancel every goal of both actions."""

    def active(self) -> bool:
        """Whether the last goal of `send` has not ended yet."""


class Driver:
    """`step` is to be called at a steady rate, and at once after each change of the hold. Silence means let go, so a
    driver that is not called any more stops the chair, too."""

    def __init__(self, hold: Hold, chair: Chair) -> None:
        self._hold, self._chair = hold, chair
        self._lock = threading.Lock()
        self._number = 0  # of the press that the last goal was given for
        self._let_go: float | None = None  # since when nobody holds though a goal is active
        self._cancelled = float("-inf")

    def press(self, client: str, press: int, action: str, proven: float, now: float, dock: str = "") -> str:
        """As Hold.press; refused, too, when the chair cannot take a goal."""
        return self._chair.refusal() or self._hold.press(client, press, action, proven, now, dock)

    def stop(self, now: float) -> None:
        """Anybody has pressed Stop: no waiting, and goals that others gave end as well."""
        self._hold.end("Stop was pressed")
        with self._lock:
            self._chair.tell(False)
            self._cancel(now)

    def step(self, now: float) -> None:
        """Tell the chair what holds now, and give or cancel the goal that belongs to it."""
        with self._lock:
            order = self._hold.current(now)  # inside: no `stop` comes between this and what follows from it
            self._chair.tell(order is not None)
            if order is None:
                self._nobody_holds(now)
            else:
                self._somebody_holds(order, now)

    def _somebody_holds(self, order: Order, now: float) -> None:
        if order.number != self._number:
            if self._chair.active():  # the goal of the press before: it ends first
                self._nobody_holds(now)
            elif now - order.since >= LEAD:
                self._number, self._let_go = order.number, None
                self._chair.send(order.action, order.dock)
        elif not self._chair.active():
            # A finger that stays on the button must not run a goal that somebody else gives.
            self._hold.end("", order.number)

    def _nobody_holds(self, now: float) -> None:
        if not self._chair.active():
            self._let_go = None
            return
        self._let_go = now if self._let_go is None else self._let_go
        if now - self._let_go >= GRACE and now - self._cancelled >= REPEAT:
            self._cancel(now)

    def _cancel(self, now: float) -> None:
        self._cancelled = now
        self._chair.cancel()
