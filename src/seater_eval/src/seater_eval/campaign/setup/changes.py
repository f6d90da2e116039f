"""Changes of configuration files: nested mappings laid over them, with numbers that are drawn for each case."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from seater_common.params import ParameterError

BETWEEN = "between"


def drawn(changes: Any, rng: np.random.Generator, prefix: str) -> tuple[Any, dict[str, float]]:
    """The changes with a number in the place of every `{between: [low, high]}`, uniformly distributed.

    Also returned: each drawn number by its full key (`simulator/camera/rate`). Raises ParameterError, naming the key.
    """
    numbers: dict[str, float] = {}
    return _draw(changes, rng, prefix, numbers), numbers


def _draw(value: Any, rng: np.random.Generator, key: str, numbers: dict[str, float]) -> Any:
    if not isinstance(value, Mapping):
        return copy.deepcopy(value)
    if BETWEEN in value:
        low, high = _bounds(value, key)
        numbers[key] = float(rng.uniform(low, high))
        return numbers[key]
    return {name: _draw(entry, rng, f"{key}/{name}", numbers) for name, entry in value.items()}


def _bounds(value: Mapping[str, Any], key: str) -> tuple[float, float]:
    bounds = value[BETWEEN]
    numeric = isinstance(bounds, list) and all(isinstance(b, int | float) and math.isfinite(b) for b in bounds)
    if len(value) != 1 or not numeric or len(bounds) != 2 or bounds[0] > bounds[1]:
        raise ParameterError(f"{key}: is {dict(value)!r}, must be {{between: [low, high]}} with low <= high")
    return float(bounds[0]), float(bounds[1])


def merged(base: Any, changes: Any) -> Any:
    """`base` with `changes` laid over it. Mappings are merged key by key, all else (lists, too) is replaced."""
    if not (isinstance(base, Mapping) and isinstance(changes, Mapping)):
        return copy.deepcopy(changes)
    result = {key: copy.deepcopy(entry) for key, entry in base.items()}
    for key, entry in changes.items():
        result[key] = merged(result[key], entry) if key in result else copy.deepcopy(entry)
    return result
