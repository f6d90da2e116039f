"""Many dockings on the independent chair: jobs, summaries, the table and the bars."""

from __future__ import annotations

import dataclasses
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from seater_eval.judge.cases import Row
from seater_eval.judge.run import Job, run_job
from seater_eval.judge.verdict import is_far
from seater_eval.report.bars import AT_LEAST, Bar
from seater_eval.report.statistics import spread
from seater_eval.report.tables import text_table
from seater_eval.run.long_run import run_long
from seater_eval.run.parallel import job_seed

_UNMOVED = 0.001  # [m]
_SPREADS = (
    "position_error_m",
    "heading_error_deg",
    "smallest_gap_m",
    "reversals",
    "turn_changes",
    "time_s",
    "peak_acceleration_m_s2",
    "rms_acceleration_m_s2",
    "peak_jerk_m_s3",
    "rms_jerk_m_s3",
    "peak_turning_acceleration_rad_s2",
    "peak_turning_jerk_rad_s3",
    "estimate_error_m",
    "estimate_error_deg",
    "nees_mean",
    "noticed_s",
    "moved_after_fault_m",
)


def run_rows(
    config: Path,
    rows: Sequence[Row],
    runs: int,
    *,
    seed: int = 1,
    driver: str = "sequence",
    told: str = "nothing",
    series: int = 1,
    check: str = "",
    workers: int | None = None,
    partial: Path | None = None,
) -> dict[str, Any]:
    """`runs` dockings of each row, each the last of a `series`; run i has the same seed in every row. `partial`: see
    run_long."""
    seeds = [job_seed(seed, index) for index in range(runs)]
    jobs = [Job(str(config), row, one, driver, told, series, check) for row in rows for one in seeds]
    files = config.rglob("*.yaml")
    results = run_long(run_job, jobs, label="independent_chair", files=files, partial=partial, workers=workers)
    table = [
        {
            "name": row.name,
            "starts": row.starts,
            "effects": dataclasses.asdict(row.effects),
            "summary": summarize(results[index * runs : (index + 1) * runs]),
            "runs": results[index * runs : (index + 1) * runs],
        }
        for index, row in enumerate(rows)
    ]
    return {"seed": seed, "driver": driver, "told": told, "series": series, "check": check, "rows": table}


def summarize(runs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Counts over runs, and the spread of what was measured (headings without their sign)."""
    codes = Counter(run["code"] for run in runs if run["code"])
    return {
        "runs": len(runs),
        "docked": sum(run["docked"] for run in runs),
        "touched": sum(run["touched"] for run in runs),
        "falsely_successful": sum(run["code"] in ("SUCCESS", "ALREADY_DOCKED") and not run["docked"] for run in runs),
        "falsely_far": sum(_far_off(run) for run in runs if run["code"] in ("SUCCESS", "ALREADY_DOCKED")),
        "moving_at_the_end": sum(not run["stands"] for run in runs),
        "refused": sum(run["moved_m"] < _UNMOVED and not run["docked"] for run in runs),
        "failures": dict(Counter(_cause(run) for run in runs if not run["docked"]).most_common()),
        "codes": dict(codes.most_common()),
        **{name: spread(None if run[name] is None else abs(run[name]) for run in runs) for name in _SPREADS},
    }


def _far_off(run: dict[str, Any]) -> bool:
    return is_far(run["position_error_m"], run["heading_error_deg"])


def _cause(run: dict[str, Any]) -> str:
    """Result code and text without its numbers, so that equal causes are counted together."""
    return f"{run['code']}: {re.sub(r'[0-9.]*[0-9]', '#', run['text'])}" if run["code"] else "ends elsewhere"


def describe(data: dict[str, Any]) -> str:
    """The table for a person."""
    head = [
        "row",
        "docked",
        "refused",
        "touched",
        "far",
        "error [mm]",
        "[deg]",
        "reversals",
        "turns",
        "time [s]",
        "noticed [s]",
        "way after [m]",
        "jerk",
        "ended",
    ]
    rows = []
    for row in data["rows"]:
        s = row["summary"]
        rows.append(
            [
                row["name"],
                f"{s['docked']} of {s['runs']}",
                str(s["refused"]),
                str(s["touched"]),
                str(s["falsely_far"]),
                _pair(s["position_error_m"], 1e3, 1),
                _pair(s["heading_error_deg"], 1.0, 2),
                _pair(s["reversals"], 1.0, 0),
                _pair(s["turn_changes"], 1.0, 0),
                _pair(s["time_s"], 1.0, 1),
                _pair(s["noticed_s"], 1.0, 2),
                _pair(s["moved_after_fault_m"], 1.0, 2),
                _pair(s["peak_jerk_m_s3"], 1.0, 1),
                ", ".join(f"{code} {count}" for code, count in s["codes"].items()),
            ]
        )
    told = f"driver {data['driver']}, told {data['told']}, seed {data['seed']}; median / 95 % of all runs"
    failures = [
        f"  {row['name']}: {count} x {cause}"
        for row in data["rows"]
        for cause, count in row["summary"]["failures"].items()
    ]
    note = "refused: not docked, never moved; noticed, way after: since the fault began, until the result and in all"
    if data.get("series", 1) > 1:
        failures += [
            f"  {row['name']}: {line}" for row in data["rows"] for line in _series(row["runs"], data["series"])
        ]
    note += "\nfar: success said, but beyond 20 mm or 2 deg; peak jerk [m/s^3] of the true speed low-passed at 5 Hz"
    return f"{told}\n{text_table(head, rows, 'lrrrrrrrrrrrrl')}\n{note}\n\n" + "\n".join(failures)


def _series(runs: Sequence[dict[str, Any]], series: int) -> Iterable[str]:
    """How many of each docking of the series ended with what."""
    for number in range(series):
        codes = Counter(run["series_codes"][number] for run in runs)
        yield f"docking {number + 1}: " + ", ".join(f"{code} {count}" for code, count in codes.most_common())
    yield f"of all, success said, but far: {sum(run['series_far'] for run in runs)}"


def _pair(values: dict[str, float | None], factor: float, digits: int) -> str:
    median, p95 = values["median"], values["p95"]
    return "-" if median is None or p95 is None else f"{factor * median:.{digits}f} / {factor * p95:.{digits}f}"


def bars(data: dict[str, Any]) -> list[Bar]:
    """Everybody docks, nobody touches, and no success is false."""
    return [bar for row in data["rows"] for bar in _row_bars(row["name"], row["summary"])]


def _row_bars(name: str, s: dict[str, Any]) -> Iterable[Bar]:
    yield Bar(f"{name}: docked", s["docked"], s["runs"], sense=AT_LEAST)
    yield Bar(f"{name}: touched a wall", s["touched"], 0)
    yield Bar(f"{name}: success said, not docked", s["falsely_successful"], 0)
