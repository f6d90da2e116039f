"""One stage's word."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple


class Level(IntEnum):
    """The numbers of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


class Word(NamedTuple):
    """How bad it is, and cause and remedy."""

    level: Level
    text: str
