"""A real browser without a screen, driven by the protocol of its developer tools (CDP) over a WebSocket."""

from __future__ import annotations

import asyncio
import base64
import ctypes
import itertools
import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import aiohttp

# The browser itself. What lies in PATH is a shell script round it: ended, it would leave the browser running.
PROGRAM = shutil.which("/usr/lib/chromium/chromium-headless-shell")
STARTS_WITHIN = 30.0  # [s]


class BrowserError(RuntimeError):
    """The browser, or the script that it was given, failed."""


class Page:
    """One page. Points are in CSS pixels."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._socket, self._numbers = socket, itertools.count(1)
        self._answers: dict[int, asyncio.Future[Any]] = {}
        self.errors: list[str] = []  # of the page's scripts, and of its policy
        self._reader = asyncio.create_task(self._read())

    async def call(self, method: str, **parameters: Any) -> Any:
        number = next(self._numbers)
        self._answers[number] = asyncio.get_running_loop().create_future()
        await self._socket.send_json({"id": number, "method": method, "params": parameters})
        return await asyncio.wait_for(self._answers[number], 20.0)

    async def begin(
        self, width: int, height: int, *, scale: float = 1.0, touch: bool = False, dark: bool = True
    ) -> None:
        for domain in ("Page", "Runtime", "Log", "Network"):
            await self.call(f"{domain}.enable")
        await self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=touch
        )
        await self.call("Emulation.setTouchEmulationEnabled", enabled=touch)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        await self.call("Emulation.setEmulatedMedia", features=[scheme])

    async def open(self, url: str) -> None:
        await self.call("Page.navigate", url=url)
        await self.until("document.readyState === 'complete' && location.href !== 'about:blank'")

    async def value(self, expression: str) -> Any:
        answer = await self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise BrowserError(str(answer["exceptionDetails"]))
        return answer["result"].get("value")

    async def until(self, expression: str, patience: float = 20.0) -> None:
        """Waits until the expression is true on the page."""
        end = time.monotonic() + patience
        while not await self.value(f"Boolean({expression})"):
            if time.monotonic() > end:
                raise BrowserError(f"not within {patience:.0f} s: {expression}")
            await asyncio.sleep(0.02)

    async def middle(self, selector: str) -> tuple[float, float]:
        box = f"document.querySelector({json.dumps(selector)}).getBoundingClientRect()"
        x, y = await self.value(f"(b => [b.x + b.width / 2, b.y + b.height / 2])({box})")
        return float(x), float(y)

    async def touch(self, kind: str, *points: tuple[float, float]) -> None:
        """`kind`: touchStart, touchMove, touchEnd or touchCancel; the places of all fingers that are on the screen."""
        places = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]
        await self.call("Input.dispatchTouchEvent", type=kind, touchPoints=places)

    async def key(self, kind: str, key: str) -> None:
        """`kind`: keyDown or keyUp."""
        code = {" ": "Space"}.get(key, key)
        await self.call("Input.dispatchKeyEvent", type=kind, key=key, code=code)

    async def screenshot(self, file: Path) -> None:
        answer = await self.call("Page.captureScreenshot", format="png")
        file.write_bytes(base64.b64decode(answer["data"]))

    async def _read(self) -> None:
        async for message in self._socket:
            content = json.loads(message.data)
            if "id" in content:
                self._answer(content)
            elif content["method"] == "Runtime.exceptionThrown":
                self.errors.append(str(content["params"]["exceptionDetails"]))
            elif content["method"] == "Log.entryAdded" and content["params"]["entry"]["source"] == "security":
                self.errors.append(content["params"]["entry"]["text"])

    def _answer(self, content: dict[str, Any]) -> None:
        waiting = self._answers.pop(content["id"])
        if waiting.done():
            return
        if "error" in content:
            waiting.set_exception(BrowserError(str(content["error"])))
        else:
            waiting.set_result(content["result"])


class Browser:
    """`with Browser() as browser:` - it runs inside, with an empty profile."""

    def __enter__(self) -> Browser:
        assert PROGRAM is not None
        self._folder = tempfile.TemporaryDirectory(prefix="seater_browser_", ignore_cleanup_errors=True)
        words = [PROGRAM, "--remote-debugging-port=0", f"--user-data-dir={self._folder.name}", "--disable-gpu"]
        words += ["--hide-scrollbars", *(["--no-sandbox"] if os.getuid() == 0 else [])]
        self._process = subprocess.Popen(
            [*words, "about:blank"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, preexec_fn=_end_with_parent
        )
        try:
            self._port = self._wait_for_port()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
        self._folder.cleanup()

    async def page(self, http: aiohttp.ClientSession) -> Page:
        """One more empty page."""
        async with http.put(f"http://127.0.0.1:{self._port}/json/new?about:blank") as answer:
            target = await answer.json()
        return Page(await http.ws_connect(target["webSocketDebuggerUrl"], max_msg_size=1 << 26))

    def _wait_for_port(self) -> int:
        file, end = Path(self._folder.name) / "DevToolsActivePort", time.monotonic() + STARTS_WITHIN
        while not file.exists() or not file.read_text().strip():
            if self._process.poll() is not None or time.monotonic() > end:
                raise BrowserError("the browser does not start")
            time.sleep(0.05)
        return int(file.read_text().split()[0])


def _end_with_parent() -> None:
    """Also when the tests are killed: the kernel then sends SIGTERM to the browser (prctl, PR_SET_PDEATHSIG)."""
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)
