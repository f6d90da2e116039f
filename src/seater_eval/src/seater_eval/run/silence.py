"""Libraries that print what nobody asked for."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def silence() -> Iterator[None]:
    """What C code prints meanwhile goes nowhere."""
    sys.stdout.flush()
    sys.stderr.flush()
    _flush_c_output()
    kept = [os.dup(1), os.dup(2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for target in (1, 2):
            os.dup2(nowhere, target)
        yield
    finally:
        _flush_c_output()
        for target, original in zip((1, 2), kept, strict=True):
            os.dup2(original, target)
            os.close(original)
        os.close(nowhere)


def _flush_c_output() -> None:
    """Of all C streams of the process: what is buffered would appear after the silence."""
    ctypes.CDLL(None).fflush(None)
