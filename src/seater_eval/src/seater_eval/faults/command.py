"""Faults, one after the other, each in a docking that runs freely: how it ends, where, and what a new goal does."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from seater_eval.faults.cases import CASES, PLACES, Case
from seater_eval.report.bars import Bar, conclude
from seater_eval.report.tables import text_table
from seater_eval.run.commands import make_parser
from seater_eval.run.progress import progress_bar

MOVED = 0.005  # [m] afterwards: noise of the truth's speed, no motion
CLAIMED = (0.02, 2.0)  # [m, deg] largest true error of a docking that counts as docked
_LONGEST = 400.0  # [s] of one trial
_QUICK = ("emergency stop pressed for 1 s", "camera frozen, fresh stamps")


def wrong(case: Case, row: dict[str, Any]) -> str:
    """What is not as it has to be; empty when all is."""
    if row["result"] not in case.codes:
        return f"{row['result']} instead of {' or '.join(sorted(case.codes))}"
    if row["result"] == "SUCCESS":
        off = row["position_error_m"] > CLAIMED[0] or abs(row["heading_error_deg"]) > CLAIMED[1]
        return "docked beside the dock" if off else ""
    if row["collisions"]:
        return f"{row['collisions']} collisions"
    if not row["rest_s"] <= case.rest:
        return f"at rest after {row['rest_s']:.1f} s, limit {case.rest:.1f} s"
    if row["moved_afterwards_m"] > MOVED:
        return f"moved by {row['moved_afterwards_m']:.3f} m afterwards"
    if case.recovers and row.get("again") != "SUCCESS":
        return f"a new goal ended with {row.get('again')}"
    return ""


def _trial(number: int, place: str, folder: Path) -> dict[str, Any]:
    words = [sys.executable, "-m", "seater_eval.ros.fault_trial", str(number), place, str(folder)]
    try:
        ran = subprocess.run(words, capture_output=True, text=True, timeout=_LONGEST)
        return dict(json.loads(ran.stdout.strip().splitlines()[-1]))
    except (subprocess.TimeoutExpired, IndexError, json.JSONDecodeError) as error:
        return {"fault": CASES[number].name, "place": place, "result": "NOT RUN", "text": repr(error)}


def main(description: str | None, arguments: list[str] | None = None) -> int:
    """Program entry: 0 all ended as they have to, 1 not, 2 wrong arguments."""
    parser = make_parser("fault_table", description)
    parser.add_argument("--match", default="", metavar="TEXT", help="only faults whose name contains it")
    parser.add_argument("--place", choices=PLACES, help="only there (default: both)")
    options = parser.parse_args(arguments)
    chosen = [n for n, case in enumerate(CASES) if options.match in case.name]
    if options.quick:
        chosen = [n for n in chosen if CASES[n].name in _QUICK]
    if not chosen:
        print(f"fault_table: no fault's name contains {options.match!r}", file=sys.stderr)
        return 2
    places = [options.place] if options.place else list(PLACES)
    trials = [(number, place) for number in chosen for place in places]
    rows, folder = [], options.results.resolve() / "fault_table_logs"
    with progress_bar("fault_table", len(trials)) as bar:
        for number, place in trials:
            row = _trial(number, place, folder)
            row["wrong"] = wrong(CASES[number], row)
            rows.append(row)
            bar.update()
    print(describe(rows))
    right = sum(not row["wrong"] for row in rows)
    bars = [Bar("faults that end as they have to", right, len(rows), "", "at least", f"of {len(rows)}")]
    return conclude(options.results, "fault_table", {"rows": rows}, bars)


def describe(rows: list[dict[str, Any]]) -> str:
    """A table, and below it the texts of the results."""
    head = ["fault", "where", "result", "rest [s]", "way [m]", "touches", "new goal", "wrong"]
    cells = [
        [
            row["fault"],
            row["place"],
            row["result"],
            f"{row.get('rest_s', float('nan')):.2f}",
            f"{row.get('way_m', float('nan')):.2f}",
            str(row.get("collisions", "")),
            row.get("again", ""),
            row["wrong"],
        ]
        for row in rows
    ]
    texts = [f"{row['fault']} ({row['place']}): {row['text']}" for row in rows]
    return "\n".join([text_table(head, cells), "", *texts])
