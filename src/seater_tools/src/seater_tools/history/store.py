"""The file: lines are appended whole, and the oldest ones go when it grows too long."""

from __future__ import annotations

import csv
import fcntl
import os
from pathlib import Path

from seater_common.files.whole import write_whole
from seater_common.params import why
from seater_tools.history.docking import COLUMNS, Docking, HistoryError, as_line, header, of_row

MOST, KEPT = 5000, 4000  # lines: beyond MOST the newest KEPT stay; 250 bytes each, so the file stays below 2 MB


def append(path: Path, docking: Docking) -> None:
    """One write under a lock of its own file: a reader, a second writer or a power cut finds whole lines.

    Raises OSError: it cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.with_name(f".{path.name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        _put_other_format_aside(path)
        line = as_line(docking) if path.exists() else header() + as_line(docking)
        if path.exists() and not _ends_a_line(path):
            line = "\n" + line  # the power was cut in the middle of the last one
        file = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        try:
            os.write(file, line.encode())
            os.fsync(file)
        finally:
            os.close(file)
        _bound(path)


def read(path: Path) -> tuple[list[Docking], int]:
    """All dockings in the order of the file, and how many lines are no dockings.

    Raises HistoryError: there is no such file, or it is no history.
    """
    try:
        with path.open(newline="", errors="replace") as file:
            rows = list(csv.reader(file))
    except (OSError, csv.Error) as error:
        first = " (wheelchair.launch writes it with the first docking)" if isinstance(error, FileNotFoundError) else ""
        raise HistoryError(f"cannot read {path}: {why(error)}{first}") from error
    if not rows or tuple(rows[0]) != COLUMNS:
        raise HistoryError(f"{path}: is no history of dockings (first line: {','.join(rows[0][:3]) if rows else ''})")
    dockings, damaged = [], 0
    for row in rows[1:]:
        try:
            dockings.append(of_row(row))
        except HistoryError:
            damaged += row != []
    return dockings, damaged


def _bound(path: Path) -> None:
    lines = path.read_bytes().splitlines(keepends=True)
    if len(lines) > MOST + 1:
        write_whole(path, b"".join([lines[0], *lines[-KEPT:]]), overwrite=True)


def _ends_a_line(path: Path) -> bool:
    with path.open("rb") as file:
        size = file.seek(0, os.SEEK_END)
        if size == 0:
            return True
        file.seek(-1, os.SEEK_END)
        return file.read(1) == b"\n"


def _put_other_format_aside(path: Path) -> None:
    """What another version has written stays, beside the new file."""
    if path.exists() and path.open("rb").readline() != header().encode():
        path.replace(path.with_name(f"{path.name}.{int(path.stat().st_mtime)}"))
