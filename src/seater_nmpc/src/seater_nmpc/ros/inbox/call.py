"""One call of a service, answered by the worker's thread."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable

PATIENCE = 5.0  # [s] of wall time for the answer
FRESH = 2.0  # [s] that a call may wait for the worker: later, the chair would drive off by surprise


class Call:
    """On its way from the service's thread to the worker and back."""

    def __init__(self, work: Callable[[], str]) -> None:
        """`work` returns why what is asked for is not done; empty: it is."""
        self._work, self._asked = work, time.monotonic()
        self._answers: queue.Queue[str] = queue.Queue()

    def wait(self) -> str:
        """The worker's answer."""
        try:
            return self._answers.get(timeout=PATIENCE)
        except queue.Empty:
            return "the docking node does not answer in time"

    def work(self) -> None:
        """In the worker's thread, unless the call is old."""
        old = time.monotonic() - self._asked > FRESH
        self._answers.put("the docking node was busy for too long" if old else self._work())
