"""Dock, measure and undock N times on the running chair, and say how well it repeats itself.

Needs wheelchair.launch (or sim.launch), and somebody who watches: the chair drives by itself. It begins where the chair
stands; each further docking begins at the predock point. The final errors are those that the images show while the
chair stands docked. Results: table, CSV, JSON and a picture. Ctrl-C cancels the goal, the chair stands, and what was
done is reported.
Exit status: 0 all docked, 1 not all, 2 nobody answers or wrong input, 130 interrupted.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable

from seater_common.command.ending import INTERRUPTED, results_folder
from seater_common.files.whole import write_whole
from seater_tools.repeat.report import as_csv, as_json, describe, draw, line
from seater_tools.repeat.session import Chair, Docked, Session
from seater_tools.repeat.statistics import repeatability


def add_options(parser: argparse.ArgumentParser) -> None:
    """One has no default."""
    parser.add_argument("times", type=int, metavar="N", help="how many dockings")
    parser.add_argument("--dock-id", default="", help="of several docks: its name (the configured dock)")
    parser.add_argument("--pause", type=float, default=2.0, metavar="S", help="standing between two goals [s] (2)")
    parser.add_argument("--yes", action="store_true", help="do not ask before the first movement")
    parser.add_argument(
        "--results", type=results_folder, default="results/repeat", metavar="DIR", help="(results/repeat)"
    )


def check(options: argparse.Namespace, parser: argparse.ArgumentParser) -> None:
    """Ends the program (2) where an option is wrong."""
    if not 1 <= options.times <= 10000:
        parser.error(f"N: is {options.times}, must be 1 to 10000")
    if not 0.0 <= options.pause <= 3600.0:
        parser.error(f"--pause: is {options.pause}, must be 0 to 3600")


def agreed(options: argparse.Namespace) -> bool:
    """Whether somebody has said that the chair may drive."""
    if options.yes:
        return True
    print(f"The chair will dock and undock {options.times} times by itself. Is the way free, and somebody at the")
    print("emergency stop? Type yes: ", end="", flush=True)
    return sys.stdin.readline().strip().lower() == "yes"


def run(options: argparse.Namespace, chair: Chair, sleep: Callable[[float], None] = time.sleep) -> int:
    """Raises what `chair` raises, after the report of what was done, and OSError."""
    session = Session(chair, options.times, lambda: sleep(options.pause))
    dockings: list[Docked] = []
    ended = "interrupted"
    try:
        for docked in session.run():
            dockings.append(docked)
            print(line(len(dockings), options.times, docked), flush=True)
        ended = session.ended
    except KeyboardInterrupt:
        print("\ninterrupted: the goal is cancelled, the chair stands")
    finally:
        _report(options, dockings, ended)
    if ended == "interrupted":
        return INTERRUPTED
    return 0 if len(dockings) == options.times and all(d.success for d in dockings) else 1


def _report(options: argparse.Namespace, dockings: list[Docked], ended: str) -> None:
    found = repeatability(dockings)
    print(f"\n{describe(found)}")
    if ended != "all done":
        print(f"ended early: {ended}")
    if not dockings:
        return
    write_whole(options.results / "repeat.csv", as_csv(dockings), overwrite=True)
    write_whole(options.results / "repeat.json", as_json(dockings, found, ended), overwrite=True)
    draw(dockings, found, options.results / "repeat.png")
    print("\n" + "\n".join(f"  {options.results / name}" for name in ("repeat.csv", "repeat.json", "repeat.png")))
