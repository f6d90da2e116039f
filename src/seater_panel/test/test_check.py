"""The doctor's results over a real connection: who may ask, when, and what becomes of a doctor that fails."""

from __future__ import annotations

import asyncio
import dataclasses
import json
import sys
import time
from typing import Any

import aiohttp
import pytest
from panels import TOKEN, FakePanel, run

from seater_panel.view.heard import Progress
from seater_panel.web.check import Check

AUTHORISED = {"Authorization": f"Bearer {TOKEN}"}
SAID = {"ok": False, "checks": [{"name": "odom rate", "result": "wrong", "what": "2 Hz", "remedy": "look at it"}]}


def doctor(panel: FakePanel, program: str, patience: float = 20.0) -> None:
    panel.panel = dataclasses.replace(panel.panel, check=Check([sys.executable, "-c", program], patience))


def saying(said: Any) -> str:
    return f"import sys; print({json.dumps(said)!r}); sys.exit(1)"


async def ask(http: aiohttp.ClientSession, url: str, headers: Any = AUTHORISED) -> tuple[int, Any]:
    async with http.post(f"{url}/doctor", headers=headers) as answer:
        return answer.status, await (answer.json() if answer.content_type == "application/json" else answer.text())


def checked(program: str, expected: tuple[int, Any], patience: float = 20.0, headers: Any = AUTHORISED) -> None:
    panel = FakePanel()
    doctor(panel, program, patience)

    async def main() -> None:
        async with panel.served() as url, aiohttp.ClientSession() as http:
            status, said = await ask(http, url, headers)
            assert (status, said) == expected or expected[1] in str(said), said

    asyncio.run(main())


def test_the_results_are_those_of_the_doctor() -> None:
    checked(saying(SAID), (200, SAID))


@pytest.mark.parametrize("headers", [{}, {"Authorization": "Bearer wrong"}, AUTHORISED | {"Origin": "http://evil.org"}])
def test_nothing_is_run_without_the_token_or_for_a_foreign_page(headers: dict[str, str]) -> None:
    checked("raise SystemExit(open('/nowhere'))", (403 if "Origin" in headers else 401, ""), headers=headers)


@pytest.mark.parametrize(
    ("program", "words"),
    [
        (
            "import sys; sys.exit('seater doctor: --chair: no such file')",
            "the doctor: seater doctor: --chair: no such file",
        ),
        ("print('[]')", "it says nothing"),
        ("import time; time.sleep(60)", "has not answered within 1 s"),
    ],
)
def test_a_doctor_that_fails_is_said(program: str, words: str) -> None:
    checked(program, (200, words), patience=1.0 if "sleep" in program else 20.0)


def test_two_pages_share_one_run_and_a_chair_that_drives_is_left_alone() -> None:
    panel = FakePanel()
    doctor(panel, "import time; time.sleep(0.3); " + saying(SAID | {"ok": True}))

    async def main() -> None:
        async with panel.served() as url, aiohttp.ClientSession() as http:
            begin = time.monotonic()
            first, second = await asyncio.gather(ask(http, url), ask(http, url))
            assert first == second and first[1]["ok"] and time.monotonic() - begin < 10.0
            progress = Progress(
                time=time.monotonic() + 60.0, action="dock", phase="FINAL", distance=1.0, elapsed=1.0, retries=0,
                marker_seen=True,
            )  # fmt: skip
            panel.heard = dataclasses.replace(panel.heard, progress=progress)
            assert (await ask(http, url))[0] == 409

    asyncio.run(main())


def test_without_a_doctor_it_says_so() -> None:
    async def test(_: FakePanel, http: aiohttp.ClientSession, url: str) -> None:
        assert (await ask(http, url))[0] == 404

    run(test)
