"""Names of the numbers in a message's file."""

from __future__ import annotations

from typing import Any


def names_of(message: Any) -> dict[int, str]:
    """Number -> name of the constants of a generated message class."""
    found = {name: getattr(message, name) for name in dir(message) if name.isupper()}
    return {value: name for name, value in found.items() if isinstance(value, int)}
