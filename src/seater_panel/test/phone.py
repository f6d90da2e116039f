"""The panel, opened in a real browser as on a phone."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable

import aiohttp
from browser import Browser, Page
from panels import TOKEN, FakePanel, until
from wire import Wire

# [s] In the other tests a button counts as held for so long without an answer of the page: a busy machine ends no
# press, and what does end within PROMPT has ended because the page has said so.
PATIENT = 4.0
PROMPT = 1.5
PHONE = {"width": 390, "height": 844, "touch": True}
DOCK, UNDOCK, STOP = "#dock-button", "#undock", "#stop"


Test = Callable[[FakePanel, Page], Awaitable[None]]


def run(
    browser: Browser,
    test: Test,
    *,
    timeout: float = PATIENT,
    wire: Wire | None = None,
    prepare: Callable[[FakePanel], None] = lambda panel: None,
) -> None:
    """`test` on a phone that has opened the panel; at its end no script has failed."""

    async def main() -> None:
        panel, wire_used = FakePanel(timeout), wire or Wire()
        prepare(panel)
        async with panel.served() as url, wire_used.to(url) as near, aiohttp.ClientSession() as http:
            page = await browser.page(http)
            await page.begin(**PHONE)
            await page.open(f"{near}/#token={TOKEN}")
            await page.until("document.body.dataset.link === 'open'")
            await page.until("document.getElementById('title').textContent === 'Ready'")
            await test(panel, page)
            assert page.errors == []

    asyncio.run(main())


async def press(panel: FakePanel, page: Page, selector: str = DOCK) -> tuple[float, float]:
    """A finger goes down and the chair drives; where the finger is."""
    place = await page.middle(selector)
    await page.touch("touchStart", place)
    await until(lambda: panel.chair.goal and panel.chair.held)
    await page.until(f"document.querySelector('{selector}').classList.contains('held')")
    return place


async def is_let_go(panel: FakePanel, within: float = PROMPT) -> None:
    start = time.monotonic()
    await until(lambda: not panel.chair.held)
    assert time.monotonic() - start < within
