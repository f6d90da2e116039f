"""Export a bag: as CSV or Parquet, a table for each topic, or as MCAP, whole.

csv      for PlotJuggler (choose the column __time), pandas, a spreadsheet. A column for each number and text of a
         message, named by its path; times in seconds. Images, scans and other long arrays are left out, of lists of
         messages the first four are written.
parquet  the same with types, times as timestamps and long arrays as lists; the message definition is in the metadata.
mcap     every message byte for byte, with its definition, for Foxglove and whoever reads MCAP without ROS.
Exit status: 0 done, 2 wrong input.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from seater_common.command.ending import results_folder
from seater_tools.export.errors import ExportError
from seater_tools.export.mcap import export_mcap
from seater_tools.export.tables import export

FORMATS = ("csv", "parquet", "mcap")


def main(name: str, only: str | None = None, argv: Sequence[str] | None = None) -> int:
    """`only`: the format of a program for this one alone."""
    parser = argparse.ArgumentParser(
        prog=name, description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("bag", type=Path)
    if only is None:
        parser.add_argument("--format", choices=FORMATS, default="csv", help="(csv)")
    parser.add_argument("--topics", nargs="+", default=[], metavar="TOPIC", help="only these (all)")
    parser.add_argument("--force", action="store_true", help="overwrite earlier files")
    text = "(csv, parquet: a folder beside the bag, with its name; mcap: that of the bag)"
    parser.add_argument("--results", type=results_folder, metavar="DIR", help=text)
    options = parser.parse_args(argv)
    kind = only or options.format
    try:
        if kind == "mcap":
            path = (options.results or options.bag.parent) / f"{options.bag.stem}.mcap"
            written = export_mcap(options.bag, path, options.topics, force=options.force)
        else:
            folder = options.results or options.bag.with_suffix("")
            written = export(options.bag, folder, options.topics, force=options.force, kind=kind)
    except (ExportError, OSError) as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 2
    for path, rows in written.items():
        print(f"{rows:8d} {'messages' if kind == 'mcap' else 'rows'}  {path}")
    return 0
