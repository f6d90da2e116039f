"""One line of progress: rewritten in place on a terminal, one now and then elsewhere."""

from __future__ import annotations

import sys
import time
from typing import TextIO


class ProgressLine:
    """`show` may be called as often as one likes."""

    def __init__(self, stream: TextIO = sys.stderr, every: float = 2.0) -> None:
        self._stream = stream
        self._terminal = stream.isatty()
        self._every = 0.1 if self._terminal else every
        self._last = -1e9
        self._width = 0

    def show(self, text: str, always: bool = False) -> None:
        now = time.monotonic()
        if not always and now - self._last < self._every:
            return
        self._last = now
        if self._terminal:
            self._stream.write("\r" + text.ljust(self._width))
            self._width = len(text)
        else:
            self._stream.write(text + "\n")
        self._stream.flush()

    def end(self) -> None:
        if self._terminal and self._width:
            self._stream.write("\n")
            self._width = 0
