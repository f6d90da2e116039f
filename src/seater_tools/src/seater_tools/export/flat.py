"""A message as a row: its numbers and short texts by their paths, e.g. `twist.twist.linear.x`."""

from __future__ import annotations

from typing import Any

MOST_ENTRIES = 36  # of an array; a covariance has them, an image or a scan has more and is left out
MOST_MESSAGES = 4  # of an array of messages: markers, hypotheses

Row = dict[str, float | int | str]


def flat(message: Any) -> Row:
    """Times and durations in seconds, booleans as 0 and 1. Arrays that are too long are left out."""
    row: Row = {}
    _add(row, "", message)
    return row


def _add(row: Row, path: str, value: Any) -> None:
    if hasattr(value, "to_sec"):
        row[path] = f"{value.secs}.{value.nsecs:09d}" if value.secs >= 0 else value.to_sec()
    elif hasattr(value, "_slot_types"):
        for name in value.__slots__:
            _add(row, f"{path}.{name}" if path else name, getattr(value, name))
    elif isinstance(value, bool):
        row[path] = int(value)
    elif isinstance(value, int | float):
        row[path] = value
    elif isinstance(value, str):
        row[path] = " ".join(value.split())
    elif isinstance(value, list | tuple):
        most = MOST_MESSAGES if value and hasattr(value[0], "_slot_types") else MOST_ENTRIES
        row[f"{path}.size"] = len(value)
        if most == MOST_MESSAGES or len(value) <= most:
            for index, entry in enumerate(value[:most]):
                _add(row, f"{path}.{index}", entry)
