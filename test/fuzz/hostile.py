"""Hostile messages: a good message of any ROS type, with some of its fields replaced by what nobody expects."""

from __future__ import annotations

import copy
import io
import math
import random
import re
from collections.abc import Callable, Iterator
from typing import Any

import genpy

Place = tuple[Any, Any, str]  # a message or list, its field or index, the field's type

FLOATS = (math.nan, math.inf, -math.inf, 0.0, -0.0, 1e-300, 1e6, -1e6, 1e300, -1e300, 1.7e308, -1.7e308)
LATEST = {"time": 2.0**32 - 1.0, "duration": 2.0**31 - 1.0}  # [s]
LARGEST = {"float32": 3.4e38, "float64": 1.7e308}
WORDS = ("", "odom", "/odom", "base_link", "dock", "moon", " ", "Ωµ\n", "camera_color_optical_frame", "x" * 5000)
SECONDS = (0, 1, 2**31, 2**32 - 1)
OVERSIZED = 300  # elements
_INTEGER = re.compile(r"(u?)int(\d+)|byte|char|bool")


class Hostile:
    """Draws from one seed, so that a failure can be repeated."""

    def __init__(self, seed: int | str) -> None:
        self.random = random.Random(seed)

    def spoil(self, message: Any) -> Any:
        """A copy as it arrives on the wire, with one field replaced, seldom several."""
        copied = _writable(copy.deepcopy(message))
        for _ in range(self.random.choice((1, 1, 1, 2, 5))):
            places = list(_places(copied))
            if places:
                owner, key, kind = self.random.choice(places)
                _set(owner, key, self._value(kind, _get(owner, key)))
        return as_received(copied)

    def _value(self, kind: str, before: Any) -> Any:
        if kind.endswith("[]"):
            return self._array(before)
        if kind.startswith("float"):
            return self._float(kind, before)
        if kind in ("time", "duration"):
            return self._time(kind, before)
        if kind == "string":
            return self.random.choice(WORDS)
        return self._integer(kind)

    def _array(self, before: list[Any]) -> list[Any]:
        return self.random.choice(([], before[:1], before[::-1], before * 2, (before * OVERSIZED)[:OVERSIZED]))

    def _float(self, kind: str, before: float) -> float:
        near = (-before, before + self.random.gauss(0.0, 1.0), self.random.gauss(0.0, 10.0))
        value = self.random.choice((*FLOATS, *near))
        most = LARGEST[kind]
        return max(-most, min(most, value)) if math.isfinite(value) else value

    def _time(self, kind: str, before: Any) -> Any:
        if self.random.random() < 0.5:
            seconds = self.random.choice(SECONDS if kind == "time" else (-(2**31), 0, 2**31 - 1))
            return type(before)(seconds, self.random.choice((0, 999999999)))
        shifted = before.to_sec() + self.random.choice((-5000.0, -10.0, -0.5, -0.02, 0.02, 0.5, 10.0, 5000.0))
        return type(before).from_sec(min(max(0.0, shifted), LATEST[kind]))

    def _integer(self, kind: str) -> int:
        match = _INTEGER.fullmatch(kind)
        assert match, kind
        bits = int(match[2] or 8)
        signed = match[2] is not None and not match[1]
        low, high = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if signed else (0, 2**bits - 1)
        return self.random.choice((low, high, 0, 1, self.random.randint(low, high)))


def as_received(message: Any) -> Any:
    """The message, serialized and deserialized."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return type(message)().deserialize(buffer.getvalue())


def numbers(message: Any) -> Iterator[float]:
    """Every floating point number in a message."""
    for owner, key, kind in _places(_writable(copy.deepcopy(message))):
        if kind in LARGEST:
            yield _get(owner, key)


def _writable(message: Any) -> Any:
    """The same message with lists where there are tuples or bytes."""
    _each(message, lambda owner, key, value: isinstance(value, tuple | bytes) and _set(owner, key, list(value)))
    return message


def _each(message: Any, act: Callable[[Any, Any, Any], Any]) -> None:
    for name, kind in zip(message.__slots__, message._slot_types, strict=True):
        if "[" in kind:
            act(message, name, getattr(message, name))
        for part in getattr(message, name) if "[" in kind else [getattr(message, name)]:
            if isinstance(part, genpy.Message):
                _each(part, act)


def _places(message: Any) -> Iterator[Place]:
    """Whatever can be replaced: single values, and lists whose length is free."""
    for name, kind in zip(message.__slots__, message._slot_types, strict=True):
        value, (element, _, length) = getattr(message, name), kind.partition("[")
        if length == "]":
            yield message, name, kind
        if length:
            for index, part in enumerate(value):
                yield from _places(part) if isinstance(part, genpy.Message) else [(value, index, element)]
        elif isinstance(value, genpy.Message):
            yield from _places(value)
        else:
            yield message, name, kind


def _get(owner: Any, key: Any) -> Any:
    return owner[key] if isinstance(owner, list) else getattr(owner, key)


def _set(owner: Any, key: Any, value: Any) -> None:
    if isinstance(owner, list):
        owner[key] = value
    else:
        setattr(owner, key, value)
