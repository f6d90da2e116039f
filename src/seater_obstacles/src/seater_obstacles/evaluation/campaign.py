"""Many dockings among untold things: jobs, summaries, the table and the bars."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from seater_eval.report.bars import AT_LEAST, Bar
from seater_eval.report.statistics import spread
from seater_eval.report.tables import text_table
from seater_eval.run.long_run import run_long
from seater_eval.run.parallel import job_seed
from seater_obstacles.evaluation.run import Job, run_job

_FALSE_STOPS = 1 / 200  # of clean dockings
_STOPPED = 0.05  # [m/s] slower, and turning slower than 0.05 rad/s: the chair has come to rest


def run_cases(
    config: Path,
    cases: Sequence[str],
    runs: int,
    *,
    sensor: str,
    watched: bool = True,
    seed: int = 1,
    workers: int | None = None,
    partial: Path | None = None,
) -> dict[str, Any]:
    """`runs` dockings of each case. `watched`: with the sensor. `partial`: see run_long."""
    seeds = [job_seed(seed, index) for index in range(runs)]
    jobs = [Job(str(config), case, sensor, one, watched) for case in cases for one in seeds]
    files = config.rglob("*.yaml")
    results = run_long(run_job, jobs, label="untold_obstacles", files=files, partial=partial, workers=workers)
    table = [
        {
            "case": case,
            "summary": summarize(results[index * runs : (index + 1) * runs]),
            "runs": results[index * runs : (index + 1) * runs],
        }
        for index, case in enumerate(cases)
    ]
    return {"seed": seed, "sensor": sensor if watched else "none", "cases": table}


def summarize(runs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Counts over runs, and the spread of what was measured."""
    touches = [touch for run in runs for touch in run["touches"]]
    return {
        "runs": len(runs),
        "touched": sum(bool(run["touches"]) for run in runs),
        "touched_driving": sum(any(_drives(touch) for touch in run["touches"]) for run in runs),
        "fastest_touch_m_s": max((abs(touch["v"]) for touch in touches), default=None),
        "docked": sum(run["docked"] for run in runs),
        "docked_by_the_first_goal": sum(run["docked"] and run["goals"] == 1 for run in runs),
        "held": sum(run["gate_stops"] > 0 for run in runs),
        "slowed": sum(run["gate_limited_s"] > 0.0 for run in runs),
        "codes": dict(Counter(code for run in runs for code in run["codes"]).most_common()),
        "time_s": spread(run["time_s"] for run in runs if run["docked"]),
        "gate_limited_s": spread(run["gate_limited_s"] for run in runs),
    }


def _drives(touch: dict[str, float]) -> bool:
    return abs(touch["v"]) > _STOPPED or abs(touch["omega"]) > _STOPPED


def describe(data: dict[str, Any]) -> str:
    """The table for a person."""
    head = ["case", "docked", "first goal", "touched", "driving", "gate stopped", "slowed", "time [s]", "ended"]
    rows = [_row(entry["case"], entry["summary"]) for entry in data["cases"]]
    note = "touched: runs in which the chair ran into something or somebody; driving: faster than 0.05 m/s or rad/s"
    note += "\ntime: median / 95 % of those that docked, all goals and pauses included"
    return f"sensor {data['sensor']}, seed {data['seed']}\n{text_table(head, rows, 'lrrrrrrrl')}\n{note}"


def _row(case: str, s: dict[str, Any]) -> list[str]:
    median, p95 = s["time_s"]["median"], s["time_s"]["p95"]
    return [
        case,
        f"{s['docked']} of {s['runs']}",
        str(s["docked_by_the_first_goal"]),
        str(s["touched"]),
        str(s["touched_driving"]),
        str(s["held"]),
        str(s["slowed"]),
        "-" if median is None else f"{median:.1f} / {p95:.1f}",
        ", ".join(f"{code} {count}" for code, count in s["codes"].items()),
    ]


def bars(data: dict[str, Any]) -> list[Bar]:
    """Nobody is touched, all dock when the way is free, and the dock itself stops nobody."""
    return [bar for entry in data["cases"] for bar in _case_bars(entry["case"], entry["summary"])]


def _case_bars(case: str, s: dict[str, Any]) -> Iterable[Bar]:
    yield Bar(f"{case}: touched by the moving chair", s["touched"], 0)
    yield Bar(f"{case}: docked", s["docked"], s["runs"], sense=AT_LEAST)
    if case == "clean":
        yield Bar("clean: stopped by the gate", s["held"], _FALSE_STOPS * s["runs"])
