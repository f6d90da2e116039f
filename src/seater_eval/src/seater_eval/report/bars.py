"""What must be shown, as numbers: bars, their table, results/<command>.json and the exit code that follows from them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

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
    width = max([4, *(len(bar.name) for bar in bars)])
    lines = [f"  {'Bar':<{width}} {'measured':>14} {'limit':>22}   met"]
    for bar in bars:
        measured = "not measured" if bar.value is None else f"{bar.value:.4g} {bar.unit}".rstrip()
        limit = f"{bar.sense} {bar.limit:.4g} {bar.unit}".rstrip()
        note = f"   ({bar.note})" if bar.note else ""
        lines.append(f"  {bar.name:<{width}} {measured:>14} {limit:>22}   {'yes' if bar.met else 'NO'}{note}")
    return "\n".join(lines)


def text_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Columns as wide as they need; the first one to the left, the others to the right."""
    widths = [max(len(str(row[i])) for row in [head, *rows]) for i in range(len(head))]

    def line(cells: Sequence[str]) -> str:
        first, *others = (str(cell) for cell in cells)
        return "  " + "  ".join(
            [first.ljust(widths[0]), *(c.rjust(w) for c, w in zip(others, widths[1:], strict=True))]
        )

    return "\n".join([line(head), line(["-" * w for w in widths]), *(line(row) for row in rows)])


def write_results(folder: str | Path, command: str, data: Mapping[str, Any], bars: Sequence[Bar]) -> Path:
    """Writes <folder>/<command>.json: the data and `bars`. Raises ValueError when the data has a key `bars` of its own."""
    if "bars" in data:
        raise ValueError("data: has a key 'bars' of its own")
    path = Path(folder) / f"{command}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    content = {"command": command, "bars": [bar.as_mapping() for bar in bars], **data}
    path.write_text(json.dumps(_plain(content), indent=2, allow_nan=False) + "\n")
    return path


def conclude(
    folder: str | Path, command: str, data: Mapping[str, Any], bars: Sequence[Bar], images: Sequence[Path] = ()
) -> int:
    """Write the results, print the bars and where the files are; the exit code: 0 when all bars are met, else 1."""
    path = write_results(folder, command, data, bars)
    files = "\n".join(f"  {file}" for file in [path, *images])
    print(f"\n{bars_table(bars)}\n\n{files}\n")
    return 0 if all_met(bars) else 1


def spread(values: Any) -> dict[str, float | None]:
    """Median, 95th and 99th percentile and maximum of some numbers; None each when there are none."""
    numbers = sorted(float(value) for value in values if value is not None and math.isfinite(value))
    if not numbers:
        return {"median": None, "p95": None, "p99": None, "max": None}
    shares = {"median": 0.5, "p95": 0.95, "p99": 0.99, "max": 1.0}
    return {name: _quantile(numbers, share) for name, share in shares.items()}


def _quantile(numbers: list[float], share: float) -> float:
    """Linear interpolation between the order statistics."""
    place = share * (len(numbers) - 1)
    low = math.floor(place)
    high = min(low + 1, len(numbers) - 1)
    return numbers[low] + (place - low) * (numbers[high] - numbers[low])


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
