"""Faults, one after the other, each in a docking that runs freely: how it ends, where, and what a new goal does."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tqdm import tqdm

from seater_eval.faults.cases import CASES, PLACES, Case
from seater_eval.faults.row_file import NOT_RUN, RowFile
from seater_eval.report.bars import Bar, conclude
from seater_eval.report.tables import text_table
from seater_eval.run.commands import config_folder, make_parser
from seater_eval.run.long_run import exit_when_interrupted
from seater_eval.run.partial import fingerprint
from seater_eval.run.progress import progress_bar

MOVED = 0.005  # [m] afterwards: noise of the truth's speed, no motion
CLAIMED = (0.02, 2.0)  # [m, deg] largest true error of a docking that counts as docked
_LONGEST = 400.0  # [s] of one trial
_ENDS = 100.0  # [s] in which a trial that is told to ends its processes
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
    with (
        (folder / f"fault_{number}_{place}.trial.log").open("w") as log,
        # Its own process group: Ctrl-C on the terminal reaches us alone, and we end it in order.
        _ended_in_order(
            subprocess.Popen(words, stdout=subprocess.PIPE, stderr=log, text=True, start_new_session=True)
        ) as process,
    ):
        try:
            printed, _ = process.communicate(timeout=_LONGEST)
            return dict(json.loads(printed.strip().splitlines()[-1]))
        except (subprocess.TimeoutExpired, IndexError, json.JSONDecodeError) as error:
            return {"fault": CASES[number].name, "place": place, "result": NOT_RUN, "text": repr(error)}


@contextlib.contextmanager
def _ended_in_order(process: subprocess.Popen[str]) -> Iterator[subprocess.Popen[str]]:
    """Whatever happens: what the trial has launched must not go on beside the next one."""
    try:
        yield process
    finally:
        if process.poll() is None:
            process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(_ENDS)
            process.kill()
            process.wait()


def _state(config: Path) -> str:
    """Of all that is measured: Python code, configuration, programs and libraries that were built."""
    files = sorted(config.rglob("*.yaml"))
    for prefix in filter(None, os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)):
        files += [
            *Path(prefix, "lib").glob("libseater_*.so"),
            *Path(prefix, "lib", "seater_safety").glob("safety_gate"),
        ]
    return fingerprint("fault_table", files)


def _measure(trials: Mapping[tuple[str, str], int], rows: RowFile, folder: Path) -> None:
    """All that `rows` has not yet. `trials`: number of the case by fault and place."""
    left = [key for key in trials if key not in rows.done]
    with progress_bar("fault_table", len(trials), done=len(trials) - len(left)) as bar:
        for name, place in left:
            row = _trial(trials[name, place], place, folder)
            row["wrong"] = wrong(CASES[trials[name, place]], row)
            rows.add(row)
            said = f"{name} ({place}): {row['result']}" + (f", {row['wrong']}" if row["wrong"] else "")
            tqdm.write(said, file=sys.stderr)
            bar.update()


def _rows(trials: Mapping[tuple[str, str], int], config: Path, results: Path) -> list[dict[str, Any]]:
    """In the order of `trials`. What an interrupted run has measured of the same state is not measured again."""
    kept = RowFile(results / "fault_table.jsonl", _state(config))
    if kept.dropped:
        print(f"{kept.path}: {kept.dropped} rows of another state do not count (now in *.old.jsonl)")
    if kept.done:
        print(f"{kept.path}: {len(trials.keys() & kept.done.keys())} rows of an interrupted run count")
    folder = results / "fault_table_logs"
    folder.mkdir(exist_ok=True)
    try:
        with exit_when_interrupted(lambda: f"{len(kept.done)} rows are in {kept.path}; the same command goes on"):
            _measure(trials, kept, folder)
    except BaseException:
        kept.close()
        raise
    rows = [kept.done[key] for key in trials]
    kept.finish(trials)
    return rows


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
    trials = {(CASES[number].name, place): number for number in chosen for place in places}
    rows = _rows(trials, config_folder(options), options.results.resolve())
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
