"""A table for each topic of a bag: as CSV, or as Parquet."""

from __future__ import annotations

import csv
import importlib
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from seater_common.bags import open_bag
from seater_tools.export.errors import ExportError
from seater_tools.export.flat import Row, Time, flat

TIME = "__time"  # [s] of arrival; PlotJuggler takes this column for the time by itself
MISSING = "--format {} needs {}, which is not installed here (pip install -r tools/requirements_export.txt)"


def export(bag: Path, folder: Path, topics: Sequence[str], *, force: bool, kind: str = "csv") -> dict[Path, int]:
    """Files and their numbers of rows. `topics`: only these; empty: all. `kind`: csv, parquet.

    Raises ExportError, and OSError: a file cannot be written.
    """
    write = write_parquet() if kind == "parquet" else write_csv
    with open_bag(bag, ExportError) as file:
        written = {}
        for topic in choose(bag, list(file.topics), topics):
            path = folder / f"{re.sub('[^A-Za-z0-9]+', '_', topic)}.{kind}"
            check_new(path, force)
            rows, about = [], {}
            if kind == "parquet":
                first = next(file.raw([topic]))
                about = {"topic": first.topic, "type": first.kind} | first.connection
            for _, message, at in file.messages([topic]):
                rows.append({TIME: Time(at.to_nsec()), **flat(message, whole=kind == "parquet")})
            path.parent.mkdir(parents=True, exist_ok=True)
            write(path, rows, about)
            written[path] = len(rows)
    return written


def choose(bag: Path, there: Sequence[str], topics: Sequence[str]) -> list[str]:
    """Names without a leading slash. Raises ExportError: one is not there, or there is none."""
    wanted = [topic.lstrip("/") for topic in topics] or sorted(there)
    missing = [topic for topic in wanted if topic not in there]
    if missing or not wanted:
        raise ExportError(f"{bag}: has no {', '.join(missing) or 'messages'}; it has {', '.join(sorted(there))}")
    return wanted


def check_new(path: Path, force: bool) -> None:
    """Raises ExportError: it would be overwritten."""
    if path.exists() and not force:
        raise ExportError(f"{path} exists already; --force overwrites it")


def columns_of(rows: Sequence[Row]) -> list[str]:
    """All that any row has, in the order in which they came."""
    return list(dict.fromkeys(name for row in rows for name in row))


def write_csv(path: Path, rows: Sequence[Row], _: dict[str, str]) -> None:
    """What a row does not have stays empty; texts in one line."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, columns_of(rows), lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({k: " ".join(v.split()) if isinstance(v, str) else v for k, v in row.items()})


def write_parquet() -> Callable[[Path, Sequence[Row], dict[str, str]], None]:
    """A function like `write_csv`; times are timestamps of nanoseconds, and what is known of the topic, its message
    definition too, is in the metadata. Raises ExportError: pyarrow is missing."""
    try:
        arrow: Any = importlib.import_module("pyarrow")
        parquet: Any = importlib.import_module("pyarrow.parquet")
    except ImportError as error:
        raise ExportError(MISSING.format("parquet", "pyarrow")) from error

    def write(path: Path, rows: Sequence[Row], about: dict[str, str]) -> None:
        arrays = {}
        for name in columns_of(rows):
            values = [row.get(name) for row in rows]
            time = any(isinstance(value, Time) for value in values)
            arrays[name] = arrow.array(values, type=arrow.timestamp("ns") if time else None)
        parquet.write_table(arrow.table(arrays).replace_schema_metadata(about), str(path))

    return write
