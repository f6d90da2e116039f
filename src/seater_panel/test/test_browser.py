"""The page in a real browser: what it shows, and every way in which a finger leaves a button."""

from __future__ import annotations

import asyncio
import time
from dataclasses import replace

import numpy as np
import pytest
from browser import Browser, Page
from panels import FakePanel, until
from phone import DOCK, STOP, UNDOCK, is_let_go, press, run
from test_check import doctor, saying

from seater_common.geometry import Dock
from seater_panel.ros.image import to_jpeg


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


def test_one_of_several_docks_is_chosen_from_a_list(browser: Browser) -> None:
    async def test(panel: FakePanel, page: Page) -> None:
        hidden = "document.getElementById('docks').hidden"
        assert await page.value(hidden)  # there is one dock only
        panel.heard = replace(panel.heard, in_use=replace(Dock(), name="lab"), docks=("lab", "hall"))
        await page.until(f"!{hidden} && document.getElementById('docks').value === 'lab'")
        await page.value("document.getElementById('docks').value = 'hall'")
        await asyncio.sleep(0.3)  # the next views leave it as it is
        await press(panel, page)
        assert "dock hall" in panel.chair.words()

    run(browser, test)


def test_the_doctors_results_are_shown_faults_first_and_stop_stays(browser: Browser) -> None:
    said = {"ok": False, "checks": [
        {"name": "disk", "result": "ok", "what": "60 GB", "remedy": ""},
        {"name": "odom rate", "result": "wrong", "what": "<b>2 Hz", "remedy": "look at the driver"},
    ]}  # fmt: skip

    async def test(panel: FakePanel, page: Page) -> None:
        await page.value("document.getElementById('doctor-button').click()")
        await page.until("document.querySelectorAll('#doctor-list li').length === 2")
        text = await page.value("document.querySelector('#doctor-list li').textContent")
        assert text == "\u2718 odom rate <b>2 Hz\u2192 look at the driver"
        assert await page.value("document.getElementById('doctor-text').textContent") == "1 of 2 checks see a fault"
        await press(panel, page)  # Dock and Stop are not covered
        await page.until("document.getElementById('doctor-again').disabled === false")
        await page.touch("touchEnd")
        await is_let_go(panel)
        x, y = await page.middle(STOP)
        assert await page.value(f"document.elementFromPoint({x}, {y}).closest('button').id") == "stop"

    run(browser, test, prepare=lambda panel: doctor(panel, saying(said)))


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
