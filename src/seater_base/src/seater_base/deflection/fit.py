"""A measured curve out of pairs of voltage and speed."""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from statistics import median

from seater_base.deflection.table import AxisTable
from seater_common.params import why

AXES = ("drive", "turn")
_COLUMNS = ("axis", "volts", "speed")
_STILL = {"drive": 0.01, "turn": 0.02}  # [m/s], [rad/s] up to which it stands: some counts of an encoder
_SPREAD = 0.15  # of the speeds of one voltage, of the fastest of all: else it is something else that moves the chair
_SAME = 5e-3  # [V] apart: one level


class FitError(ValueError):
    """The pairs make no table; in words."""


Pair = tuple[str, float, float]  # axis, [V], [m/s] or [rad/s]


def read_pairs(path: Path) -> list[Pair]:
    """Of a CSV file with the columns axis, volts, speed; with semicolons and decimal commas as well, as spreadsheets
    write it in many countries. Raises FitError, naming file and line."""
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()  # some programs put a byte order mark in front
        head = lines[0] if lines else ""
        delimiter = ";" if ";" in head else ","
        rows = list(csv.DictReader(lines, delimiter=delimiter, skipinitialspace=True))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FitError(f"cannot read {path}: {why(error)}") from error
    if not set(_COLUMNS) <= set(rows[0] if rows else _COLUMNS):
        raise FitError(f"{path}, line 1: must be {','.join(_COLUMNS)}, is {head!r:.60}")
    pairs: list[Pair] = []
    for number, row in enumerate(rows, start=2):
        axis, *texts = (str(row[name]) for name in _COLUMNS)
        if delimiter == ";":
            texts = [text.replace(",", ".") for text in texts]
        try:
            volts, speed = map(float, texts)
        except ValueError as error:
            raise FitError(f"{path}, line {number}: volts and speed must be numbers ({error})") from error
        if axis not in AXES or not (abs(volts) < 1e3 and abs(speed) < 1e3):  # not a number fails, too
            raise FitError(f"{path}, line {number}: axis is drive or turn, the other two are numbers")
        pairs.append((axis, volts, speed))
    return pairs


def fit(axis: str, pairs: Iterable[Pair], neutral: float) -> AxisTable:
    """The medians of each level. Where the chair gets no faster any more, the outer levels are left out.

    Raises:
        FitError: too few levels, one that disagrees with itself, or a curve that is not monotonic.
    """
    levels: dict[float, list[float]] = defaultdict(list)
    for _, volts, speed in sorted(pair for pair in pairs if pair[0] == axis):
        level = next((known for known in levels if abs(known - volts) < _SAME), volts)
        levels[level].append(speed)
    if len(levels) < 5:
        raise FitError(f"{axis}: {len(levels)} voltages, 5 at least make a curve")
    fastest = max(abs(speed) for speeds in levels.values() for speed in speeds)
    for volts, speeds in levels.items():
        if max(speeds) - min(speeds) > _SPREAD * fastest:
            raise FitError(f"{axis}: from {min(speeds):.3f} to {max(speeds):.3f} at {volts:.2f} V: measure anew")
    curve = sorted((volts, median(speeds)) for volts, speeds in levels.items())
    curve = _without_saturation([(v, 0.0 if abs(s) < _STILL[axis] else s) for v, s in curve], 0.02 * fastest)
    at, found = tuple(round(v, 3) for v, _ in curve), tuple(round(s, 4) for _, s in curve)
    try:
        return AxisTable(neutral, at[0], at[-1], at, found)
    except ValueError as error:
        raise FitError(f"{axis}: {error}") from error


def _without_saturation(curve: list[tuple[float, float]], same: float) -> list[tuple[float, float]]:
    """Without the levels at both ends beyond which the speed no longer changes by `same`."""

    def end(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
        while len(points) > 1 and points[-1][1] != 0.0 and abs(points[-1][1] - points[-2][1]) < same:
            points = points[:-1]
        return points

    return end(end(curve)[::-1])[::-1]


def as_yaml(tables: dict[str, AxisTable], origin: str) -> str:
    """config/deflection.yaml. `origin`: where the pairs come from, for its first lines."""
    lines = [
        "# Voltages of an analogue joystick's input, and the speeds that they make. Read by: base_driver.",
        f"# {origin}",
    ]
    for axis, unit in zip(AXES, ("m/s", "rad/s"), strict=True):
        t = tables[axis]
        lines += [
            f"{axis}:",
            f"  neutral: {t.neutral}  # [V] of the stick that was let go: the chair stands",
            f"  lowest: {t.lowest}  # [V] never less, whatever is asked for",
            f"  highest: {t.highest}  # [V] never more",
            f"  volts: {list(t.volts)}  # [V] measured at these, rising",
            f"  speeds: {list(t.speeds)}  # [{unit}] there; 0 in the deadband",
        ]
    return "\n".join(lines) + "\n"


def deadband(table: AxisTable) -> tuple[float, float]:
    """[V] between which it stands."""
    still = [v for v, speed in zip(table.volts, table.speeds, strict=True) if speed == 0.0]
    return still[0], still[-1]
