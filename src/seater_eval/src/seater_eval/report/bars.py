"""Bars (limits with what was measured), their table, results/<command>.json and the exit code that follows from
them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from seater_eval.report.tables import text_table

AT_MOST, AT_LEAST = "at most", "at least"


@dataclass(frozen=True)
class Bar:
    """One limit and what was measured. A value that could not be measured (None, or not finite) never meets it."""

    name: str
    value: float | None
    limit: float
    unit: str = ""
    sense: str = AT_MOST  # or AT_LEAST
    note: str = ""  # why there is no value, or under which condition

    def __post_init__(self) -> None:
        if self.sense not in (AT_MOST, AT_LEAST):
            raise ValueError(f"sense: is {self.sense!r}, must be {AT_MOST!r} or {AT_LEAST!r}")

    @property
    def met(self) -> bool:
        """Whether the value is on the right side of the limit; on the limit counts."""
        if self.value is None or not math.isfinite(self.value):
            return False
        return self.value <= self.limit if self.sense == AT_MOST else self.value >= self.limit

    def as_mapping(self) -> dict[str, Any]:
        """As it stands in the JSON file."""
        value = self.value if self.value is not None and math.isfinite(self.value) else None
        entry: dict[str, Any] = {"name": self.name, "value": value, "limit": self.limit, "met": self.met}
        entry |= {"sense": self.sense}
        if self.unit:
            entry["unit"] = self.unit
        if self.note:
            entry["note"] = self.note
        return entry


def all_met(bars: Sequence[Bar]) -> bool:
    """Whether every bar is met; nothing measured is not enough."""
    return bool(bars) and all(bar.met for bar in bars)


def bars_table(bars: Sequence[Bar]) -> str:
    """The bars for a person, one a line."""
    rows = []
    for bar in bars:
        measured = "not measured" if bar.value is None else f"{bar.value:.4g} {bar.unit}".rstrip()
        limit = f"{bar.sense} {bar.limit:.4g} {bar.unit}".rstrip()
        rows.append([bar.name, measured, limit, "yes" if bar.met else "NO", bar.note])
    return text_table(["bar", "measured", "limit", "met", "note"], rows, "lrrll")


def write_results(folder: str | Path, command: str, data: Mapping[str, Any], bars: Sequence[Bar]) -> Path:
    """Writes <folder>/<command>.json: the data and `bars`. Raises ValueError when the data has a key `bars` of its
    own."""
    if "bars" in data:
        raise ValueError("data: has a key 'bars' of its own")
    path = Path(folder) / f"{command}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    content = {"command": command, "bars": [bar.as_mapping() for bar in bars], **data}
    path.write_text(json.dumps(_plain(content), indent=2, allow_nan=False) + "\n")
    return path


def conclude(
    folder: str | Path, command: str, data: Mapping[str, Any], bars: Sequence[Bar], figures: Sequence[Path] = ()
) -> int:
    """Write the results, print the bars and where the files are; the exit code: 0 when all bars are met, else 1."""
    path = write_results(folder, command, data, bars)
    files = "\n".join(f"  {file}" for file in [path, *figures])
    print(f"\n{bars_table(bars)}\n\n{files}\n")
    return 0 if all_met(bars) else 1


def _plain(value: Any) -> Any:
    """NumPy's numbers and arrays as Python's; a number that is not finite as null, which JSON can hold."""
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
