"""Who gets in over real connections: the token, foreign names and pages, nonsense, too many."""

import asyncio

import aiohttp
import pytest
from panels import PAGE, TOKEN, Client, FakePanel, closed, run
from yarl import URL

from seater_panel.web.server import FILES, MOST_PAGES, TOO_MANY, WRONG_TOKEN


@pytest.mark.parametrize("said", ['{"token": "wrong"}', "{}", "[]", "null", "nonsense", '{"token": 7}'])
def test_no_view_and_no_action_without_the_token(said: str) -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        opened = await http.ws_connect(f"{url}/socket", headers={"Origin": url})
        await opened.send_str(said)
        await opened.send_json({"seen": 1, "press": 1, "action": "dock"})
        assert (await opened.receive(timeout=5.0)).type is not aiohttp.WSMsgType.TEXT
        assert await closed(opened) == WRONG_TOKEN
        assert panel.chair.words() == []

    run(test)


def test_images_need_the_token() -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        panel.frames.offer(b"jpeg")
        for headers in ({}, {"Authorization": "Bearer wrong"}, {"Authorization": TOKEN}):
            async with http.get(f"{url}/image", headers=headers) as answer:
                assert answer.status == 401
                assert await answer.read() != b"jpeg"
        async with http.get(f"{url}/image", headers={"Authorization": f"Bearer {TOKEN}"}) as answer:
            assert (answer.status, await answer.read()) == (200, b"jpeg")

    run(test)


@pytest.mark.parametrize("path", ["/", "/socket", "/image"])
def test_a_foreign_name_or_page_is_refused(path: str) -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        for headers in ({"Host": "evil.example"}, {"Origin": "http://evil.example"}, {"Origin": "null"}):
            async with http.get(url + path, headers={"Authorization": f"Bearer {TOKEN}", **headers}) as answer:
                assert answer.status == 403
        with pytest.raises(aiohttp.WSServerHandshakeError, match="403"):
            await http.ws_connect(f"{url}/socket")  # no Origin

    run(test)


def test_a_name_that_was_given_is_known() -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        async with http.get(url, headers={"Host": "chair.local"}) as answer:
            assert answer.status == 200

    run(test, names=("chair.local",))


def test_the_page_loads_nothing_from_elsewhere_and_no_other_page_frames_it() -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        for path in ("/", "/panel.js", "/panel.css", "/link.js", "/buttons.js", "/scene.js", "/icon.svg"):
            async with http.get(url + path) as answer:
                assert answer.status == 200
                assert "default-src 'none'" in answer.headers["Content-Security-Policy"]
                assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]
                assert "://" not in (await answer.text()).replace("http://www.w3.org/2000/svg", "").replace(
                    "${scheme}://", ""
                )
        for path in ("/../package.xml", "/package.xml", "/%2e%2e/package.xml"):
            async with http.get(URL(url + path, encoded=True)) as answer:
                assert answer.status == 404

    run(test)


@pytest.mark.parametrize(
    "said",
    [
        '{"seen": 1e99}',
        '{"seen": 1e999}',
        '{"seen": 999999}',
        '{"seen": 1, "drive": 1}',
        "nonsense",
        "[" * 900,
        '{"press": 1}',
        "x" * 5000,
    ],
)
def test_a_page_that_talks_nonsense_is_dropped(said: str) -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        client = await Client.connect(http, url)
        client.fall_silent()
        await client.socket.send_str(said)
        await closed(client.socket)
        assert panel.chair.words() == []
        again = await Client.connect(http, url)  # the server lives
        assert "view" in again.last

    run(test)


def test_pages_are_few() -> None:
    async def test(panel: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        clients = [await Client.connect(http, url) for _ in range(MOST_PAGES)]
        one_more = await http.ws_connect(f"{url}/socket", headers={"Origin": url})
        assert await closed(one_more) == TOO_MANY
        await clients[0].socket.close()
        await asyncio.sleep(0.1)
        await Client.connect(http, url)

    run(test)


def test_no_page_file_is_forgotten() -> None:
    assert sorted(path.name for path in PAGE.iterdir()) == sorted(name for name, _ in FILES.values())
