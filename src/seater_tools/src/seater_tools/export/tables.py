"""A CSV file for each topic of a bag."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from seater_tools.export.flat import Row, flat

TIME = "__time"  # [s] of arrival; PlotJuggler takes this column for the time by itself


class ExportError(ValueError):
    """There is nothing to write, or it is there already."""


def export(bag: Path, folder: Path, topics: Sequence[str], force: bool) -> dict[Path, int]:
    """Files and their numbers of rows. `topics`: only these; empty: all.

    Raises ExportError, and OSError: a file cannot be read or written.
    """
    import rosbag

    try:
        reader = rosbag.Bag(str(bag))
    except rosbag.ROSBagException as error:
        raise ExportError(f"{bag}: is no bag that can be read ({error}); rosbag reindex mends one cut off") from error
    with reader:
        there = {name.lstrip("/"): name for name in reader.get_type_and_topic_info().topics}
        wanted = [topic.lstrip("/") for topic in topics] or sorted(there)
        missing = [topic for topic in wanted if topic not in there]
        if missing or not wanted:
            raise ExportError(f"{bag}: has no {', '.join(missing) or 'messages'}; it has {', '.join(sorted(there))}")
        written = {}
        for topic in wanted:
            path = folder / f"{re.sub('[^A-Za-z0-9]+', '_', topic)}.csv"
            if path.exists() and not force:
                raise ExportError(f"{path} exists already; --force overwrites it")
            messages = reader.read_messages(topics=[there[topic]])
            rows = [{TIME: f"{at.secs}.{at.nsecs:09d}", **flat(message)} for _, message, at in messages]
            written[path] = write(path, rows)
    return written


def write(path: Path, rows: Iterable[Row]) -> int:
    """All columns that any row has, in the order in which they came; what a row does not have stays empty."""
    rows = list(rows)
    columns = list(dict.fromkeys(name for row in rows for name in row))
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return len(rows)
