"""The page in a real browser over connections that break, are slow, or that it should not have."""

from __future__ import annotations

import asyncio
import time

import aiohttp
from browser import Browser, Page
from panels import TOKEN, FakePanel
from phone import DOCK, PHONE, is_let_go, run
from wire import Wire

RELEASE = 0.3  # [s] the bar, from a lost connection to "let go"


def test_a_connection_that_breaks(browser: Browser) -> None:
    """The chair stands within the bar. The page says so, comes back, and the finger that stayed drives nothing."""
    wire = Wire()

    async def test(panel: FakePanel, page: Page) -> None:
        for _ in range(20):  # a busy machine may end a press by itself
            await page.touch("touchStart", await page.middle(DOCK))
            await asyncio.sleep(0.5)
            if panel.chair.held:
                break
            await page.touch("touchEnd")
        assert panel.chair.held
        wire.cut = True
        await is_let_go(panel, RELEASE)
        await page.until("document.body.dataset.link === 'lost'")
        assert "Connection lost" in await page.value("document.getElementById('notice').textContent")
        # The gate may do something else by now, and nothing of what is said is cut off on a small phone.
        assert await page.value("document.getElementById('gate').textContent") == "\u2013"
        for width in (320, 390):
            await page.begin(width, 568, touch=True)
            assert await page.value("document.documentElement.scrollWidth") == width
        wire.cut = False
        await page.until("document.body.dataset.link === 'open'")
        await asyncio.sleep(0.5)
        assert not panel.chair.held

    run(browser, test, timeout=0.22, wire=wire)


def test_over_a_slow_connection_nothing_drives_and_the_page_says_why(browser: Browser) -> None:
    wire = Wire()

    async def test(panel: FakePanel, page: Page) -> None:
        wire.delay = 0.3  # each way
        await asyncio.sleep(1.0)
        await page.touch("touchStart", await page.middle(DOCK))
        await page.until("document.getElementById('notice').textContent.includes('too slow')")
        assert panel.chair.words() == []
        await page.touch("touchEnd")
        # What it shows is never older than the way: no view waits in a queue.
        panel.chair.refused = "mark"
        start = time.monotonic()
        await page.touch("touchStart", await page.middle(DOCK))
        await page.until("document.getElementById('notice').textContent.includes('Mark')")
        assert time.monotonic() - start < 2.5

    run(browser, test, timeout=0.22, wire=wire)


def test_without_the_token_the_page_shows_nothing(browser: Browser) -> None:
    async def main() -> None:
        panel = FakePanel()
        async with panel.served() as url, aiohttp.ClientSession() as http:
            for address, said in ((f"{url}/", "no token"), (f"{url}/#token=wrong", "wrong token")):
                page = await browser.page(http)
                await page.begin(**PHONE)
                await page.open(address)
                await page.until("document.getElementById('title').textContent === 'No access'")
                assert await page.value("document.getElementById('link').textContent") == said
                assert await page.value("document.getElementById('image').naturalWidth") == 0

    asyncio.run(main())


def test_a_foreign_page_cannot_connect(browser: Browser) -> None:
    """Even one that knows the token."""

    async def main() -> None:
        panel = FakePanel()
        async with panel.served() as url, aiohttp.ClientSession() as http:
            page = await browser.page(http)
            await page.begin(**PHONE)
            address = url.replace("http", "ws")
            opened = f"""new Promise(resolve => {{
                const socket = new WebSocket("{address}/socket");
                socket.onopen = () => resolve("open");
                socket.onerror = () => resolve("refused");
            }})"""
            assert await page.value(opened) == "refused"
            image = f"""fetch("{url}/image", {{headers: {{Authorization: "Bearer {TOKEN}"}}}})
                .then(() => "open", () => "refused")"""
            assert await page.value(image) == "refused"

    asyncio.run(main())
