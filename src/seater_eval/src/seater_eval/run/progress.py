"""Progress of a command on a terminal (rewritten in place) or in a log (one line now and then)."""

from __future__ import annotations

import sys
import time
from typing import Any, TextIO

from tqdm import tqdm

TERMINAL_PERIOD, LOG_PERIOD = 0.1, 2.0  # [s] between two updates, at least


def progress_bar(label: str, total: int, *, done: int = 0, stream: TextIO | None = None) -> tqdm:
    """Counts parts of equal size: count, rate and remaining time. A context manager; `update()` after each part.

    Args:
        done: parts that an earlier run has finished; they do not count for the rate.
        stream: None: standard error.
    """
    stream = stream or sys.stderr
    on_terminal = stream.isatty()
    return tqdm(
        desc=label,
        total=total,
        initial=done,
        file=stream if on_terminal else _LogLines(stream),
        mininterval=TERMINAL_PERIOD if on_terminal else LOG_PERIOD,
        miniters=1,
        ascii=None if on_terminal else True,
    )


class _LogLines:
    """tqdm's output without its carriage returns: every update is a line."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> None:
        line = text.strip("\r\n ")
        if line:
            self._stream.write(line + "\n")

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


class StatusLine:
    """Free text that changes; `show` may be called as often as one likes."""

    def __init__(self, stream: TextIO = sys.stderr) -> None:
        self._stream = stream
        self._on_terminal = stream.isatty()
        self._period = TERMINAL_PERIOD if self._on_terminal else LOG_PERIOD
        self._last = -1e9
        self._width = 0

    def show(self, text: str, always: bool = False) -> None:
        """Writes `text` unless the last one is too recent; `always`: in any case."""
        now = time.monotonic()
        if not always and now - self._last < self._period:
            return
        self._last = now
        if self._on_terminal:
            self._stream.write("\r" + text.ljust(self._width))
            self._width = len(text)
        else:
            self._stream.write(text + "\n")
        self._stream.flush()

    def end(self) -> None:
        """What follows starts on a new line."""
        if self._on_terminal and self._width:
            self._stream.write("\n")
            self._width = 0
