"""What the dockings so far say: a table, trends, a picture, and warnings where something has changed.

wheelchair.launch writes one line per docking. Of one dock, since its last teaching. Changes are found by tests that
need no assumption on how values are distributed (docs/how-to/watch_the_dockings.md).
Exit status: 0 no drift, 1 something has changed, 2 no history, or wrong input.
"""

from __future__ import annotations

import argparse
import datetime
import sys
from pathlib import Path

from seater_tools.history.docking import HistoryError
from seater_tools.history.report import describe, draw
from seater_tools.history.store import read
from seater_tools.history.trends import of_dock, warnings_of

FILE = Path("~/.ros/seater_history.csv")  # as wheelchair.launch has it


def add_options(parser: argparse.ArgumentParser) -> None:
    """All have defaults."""
    parser.add_argument("--file", type=Path, default=FILE, help=f"the history ({FILE})")
    parser.add_argument("--dock", help="its name (that of the last docking)")
    parser.add_argument(
        "--since", type=_date, metavar="DATE", help="only dockings from this day on, e.g. after a repair"
    )
    parser.add_argument("--last", type=int, default=20, metavar="N", help="dockings in the table (20)")
    parser.add_argument("--picture", type=Path, default=Path("results/history.png"), metavar="FILE",
                        help="results/history.png")  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Raises HistoryError (nothing to show) and OSError (the picture cannot be written)."""
    if options.last < 1:
        raise HistoryError(f"--last: is {options.last}, must be at least 1")
    everything, damaged = read(options.file.expanduser())
    if damaged:
        print(f"seater history: {damaged} damaged lines of {options.file} are left out", file=sys.stderr)
    wanted = [d for d in everything if options.since is None or d.time.date() >= options.since]
    dockings = of_dock(wanted, options.dock) if wanted else []
    if not dockings:
        docks = ", ".join(sorted({docking.dock for docking in everything})) or "none"
        raise HistoryError(f"{options.file}: no docking fits; docks in it: {docks}")
    notices = warnings_of(dockings)
    print(describe(dockings, notices, options.last))
    draw(dockings, notices, options.picture)
    print(options.picture)
    return 1 if notices else 0


def _date(text: str) -> datetime.date:
    try:
        return datetime.date.fromisoformat(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is no date like 2026-11-27") from error
