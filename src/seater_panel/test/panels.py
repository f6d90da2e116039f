"""A chair that only remembers what it was told, and a panel round it."""

from __future__ import annotations

import asyncio
import ssl
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import aiohttp
import numpy as np

from seater_common.geometry import Chair, Dock
from seater_panel.hold.driver import Driver
from seater_panel.hold.hold import Hold
from seater_panel.view.heard import Gate, Heard, Motion
from seater_panel.view.model import view
from seater_panel.web.frames import Frames
from seater_panel.web.panel import Panel
from seater_panel.web.serve import Serving
from seater_panel.web.server import Server

PAGE = Path(__file__).resolve().parents[1] / "page"
TOKEN = "a-token-of-the-tests-0123456789"
PERIOD = 0.02  # [s] of the driver, as in the node


@dataclass
class FakeChair:
    """Implements seater_panel.hold.driver.Chair; `said`: every change of what it was told, with its time."""

    refused: str = ""
    goal: str = ""  # the action that runs
    held: bool = False
    said: list[tuple[float, str]] = field(default_factory=list)

    def tell(self, held: bool) -> None:
        if held != self.held:
            self.held = held
            self._say("held" if held else "let go")

    def refusal(self) -> str:
        return self.refused

    def send(self, action: str, dock: str) -> None:
        self.goal = action
        self._say(f"{action} {dock}".rstrip())

    def cancel(self) -> None:
        self.goal = ""
        self._say("cancel")

    def active(self) -> bool:
        return bool(self.goal)

    def words(self) -> list[str]:
        return [text for _, text in self.said]

    def _say(self, text: str) -> None:
        self.said.append((time.monotonic(), text))


class FakePanel:
    """A panel with its server; `heard` is what the pages show."""

    def __init__(self, timeout: float = 0.22, *, buttons: bool = True) -> None:
        self.chair, self.frames, self.hold = FakeChair(), Frames(), Hold(timeout)
        self.heard = Heard(dock=np.array([2.5, 0.0, 0.0]))
        self.driver = Driver(self.hold, self.chair)
        self.panel = Panel(
            hold=self.hold,
            driver=self.driver if buttons else None,
            frames=self.frames,
            view=self.view,
            changed=self.step,
        )

    def view(self) -> dict[str, Any]:
        now = time.monotonic()
        gate = Gate(time=now, state="STOPPED", reason="")
        motion = self.heard.motion or Motion(time=now, pose=np.zeros(3), v=0.0)
        return view(Heard(**{**vars(self.heard), "gate": gate, "motion": motion}), Chair(), Dock(), now)

    def step(self) -> None:
        self.driver.step(time.monotonic())

    @asynccontextmanager
    async def served(self, names: tuple[str, ...] = (), encrypted: ssl.SSLContext | None = None) -> AsyncIterator[str]:
        """Its address; the driver steps meanwhile."""
        application = Server(self.panel, TOKEN, PAGE, names).application()
        with Serving(application, "127.0.0.1", 0, encrypted) as serving:
            pump = asyncio.create_task(self._pump())
            try:
                yield f"{'https' if encrypted else 'http'}://127.0.0.1:{serving.port}"
            finally:
                pump.cancel()

    async def _pump(self) -> None:
        while True:
            self.step()
            await asyncio.sleep(PERIOD)


class Client:
    """What the page does, without a browser."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self.socket, self.last, self.press = socket, {}, 0
        self._held = 0  # press that is held; 0: none
        self._reader: asyncio.Task[None] | None = None

    @classmethod
    async def connect(cls, session: aiohttp.ClientSession, url: str, token: str = TOKEN) -> Client:
        client = cls(await session.ws_connect(f"{url}/socket", headers={"Origin": url}))
        await client.socket.send_json({"token": token})
        client.last = await client.socket.receive_json(timeout=5.0)
        client._reader = asyncio.create_task(client._answer())
        return client

    async def begin(self, action: str = "dock", **dock: str) -> None:
        self.press += 1
        self._held = self.press
        await self.say(press=self.press, action=action, **dock)

    async def release(self) -> None:
        self._held = 0
        await self.say(release=self.press)

    async def stop(self) -> None:
        self._held = 0
        await self.say(stop=True)

    async def say(self, **message: Any) -> None:
        await self.socket.send_json({"seen": self.last["n"], **message})

    def fall_silent(self) -> None:
        """It answers nothing any more, and does not close the connection."""
        assert self._reader is not None
        self._reader.cancel()

    async def until(self, condition: Any, patience: float = 5.0) -> None:
        await until(lambda: condition(self.last), patience)

    async def _answer(self) -> None:
        async for message in self.socket:
            self.last = self.last | message.json()
            await self.say(**({"held": self._held} if self._held else {}))


async def until(condition: Any, patience: float = 5.0) -> None:
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        await asyncio.sleep(0.005)


Test = Callable[[FakePanel, aiohttp.ClientSession, str], Awaitable[None]]


def run(test: Test, timeout: float = 0.22, names: tuple[str, ...] = (), *, buttons: bool = True) -> None:
    async def main() -> None:
        panel = FakePanel(timeout, buttons=buttons)
        async with panel.served(names) as url, aiohttp.ClientSession() as http:
            await test(panel, http, url)

    asyncio.run(main())


async def closed(socket: aiohttp.ClientWebSocketResponse) -> int | None:
    """The code with which the server closes."""
    while not socket.closed:
        await socket.receive(timeout=5.0)
    return socket.close_code
