"""One page: ticks and views out, answers and buttons in.

To the page: {"n": number of the tick, "view": {...}, "hold": {...}}; the view comes with every second tick.
From the page, all with "seen": the newest tick that it has got:
    {"press": number, "action": "dock" or "undock", "dock": its name}
                                                      a finger is on a button; numbers of presses rise; without "dock",
                                                      or with an empty one, it is the configured dock
    {"held": number}                                  the answer to a tick while it stays there
    {}                                                the answer to a tick with no finger on a button
    {"release": number}, {"stop": true}
At most WINDOW ticks are on the way: a slow page gets fewer, and what it shows is never old.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
from typing import Any

from aiohttp import WSMsgType, web

from seater_panel.web.panel import Panel

TICK = 0.05  # [s]
WINDOW = 4  # ticks that are not answered yet
REMEMBERED = 64  # ticks whose times are kept
PATIENCE = 5.0  # [s] without an answer: the page is gone
NO_ANSWER = 4408  # close code of the WebSocket, after HTTP's 408


class Session:
    """`name`: never used twice."""

    def __init__(self, name: str, socket: web.WebSocketResponse, panel: Panel) -> None:
        self._name, self._socket, self._panel = name, socket, panel
        self._sent: dict[int, float] = {}  # tick -> when it was sent
        self._number = self._answered = 0
        self._heard, self._silent = panel.clock(), False
        self._press, self._refused = 0, ""

    async def run(self) -> None:
        """Until the page is gone; whatever happens, it then holds no button."""
        ticking = asyncio.create_task(self._tick())
        try:
            async for message in self._socket:
                if message.type is not WSMsgType.TEXT or not self._take(message.data):
                    break
        finally:
            self._panel.hold.forget(self._name)
            self._panel.changed()
            if not self._silent:  # else it is just saying so
                ticking.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionError):
                await ticking

    async def _tick(self) -> None:
        while not self._socket.closed:
            now = self._panel.clock()
            if now - self._heard > PATIENCE:
                self._silent = True
                await self._socket.close(code=NO_ANSWER, message=b"no answer")
                return
            if self._number - self._answered < WINDOW:
                self._number += 1
                self._sent[self._number] = now
                self._sent.pop(self._number - REMEMBERED, None)
                await self._socket.send_str(json.dumps(self._message(now), allow_nan=False))
            await asyncio.sleep(TICK)

    def _message(self, now: float) -> dict[str, Any]:
        order = self._panel.hold.current(now)
        holder = "nobody" if order is None else "you" if order.client == self._name else "somebody"
        hold = {
            "holder": holder,
            "press": self._press,  # the newest one of this page
            "ended": self._panel.hold.ended,
            "refused": self._refused,
            "buttons": self._panel.driver is not None,
        }
        message: dict[str, Any] = {"n": self._number, "hold": hold}
        if self._number % 2:
            message["view"] = self._panel.view()
        return message

    def _take(self, text: str) -> bool:
        """False: this is no message of our page."""
        try:
            message = json.loads(text)
            seen = int(message["seen"])
            proven = self._sent[seen]
        except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
            return False
        self._heard, self._answered = self._panel.clock(), max(self._answered, seen)
        if self._panel.driver is None:
            return True
        return self._button(message, proven)

    def _button(self, message: dict[str, Any], proven: float) -> bool:
        now, hold, driver = self._panel.clock(), self._panel.hold, self._panel.driver
        assert driver is not None
        if "stop" in message:
            driver.stop(now)
        elif "release" in message:
            hold.release(self._name)
        elif isinstance(message.get("press"), int):
            self._press = message["press"]
            action, dock = str(message.get("action")), str(message.get("dock", ""))
            self._refused = driver.press(self._name, self._press, action, proven, now, dock)
        elif isinstance(message.get("held"), int):
            hold.keep(self._name, message["held"], proven, now)
            return True
        else:
            return len(message) == 1
        self._panel.changed()
        return True
