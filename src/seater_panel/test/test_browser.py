"""The page in a real browser: what it shows, and every way in which a finger leaves a button."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Iterator

import aiohttp
import numpy as np
import pytest
from browser import PROGRAM, Browser, Page
from panels import TOKEN, FakePanel, until
from wire import Wire

from seater_panel.ros.image import to_jpeg

pytestmark = pytest.mark.skipif(PROGRAM is None, reason="no chromium-headless-shell: ./seater setup installs it")

RELEASE = 0.3  # [s] the bar, from a lost connection to "let go"
# [s] In the other tests a button counts as held for so long without an answer of the page: a busy machine ends no
# press, and what does end within PROMPT has ended because the page has said so.
PATIENT = 4.0
PROMPT = 1.5
PHONE = {"width": 390, "height": 844, "touch": True}
DOCK, UNDOCK, STOP = "#dock-button", "#undock", "#stop"


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with Browser() as running:
        yield running


Test = Callable[[FakePanel, Page], Awaitable[None]]


def run(browser: Browser, test: Test, *, timeout: float = PATIENT, wire: Wire | None = None) -> None:
    """`test` on a phone that has opened the panel; at its end no script has failed."""

    async def main() -> None:
        panel, wire_used = FakePanel(timeout), wire or Wire()
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


def test_a_finger_holds_and_lets_go(browser: Browser) -> None:
    async def test(panel: FakePanel, page: Page) -> None:
        for selector, action in ((DOCK, "dock"), (UNDOCK, "undock")):
            await press(panel, page, selector)
            assert panel.chair.goal == action
            await asyncio.sleep(0.3)
            assert panel.chair.held
            await page.touch("touchEnd")
            await is_let_go(panel)
            await page.until(f"!document.querySelector('{selector}').classList.contains('held')")
            await until(lambda: not panel.chair.goal)

    run(browser, test)


WAYS = {
    "slides off": "",
    "the system takes the finger": "",
    "another window": "dispatchEvent(new Event('blur'))",
    "another tab": "Object.defineProperty(document, 'hidden', {value: true}),"
    "document.dispatchEvent(new Event('visibilitychange'))",
    "page closed": "location.href = 'about:blank'",
}


@pytest.mark.parametrize("way", WAYS)
def test_whatever_takes_the_finger_away_lets_go(browser: Browser, way: str) -> None:
    async def test(panel: FakePanel, page: Page) -> None:
        x, y = await press(panel, page)
        if way == "slides off":
            await page.touch("touchMove", (x, y - 300.0))
        elif way == "the system takes the finger":
            await page.touch("touchCancel")
        else:
            await page.value(WAYS[way])
        await is_let_go(panel)

    run(browser, test)


def test_stop_with_a_second_finger(browser: Browser) -> None:
    async def test(panel: FakePanel, page: Page) -> None:
        first = await press(panel, page)
        await page.touch("touchStart", first, await page.middle(STOP))
        await is_let_go(panel)
        assert panel.chair.words()[-1] == "cancel"
        await asyncio.sleep(0.3)
        assert not panel.chair.held  # though the first finger is still there

    run(browser, test)


def test_keys_hold_and_stop(browser: Browser) -> None:
    """Of a switch for people who cannot use the screen: it sends Space or Enter."""

    async def test(panel: FakePanel, page: Page) -> None:
        await page.value(f"document.querySelector('{DOCK}').focus()")
        await page.key("keyDown", " ")
        await until(lambda: panel.chair.goal == "dock")
        await page.key("keyUp", " ")
        await is_let_go(panel)
        await until(lambda: not panel.chair.goal)
        await page.key("keyDown", "Enter")
        await until(lambda: panel.chair.goal == "dock")
        await page.key("keyDown", "Escape")
        await is_let_go(panel)

    run(browser, test)


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


def test_while_somebody_else_holds_the_buttons_are_taken_but_stop_works(browser: Browser) -> None:
    async def test(panel: FakePanel, page: Page) -> None:
        panel.hold.press("another page", 1, "dock", time.monotonic() + 60.0, time.monotonic())
        await page.until(f"document.querySelector('{UNDOCK}').disabled")
        assert "somebody else" in await page.value(f"document.querySelector('{DOCK}').textContent")
        await until(lambda: panel.chair.held)
        await page.touch("touchStart", await page.middle(STOP))
        await is_let_go(panel)
        await page.until(f"!document.querySelector('{UNDOCK}').disabled")

    run(browser, test)


def test_without_the_token_the_page_shows_nothing(browser: Browser) -> None:
    async def main() -> None:
        panel = FakePanel()
        async with panel.served() as url, aiohttp.ClientSession() as http:
            for address in (f"{url}/", f"{url}/#token=wrong"):
                page = await browser.page(http)
                await page.begin(**PHONE)
                await page.open(address)
                await page.until("document.getElementById('title').textContent === 'No access'")
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


def test_image_and_scene_are_drawn(browser: Browser) -> None:
    async def test(panel: FakePanel, page: Page) -> None:
        red = np.zeros((360, 640, 3), np.uint8)
        red[:, :, 2] = 255
        panel.frames.offer(to_jpeg(red))
        await page.until("document.getElementById('image').naturalWidth === 640")
        pixel = """(canvas => {
            const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
            return data.filter((value, i) => i % 4 === 3 && value > 0).length;
        })(document.getElementById("scene"))"""
        assert await page.value(pixel) > 1000  # drawn on
        assert await page.value("document.documentElement.scrollHeight <= innerHeight")  # all of it fits

    run(browser, test)
