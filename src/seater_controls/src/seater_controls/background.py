"""Work in a thread of its own, which dies with the process."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod

_ENDS_WITHIN = 2.0  # [s] it is waited for


class Background(ABC):
    """`_run` is the work, until `_stop` is set."""

    def __init__(self) -> None:
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> None:
        """From now on."""
        self._thread.start()

    def stop(self) -> None:
        """Soon."""
        self._stop.set()
        self._thread.join(_ENDS_WITHIN)

    @property
    def alive(self) -> bool:
        """The thread runs."""
        return self._thread.is_alive()

    @abstractmethod
    def _run(self) -> None: ...
