"""A connection between page and server that can be made slow, or cut, as a wireless network does."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from urllib.parse import urlsplit

PIECE = 1 << 16  # bytes


class Wire:
    """`delay` [s] each way; `cut`: nothing comes through and nobody is told."""

    def __init__(self) -> None:
        self.delay, self.cut = 0.0, False

    @asynccontextmanager
    async def to(self, url: str) -> AsyncIterator[str]:
        """The address at this end."""
        target = urlsplit(url)
        tasks: set[asyncio.Task[None]] = set()

        async def accept(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            there = await asyncio.open_connection(target.hostname, target.port)
            for source, sink in ((reader, there[1]), (there[0], writer)):
                task = asyncio.create_task(self._carry(source, sink))
                tasks.add(task)
                task.add_done_callback(tasks.discard)

        server = await asyncio.start_server(accept, "127.0.0.1", 0)
        try:
            yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
        finally:
            server.close()
            for task in list(tasks):
                task.cancel()

    async def _carry(self, source: asyncio.StreamReader, sink: asyncio.StreamWriter) -> None:
        pieces: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()
        reading = asyncio.create_task(self._read(source, pieces))
        try:
            while True:
                arrived, piece = await pieces.get()
                while self.cut or time.monotonic() < arrived + self.delay:
                    await asyncio.sleep(0.005)
                if not piece:
                    break
                sink.write(piece)
                await sink.drain()
        except ConnectionError:
            pass
        finally:
            reading.cancel()
            with contextlib.suppress(ConnectionError, RuntimeError):
                sink.close()

    @staticmethod
    async def _read(source: asyncio.StreamReader, pieces: asyncio.Queue[tuple[float, bytes]]) -> None:
        piece = b"more"
        while piece:
            try:
                piece = await source.read(PIECE)
            except ConnectionError:
                piece = b""
            pieces.put_nowait((time.monotonic(), piece))
