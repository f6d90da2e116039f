"""Rows of a table that takes half an hour, in a file from the moment that they are measured."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TextIO

Row = dict[str, Any]
NOT_RUN = "NOT RUN"  # the result of a trial that could not be carried out; it is tried again


class RowFile:
    """JSON lines: {"state": ...} first, then a row each. `done` holds the rows of runs that were interrupted.

    Only rows of the same `state` (code and configuration that were measured) count. A file of another state is kept
    beside it as *.old.jsonl; `dropped` counts its rows. A last line that was cut off in the middle is measured again.
    """

    def __init__(self, path: Path, state: str) -> None:
        """Raises OSError where the file cannot be written."""
        self.path, self._state = path, state
        self.done: dict[tuple[str, str], Row] = {}  # by fault and place
        self.dropped = 0
        path.parent.mkdir(parents=True, exist_ok=True)
        head, *rows = _lines(path) or [{"state": state}]
        if head.get("state") == state:
            self.done = {(row["fault"], row["place"]): row for row in rows if row["result"] != NOT_RUN}
        else:
            self.dropped = len(rows)
            path.replace(path.with_suffix(".old.jsonl"))
        self._rewrite()

    def add(self, row: Row) -> None:
        """Keep one more row."""
        self.done[row["fault"], row["place"]] = row
        self._write(row)

    def close(self) -> None:
        """For now: the rows stay for a later run."""
        self._file.close()

    def finish(self, keys: Iterable[tuple[str, str]]) -> None:
        """The rows of these keys have gone into a table: no later run needs them."""
        self.close()
        self.done = {key: row for key, row in self.done.items() if key not in set(keys)}
        if self.done:
            self._rewrite()
            self.close()
        else:
            self.path.unlink(missing_ok=True)

    def _rewrite(self) -> None:
        self._file: TextIO = self.path.open("w")
        for entry in ({"state": self._state}, *self.done.values()):
            self._write(entry)

    def _write(self, entry: Row) -> None:
        self._file.write(json.dumps(entry) + "\n")
        self._file.flush()


def _lines(path: Path) -> list[Row]:
    """The complete entries; none where there is no such file."""
    entries: list[Row] = []
    for line in path.read_text(errors="replace").splitlines() if path.exists() else []:
        try:
            entries.append(dict(json.loads(line)))
        except (ValueError, TypeError):
            return entries
    return entries
