"""Shares with their confidence intervals, and groups of runs by one of their parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

Row = Mapping[str, Any]

Z95 = 1.959964  # two-sided 95 % of the normal distribution
BINS = 6  # of a number, with equally many runs in each
FEW_VALUES = 8  # a number that takes no more values than that, again and again, is grouped by value
GROUP = 4  # runs at least in each bin


def wilson(successes: int, runs: int) -> tuple[float, float]:
    """95 % score interval of a share (Wilson, "Probable inference", JASA 22, 1927); (0, 1) for no runs."""
    if runs == 0:
        return 0.0, 1.0
    share, z2 = successes / runs, Z95**2
    middle = (share + z2 / (2 * runs)) / (1 + z2 / runs)
    half = Z95 / (1 + z2 / runs) * math.sqrt(share * (1 - share) / runs + z2 / (4 * runs**2))
    low, high = max(0.0, middle - half), min(1.0, middle + half)
    return (0.0 if successes == 0 else low), (1.0 if successes == runs else high)


@dataclass(frozen=True)
class Group:
    """Runs that have one parameter in common, or in one interval."""

    label: str
    runs: int
    docked: int

    @property
    def share(self) -> float:
        """Of docked runs."""
        return self.docked / self.runs

    @property
    def interval(self) -> tuple[float, float]:
        """95 % confidence."""
        return wilson(self.docked, self.runs)


@dataclass(frozen=True)
class Influence:
    """How the share of docked runs depends on one parameter."""

    parameter: str
    groups: list[Group]

    @property
    def evidence(self) -> float:
        """Chi-square of independence per degree of freedom; about 1 where the parameter does not matter."""
        docked, runs = sum(g.docked for g in self.groups), sum(g.runs for g in self.groups)
        share = docked / runs
        if len(self.groups) < 2 or share in (0.0, 1.0):
            return 0.0
        square = sum((g.docked - g.runs * share) ** 2 / (g.runs * share * (1.0 - share)) for g in self.groups)
        return square / (len(self.groups) - 1)


def influences(rows: Sequence[Row]) -> list[Influence]:
    """Of every axis, every drawn number and the start; the one with the clearest influence first."""
    found = []
    for axis in dict.fromkeys(axis for row in rows for axis in row.get("variants", {})):
        values = [row.get("variants", {}).get(axis) for row in rows]
        found.append(Influence(axis, _by_value(rows, values)))
    names = dict.fromkeys(name for row in rows for name in row.get("numbers", {}))
    series = {name: [row.get("numbers", {}).get(name) for row in rows] for name in names}
    for i, name in enumerate(("start x [m]", "start y [m]", "start heading [rad]")):
        series[name] = [row["start"][i] if row.get("start") else None for row in rows]
    found += [Influence(name, _by_number(rows, values)) for name, values in series.items()]
    found = [influence for influence in found if len(influence.groups) > 1]
    return sorted(found, key=lambda influence: -influence.evidence)


def _by_value(rows: Sequence[Row], values: Sequence[Any]) -> list[Group]:
    """In the order of their first appearance; rows without a value are left out."""
    wanted = [value for value in dict.fromkeys(values) if value is not None]
    return [_group(str(wanted_value), rows, [value == wanted_value for value in values]) for wanted_value in wanted]


def _by_number(rows: Sequence[Row], values: Sequence[float | None]) -> list[Group]:
    numbers = np.array([math.nan if value is None else float(value) for value in values])
    known = numbers[np.isfinite(numbers)]
    if len(np.unique(known)) <= min(FEW_VALUES, len(known) // GROUP):
        return [_group(f"{value:.4g}", rows, (numbers == value).tolist()) for value in np.unique(known)]
    bins = min(BINS, len(known) // GROUP)
    if bins < 2:
        return []
    edges = np.quantile(known, np.linspace(0.0, 1.0, bins + 1))
    groups = []
    for i, (low, high) in enumerate(pairwise(edges)):
        inside = (numbers >= low) & ((numbers < high) | (i == bins - 1) & (numbers == high))
        groups.append(_group(f"{low:.3g} .. {high:.3g}", rows, inside.tolist()))
    return [group for group in groups if group.runs > 0]


def _group(label: str, rows: Sequence[Row], inside: Sequence[bool]) -> Group:
    members = [row for row, is_in in zip(rows, inside, strict=True) if is_in]
    return Group(label, len(members), sum(bool(row["docked"]) for row in members))
