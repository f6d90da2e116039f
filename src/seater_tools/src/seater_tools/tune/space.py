"""What is searched: keys of controller.yaml, each between bounds around its value in the file."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from seater_common.params import ParameterError, load
from seater_nmpc.parameters import NmpcParameters

FACTOR = 3.0  # a value is searched between a third of what the file has and three times as much
ZERO_IS = 0.01  # where the file has 0, the search begins here

# Not searched: `x`, the unit of the cost; penalties, which are as large as they have to be; whatever is measured
# (prediction, observer) or decides what counts as docked.
TUNABLE = (
    "control/weights/y",
    "control/weights/heading",
    "control/weights/speed",
    "control/weights/reverse",
    "control/weights/acceleration",
    "control/weights/terminal",
    "control/weights/terminal_heading",
    "control/bay_deceleration",
    "sequence/settle_time",
)


@dataclass(frozen=True)
class Tunable:
    """One number, searched on a logarithmic scale."""

    key: str
    value: float  # in the file
    low: float
    high: float

    @property
    def begin(self) -> float:
        """Where the search begins: the file's value, where it is between the bounds."""
        return min(max(self.value, self.low), self.high)


def tunables(values: Mapping[str, Any], name: str, keys: Sequence[str] = TUNABLE) -> list[Tunable]:
    """Of the contents of controller.yaml, called `name`. Bounds are never wider than the ranges of the parameters.

    Raises:
        ParameterError: the file is wrong, or a key is no number of it.
    """
    parameters = load(NmpcParameters, values, name)
    if parameters.control.formulation != "docking":
        raise ParameterError(
            f"{name}: control/formulation: is {parameters.control.formulation!r}, must be 'docking' to be tuned"
        )
    return [_tunable(parameters, key, name) for key in keys]


def changes(found: Mapping[str, float]) -> dict[str, Any]:
    """As a variant of a campaign file has them: nested, below `controller`."""
    nested: dict[str, Any] = {}
    for key, value in found.items():
        *groups, last = key.split("/")
        place = nested
        for group in groups:
            place = place.setdefault(group, {})
        place[last] = value
    return {"controller": nested}


def _tunable(parameters: NmpcParameters, key: str, name: str) -> Tunable:
    place: Any = parameters
    *groups, last = key.split("/")
    for group in groups:
        place = getattr(place, group, None)
    fields = {field.name: field for field in dataclasses.fields(place)} if dataclasses.is_dataclass(place) else {}
    value = getattr(place, last, None)
    if last not in fields or not isinstance(value, float):
        raise ParameterError(f"{name}/{key}: cannot be tuned, must be a number with a decimal point")
    meta = fields[last].metadata
    middle = value if value > 0.0 else ZERO_IS
    low = max(middle / FACTOR, meta["low"] if meta["low"] is not None else -math.inf)
    high = min(middle * FACTOR, meta["high"] if meta["high"] is not None else math.inf)
    return Tunable(key, value, low, high)
