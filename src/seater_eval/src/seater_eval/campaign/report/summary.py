"""Statistics over all runs of a campaign, and its bars."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from seater_eval.campaign.report.statistics import influences, wilson
from seater_eval.report.bars import AT_LEAST, Bar
from seater_eval.report.statistics import spread

Row = Mapping[str, Any]

# What has a distribution: column, factor, name. Only runs that moved have them.
MEASURES = (
    ("position_error_m", 1e3, "true position error [mm]"),
    ("lateral_error_m", 1e3, "lateral error, absolute [mm]"),
    ("heading_error_deg", 1.0, "true heading error, absolute [deg]"),
    ("estimate_position_error_m", 1e3, "error of the last estimate [mm]"),
    ("docking_time_s", 1.0, "time to the result [s]"),
    ("time_ratio", 1.0, "time to arrive / minimum time"),
    ("acceleration_peak", 1.0, "acceleration, peak [m/s^2]"),
    ("acceleration_rms", 1.0, "acceleration, rms [m/s^2]"),
    ("jerk_peak", 1.0, "jerk, peak [m/s^3]"),
    ("jerk_rms", 1.0, "jerk, rms [m/s^3]"),
    ("lateral_acceleration_peak", 1.0, "lateral acceleration, peak [m/s^2]"),
    ("lateral_acceleration_rms", 1.0, "lateral acceleration, rms [m/s^2]"),
    ("angular_acceleration_peak", 1.0, "angular acceleration, peak [rad/s^2]"),
    ("angular_jerk_peak", 1.0, "angular jerk, peak [rad/s^3]"),
    ("reversals", 1.0, "reversals"),
    ("turning_sign_changes", 1.0, "sign changes of turning"),
)
_SIGNED = ("lateral_error_m", "heading_error_deg")


def measured(rows: Sequence[Row], column: str, factor: float) -> list[float]:
    """A column's values where there are any, magnitudes of what has a sign."""
    values = [row[column] for row in rows if row.get(column) is not None]
    return [factor * (abs(value) if column in _SIGNED else value) for value in values]


def summarize(rows: Sequence[Row]) -> dict[str, Any]:
    """Counts, results with their texts, distributions over the docked runs, influence of each parameter, throughput."""
    docked = [row for row in rows if row["docked"]]
    simulated, core = (sum(row.get(key) or 0.0 for row in rows) for key in ("simulated_s", "core_s"))
    parts = sorted({key for row in rows for key in row if key.startswith("core_") and key != "core_s"})
    return {
        "runs": len(rows),
        "docked": len(docked),
        "docked_interval": list(wilson(len(docked), len(rows))),
        "touched": sum(bool(row["touched"]) for row in rows),
        "moving_at_the_end": sum(row["at_rest"] is False for row in rows),
        "smallest_clearance_mm": min(measured(rows, "min_clearance_m", 1e3), default=None),
        "retried": sum((row.get("retries") or 0) > 0 for row in rows),
        "results": [
            {"result": result, "text": text, "runs": runs} for (result, text), runs in _results(rows).most_common()
        ],
        "of_docked": {name: spread(measured(docked, column, factor)) for column, factor, name in MEASURES},
        "influences": [
            {
                "parameter": influence.parameter,
                "evidence": influence.evidence,
                "groups": [
                    {"value": g.label, "runs": g.runs, "docked": g.docked, "interval": list(g.interval)}
                    for g in influence.groups
                ],
            }
            for influence in influences(rows)
        ],
        "simulated_s": simulated,
        "core_s": core,
        "realtime_factor": simulated / core if core > 0.0 else None,
        "share_of_time": {key[5:-2]: sum(row.get(key) or 0.0 for row in rows) / core for key in parts} if core else {},
    }


def _results(rows: Sequence[Row]) -> Counter[tuple[str, str]]:
    """Texts that differ in their numbers only count as one."""
    return Counter((str(row["result"]), _without_numbers(str(row["text"]))) for row in rows)


def _without_numbers(text: str) -> str:
    return re.sub(r"-?\d+(\.\d+)?(e-?\d+)?", "#", text.splitlines()[-1] if text else "")


def campaign_bars(summary: Mapping[str, Any], limits: Mapping[str, float]) -> list[Bar]:
    """`limits`: `bars` of the campaign file."""
    runs, of_docked = max(1, summary["runs"]), summary["of_docked"]
    share = summary["docked"] / runs
    return [
        Bar("docked", share, limits["docked"], "of all runs", AT_LEAST),
        Bar("touched a wall", summary["touched"] / runs, limits["touched"], "of all runs"),
        Bar("moving at the end", summary["moving_at_the_end"], 0.0, "runs"),
        _p95(of_docked, "true position error [mm]", limits["position_p95"]),
        _p95(of_docked, "true heading error, absolute [deg]", limits["heading_p95"]),
        _p95(of_docked, "reversals", limits["reversals_p95"]),
        Bar("simulated time / time of one core", summary["realtime_factor"], limits["realtime_factor"], "", AT_LEAST),
    ]


def _p95(of_docked: Mapping[str, Any], name: str, limit: float) -> Bar:
    return Bar(f"{name}, 95th percentile", of_docked[name]["p95"], limit)
