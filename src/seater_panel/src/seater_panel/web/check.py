"""The doctor's results for the page: its program is run, one at a time, and only while no goal runs."""

from __future__ import annotations

import asyncio
import json
import subprocess
from collections.abc import Sequence
from typing import Any

PATIENCE = 60.0  # [s] it takes some 5 s, on a busy computer more


class Check:
    """Of the thread of the event loop."""

    def __init__(self, words: Sequence[str], patience: float = PATIENCE) -> None:
        """`words`: command that prints `seater doctor --json`."""
        self._words, self._patience = list(words), patience
        self._running: asyncio.Task[dict[str, Any]] | None = None

    async def run(self) -> dict[str, Any]:
        """What it says: `ok`, `checks`; or `error`, in words. Who asks while it runs gets the same answer."""
        if self._running is None or self._running.done():
            self._running = asyncio.create_task(self._run())
        return await asyncio.shield(self._running)

    async def _run(self) -> dict[str, Any]:
        try:
            process = await asyncio.create_subprocess_exec(
                *self._words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE
            )
        except OSError as error:
            return {"error": f"the doctor cannot be started: {error}"}
        try:
            out, errors = await asyncio.wait_for(process.communicate(), self._patience)
        except TimeoutError:
            return {"error": f"the doctor has not answered within {self._patience:.0f} s: is the computer loaded?"}
        finally:
            if process.returncode is None:
                process.kill()
        try:
            said = json.loads(out)
            return {"ok": bool(said["ok"]), "checks": [{key: str(c[key]) for key in _KEYS} for c in said["checks"]]}
        except (ValueError, KeyError, TypeError):
            last = errors.decode(errors="replace").strip().splitlines()[-1:] or ["it says nothing"]
            return {"error": f"the doctor: {last[0]}"}


_KEYS = ("name", "result", "what", "remedy")
