"""The web server over real connections: who holds, and what a bad connection does."""

import asyncio
import socket
import time

import aiohttp
import pytest
from panels import TOKEN, Client, FakePanel, run, until

from seater_panel.web import session

RELEASE = 0.3  # [s] the bar: from a lost connection to "let go"


def test_hold_release_and_stop() -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        client = await Client.connect(http, url)
        await client.begin()
        await until(lambda: panel.chair.goal == "dock")
        await asyncio.sleep(0.5)  # answers keep it
        assert panel.chair.held
        await client.until(lambda last: last["hold"]["holder"] == "you")
        await client.release()
        await until(lambda: not panel.chair.held and not panel.chair.goal)
        await client.begin("undock")
        await until(lambda: panel.chair.goal == "undock")
        await client.stop()
        await until(lambda: not panel.chair.held)
        assert panel.chair.words() == ["held", "dock", "let go", "cancel", "held", "undock", "let go", "cancel"]

    run(test, timeout=2.0)


def test_a_page_names_the_dock_of_its_goal() -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        client = await Client.connect(http, url)
        await client.begin("dock", dock="hall")
        await until(lambda: "dock hall" in panel.chair.words())

    run(test, timeout=2.0)


async def held(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> Client:
    """A page that holds; tried again where the machine is busy."""
    client = await Client.connect(http, url)
    for _ in range(20):
        await client.begin()
        await asyncio.sleep(0.15)
        if panel.chair.held:
            return client
    raise AssertionError("no press was held")


async def let_go_after(panel: FakePanel) -> float:
    """[s] from now."""
    start = time.monotonic()
    await until(lambda: not panel.chair.held)
    return panel.chair.said[[text for _, text in panel.chair.said].index("let go")][0] - start


@pytest.mark.parametrize("way", ["silent", "closed", "torn"])
def test_a_lost_connection_counts_as_let_go(way: str) -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        client = await held(panel, http, url)
        panel.chair.said.clear()
        if way == "silent":
            client.fall_silent()
        elif way == "closed":
            await client.socket.close()
        else:
            client.socket.get_extra_info("socket")._sock.shutdown(socket.SHUT_RDWR)
        assert await let_go_after(panel) < RELEASE

    # A connection that ends is noticed by itself, long before the time-out.
    run(test, timeout=0.22 if way == "silent" else 5.0)


def test_a_connection_that_is_always_late_drives_nothing() -> None:
    """Every answer comes 0.4 s late, in order and complete, as through a full buffer."""

    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        client = await Client.connect(http, url)
        client.fall_silent()
        ticks: list[tuple[float, int]] = []
        await client.say(press=1, action="dock")
        end = time.monotonic() + 1.5
        while time.monotonic() < end:
            if not ticks or time.monotonic() - ticks[-1][0] > 0.0:
                ticks.append((time.monotonic(), (await client.socket.receive_json(timeout=2.0))["n"]))
            while ticks and (time.monotonic() - ticks[0][0] >= 0.4 or len(ticks) == session.WINDOW):
                await asyncio.sleep(max(0.0, ticks[0][0] + 0.4 - time.monotonic()))
                await client.socket.send_json({"seen": ticks.pop(0)[1], "held": 1})
        assert not panel.chair.held
        spans = [time for time, text in panel.chair.said if text in ("held", "let go")]
        assert not spans or spans[1] - spans[0] < RELEASE

    run(test)


def test_two_holders() -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        first, second = await Client.connect(http, url), await Client.connect(http, url)
        await first.begin()
        await first.until(lambda last: last["hold"]["holder"] == "you")
        await second.begin("undock")
        await second.until(lambda last: last["hold"]["refused"])
        assert second.last["hold"]["holder"] == "somebody"
        assert second.last["hold"]["refused"] == "somebody else holds a button"
        await second.release()  # not its press
        await asyncio.sleep(0.1)
        assert panel.chair.held
        await second.stop()  # but anybody may stop
        await until(lambda: not panel.chair.held)
        assert "undock" not in panel.chair.words()

    run(test, timeout=2.0)


def test_a_chair_that_takes_no_goal_says_why() -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        panel.chair.refused = "the docking node does not run"
        client = await Client.connect(http, url)
        await client.begin()
        await client.until(lambda last: last["hold"]["refused"] == "the docking node does not run")
        assert last_press(client) == 1
        assert panel.chair.words() == []

    run(test)


def last_press(client: Client) -> int:
    return int(client.last["hold"]["press"])


def test_without_buttons_nothing_can_be_done() -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        client = await Client.connect(http, url)
        assert client.last["hold"]["buttons"] is False
        await client.begin()
        await client.stop()
        await asyncio.sleep(0.3)
        assert panel.chair.words() == []

    run(test, buttons=False)


def test_a_page_that_reads_nothing_is_not_sent_more(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session, "PATIENCE", 1.0)

    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        client = await Client.connect(http, url)
        client.fall_silent()
        start, numbers = time.monotonic(), [client.last["n"]]
        while not client.socket.closed:
            message = await client.socket.receive(timeout=5.0)
            numbers += [message.json()["n"]] if message.type is aiohttp.WSMsgType.TEXT else []
        assert time.monotonic() - start > 0.5
        assert max(numbers) <= session.WINDOW + 2  # those that it had answered
        assert client.socket.close_code == session.NO_ANSWER

    run(test)


def test_a_slow_page_gets_fewer_images_and_always_the_newest() -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        headers = {"Authorization": f"Bearer {TOKEN}"}
        number, got = "0", []
        for i in range(1, 31):
            panel.frames.offer(b"%d" % i)
            if i % 10 == 0:
                async with http.get(f"{url}/image?after={number}", headers=headers) as answer:
                    number = answer.headers["X-Frame-Number"]
                    got.append(await answer.read())
        assert got == [b"10", b"20", b"30"]

    run(test)


def test_an_image_is_waited_for() -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        assert not panel.frames.wanted()
        panel.frames.offer(b"old")

        async def ask() -> bytes:
            async with http.get(f"{url}/image?after=1", headers={"Authorization": f"Bearer {TOKEN}"}) as answer:
                return await answer.read()

        asking = asyncio.create_task(ask())
        await until(panel.frames.wanted)
        await asyncio.sleep(0.1)
        assert not asking.done()
        panel.frames.offer(b"new")
        assert await asking == b"new"

    run(test)
