"""The newest camera image. Whoever asks gets it when it is newer than the last one that he has got.

A page asks for the next image when it has shown one, so a slow page gets fewer images, and none waits in a queue.
"""

from __future__ import annotations

import asyncio
import threading
import time

WANTED_FOR = 3.0  # [s] after the last question images are still wanted


class Frames:
    """`offer` may be called by any thread, the rest belongs to the thread of the event loop."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._jpeg, self._number = b"", 0
        self._asked = float("-inf")
        self._loop: asyncio.AbstractEventLoop | None = None
        self._arrival = asyncio.Event()

    def attach(self, loop: asyncio.AbstractEventLoop) -> None:
        """Before the first question: the loop in which `newer` is awaited."""
        self._loop = loop

    def offer(self, jpeg: bytes) -> None:
        """A new image replaces the one before, whether or not somebody has seen that."""
        with self._lock:
            self._jpeg, self._number = jpeg, self._number + 1
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._announce)

    def wanted(self) -> bool:
        """Whether a page has asked lately: else nobody needs to draw images."""
        return time.monotonic() - self._asked <= WANTED_FOR

    async def newer(self, after: int, patience: float) -> tuple[int, bytes] | None:
        """Number and JPEG of an image that is not number `after`; None: none came within `patience` [s]."""
        end = time.monotonic() + patience
        while True:
            self._asked = time.monotonic()
            arrival = self._arrival
            with self._lock:
                if self._number not in (0, after):
                    return self._number, self._jpeg
            try:
                await asyncio.wait_for(arrival.wait(), end - time.monotonic())
            except TimeoutError:
                return None

    def _announce(self) -> None:
        """Wakes all that wait; the next one to ask waits for the next image."""
        self._arrival.set()
        self._arrival = asyncio.Event()
