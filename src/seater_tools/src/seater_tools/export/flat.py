"""A message as a row: its numbers and short texts by their paths, e.g. `twist.twist.linear.x`."""

from __future__ import annotations

from typing import Any

MOST_ENTRIES = 36  # of an array; a covariance has them, an image or a scan has more
MOST_MESSAGES = 4  # of an array of messages: markers, hypotheses

Row = dict[str, Any]


class Time(int):
    """[ns] of a stamp."""

    def __str__(self) -> str:
        """In seconds, exactly."""
        return f"{self // 10**9}.{self % 10**9:09d}"


def flat(message: Any, *, whole: bool = False) -> Row:
    """Times as Time, durations in seconds, booleans as 0 and 1. `whole`: arrays that are too long for columns of their
    own are kept as lists and bytes; else they are left out."""
    row: Row = {}
    _add(row, "", message, whole)
    return row


def _add(row: Row, path: str, value: Any, whole: bool) -> None:
    if hasattr(value, "to_sec"):
        # A time never is negative; a duration has the same fields.
        row[path] = Time(value.to_nsec()) if value.secs >= 0 else value.to_sec()
    elif hasattr(value, "_slot_types"):
        for name in value.__slots__:
            _add(row, f"{path}.{name}" if path else name, getattr(value, name), whole)
    elif isinstance(value, bool):
        row[path] = int(value)
    elif isinstance(value, int | float | str):
        row[path] = value
    elif isinstance(value, list | tuple):
        _add_array(row, path, value, whole)
    elif isinstance(value, bytes) and whole:
        row[path] = value


def _add_array(row: Row, path: str, values: list[Any] | tuple[Any, ...], whole: bool) -> None:
    row[f"{path}.size"] = len(values)
    messages = bool(values) and hasattr(values[0], "_slot_types")
    if messages or len(values) <= MOST_ENTRIES:
        for index, entry in enumerate(values[: MOST_MESSAGES if messages else None]):
            _add(row, f"{path}.{index}", entry, whole)
    elif whole:
        row[path] = list(values)
