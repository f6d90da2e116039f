"""The runs as a table: CSV always, Parquet where pyarrow is installed."""

from __future__ import annotations

import csv
import importlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

Row = Mapping[str, Any]


def flat(row: Row) -> dict[str, Any]:
    """One level: `axis.NAME`, drawn numbers by their keys, the start's three numbers; without the path."""
    kept = {key: value for key, value in row.items() if key not in ("variants", "numbers", "start", "path")}
    start = row.get("start") or [None] * 3
    kept |= dict(zip(("start_x_m", "start_y_m", "start_heading_rad"), start, strict=True))
    kept |= {f"axis.{axis}": variant for axis, variant in row.get("variants", {}).items()}
    return kept | row.get("numbers", {})


def write_tables(folder: Path, name: str, rows: Sequence[Row]) -> list[Path]:
    """Writes <name>.csv and, with pyarrow, <name>.parquet; returns the paths. What a run has not is empty."""
    table = [flat(row) for row in rows]
    columns = list(dict.fromkeys(key for row in table for key in row))
    path = folder / f"{name}.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, columns, restval="")
        writer.writeheader()
        writer.writerows({key: "" if value is None else value for key, value in row.items()} for row in table)
    return [path, *_write_parquet(folder / f"{name}.parquet", table, columns)]


def _write_parquet(path: Path, table: Sequence[Row], columns: Sequence[str]) -> list[Path]:
    try:
        arrow, parquet = importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    except ImportError:
        return []
    parquet.write_table(arrow.table({key: [row.get(key) for row in table] for key in columns}), path)
    return [path]
