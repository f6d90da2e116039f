"""The parameters that are offered, with the defaults, ranges and meanings of their structs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from seater_common.geometry import Limits
from seater_common.params import ParameterError, as_mapping, load
from seater_nmpc.parameters import NmpcParameters, SequenceParameters, Weights

Values = dict[str, float | int]  # name -> value

SPEEDS = ("v_max", "omega_max")
TOLERANCES = (
    "corridor_half_width",
    "corridor_heading",
    "hold_position",
    "hold_heading",
    "release_position",
    "release_heading",
    "predock_position",
    "predock_heading",
    "standing_speed",
    "standing_time",
    "settle_time",
    "max_moves",
    "max_retries",
    "retry_distance",
    "nudge_speed",
)
_WEIGHT = "weight_"
_LARGEST_INT = 2**31 - 1


@dataclass(frozen=True)
class Offered:
    """One parameter, for whoever shows it."""

    name: str
    group: str
    doc: str  # with its unit
    default: float | int
    low: float | int
    high: float | int


def offered(parameters: NmpcParameters, limits: Limits) -> list[Offered]:
    """All, as configured. A speed may be what the chair's file says at most; it holds both ways."""
    fastest = replace(limits, v_max=max(limits.v_max, limits.v_reverse_max))
    speeds = [replace(entry, high=entry.default) for entry in _entries(fastest, SPEEDS, "speeds, both ways", "")]
    weights = [field.name for field in dataclasses.fields(Weights)]
    return [
        *speeds,
        *_entries(parameters.sequence, TOLERANCES, "sequence", ""),
        *_entries(parameters.control.weights, weights, "weights", _WEIGHT),
    ]


def changed(parameters: NmpcParameters, values: Mapping[str, float | int]) -> NmpcParameters:
    """With the tolerances and weights of `values`.

    Raises:
        ParameterError: a value is not finite, of the wrong type or out of range; names them all.
    """
    sequence = as_mapping(parameters.sequence) | {name: values[name] for name in TOLERANCES}
    weights = {f.name: values[_WEIGHT + f.name] for f in dataclasses.fields(Weights)}
    control = replace(parameters.control, weights=load(Weights, weights, "weights"))
    return replace(parameters, control=control, sequence=load(SequenceParameters, sequence, "sequence"))


def check_speeds(values: Mapping[str, float | int], most: Mapping[str, float | int]) -> None:
    """Raises ParameterError: not finite, below the range of the struct, or faster than the chair's file allows."""
    load(Limits, as_mapping(Limits()) | {name: values[name] for name in SPEEDS}, "speeds")
    for name in SPEEDS:
        if values[name] > most[name]:
            raise ParameterError(f"{name}: is {values[name]}, must be <= {most[name]}, as the chair's file says")


def refusal(before: Mapping[str, float | int], after: Mapping[str, float | int], *, driving: bool) -> str:
    """Why these changes may not be made now; empty: they may. While a goal is active, speeds may fall."""
    if not driving:
        return ""
    different = [name for name in after if after[name] != before[name]]
    later = [name for name in different if name not in SPEEDS]
    if later:
        return f"{', '.join(later)}: may be changed between two goals only"
    raised = [name for name in different if not after[name] < before[name]]
    return f"{', '.join(raised)}: may only be lowered while a goal is active" if raised else ""


def _entries(instance: Any, names: tuple[str, ...] | list[str], group: str, prefix: str) -> Iterator[Offered]:
    fields = {field.name: field for field in dataclasses.fields(instance)}
    for name in names:
        meta, value = fields[name].metadata, getattr(instance, name)
        most = _LARGEST_INT if isinstance(value, int) else math.inf
        low, high = meta["low"], meta["high"]
        unit = f" [{meta['unit']}]" if meta["unit"] else ""
        kind = type(value)
        yield Offered(
            name=prefix + name,
            group=group,
            doc=meta["doc"] + unit,
            default=value,
            low=kind(-most if low is None else low),
            high=kind(most if high is None else high),
        )
