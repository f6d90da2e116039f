"""Statistics over all runs of a campaign, and its bars."""

from __future__ import annotations

from typing import Any

from seater_eval.report.bars import Bar
from seater_eval.report.statistics import spread
from seater_sim.settings import KINEMATIC, WHEELCHAIR

# 95th percentile of the heading error [deg], median of docking time over minimum time.
HEADING_AND_TIME = {KINEMATIC: (0.5, 1.3), WHEELCHAIR: (0.6, 1.5)}
OUT_OF_VIEW = 0.5  # [s] longest time without a marker in view


def summarize_runs(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Counts and statistics over all runs."""
    docked = [run for run in runs if run["docked"]]
    ratios = [
        run["docking_time_s"] / run["minimum_time_s"]
        for run in docked
        if run["docking_time_s"] is not None and run["minimum_time_s"]
    ]
    viewed = [run for run in runs if run["started_in_view"]]
    results = [run["result"] for run in runs]
    summary: dict[str, Any] = {
        "runs": len(runs),
        "docked": len(docked),
        "results": {name: results.count(name) for name in sorted(set(results))},
        "retried": sum(run["retries"] > 0 for run in runs),
        "collided": sum(run["collisions"] > 0 for run in runs),
        "limits_violated": sum(run["limits_violated"] for run in runs),
        "largest_excess": {
            key: max(run[key] for run in runs) for key in ("excess_speed", "excess_bay_speed", "excess_request")
        },
        "started_in_view": len(viewed),
        "out_of_view": sum(run["out_of_view_s"] > OUT_OF_VIEW for run in viewed),
        "out_of_view_s": spread(run["out_of_view_s"] for run in viewed),
        "position_error_mm": spread(1e3 * run["position_error_m"] for run in runs),
        "heading_error_deg": spread(run["heading_error_deg"] for run in runs),
        "docking_time_s": spread(run["docking_time_s"] for run in docked),
        "minimum_time_s": spread(run["minimum_time_s"] for run in runs),
        "time_ratio": spread(ratios),
        "faster_than_the_bound": sum(ratio < 1.0 for ratio in ratios),
        "without_a_bound": sum(run["minimum_time_s"] is None for run in runs),
        "smallest_clearance_mm": 1e3 * min(run["min_clearance_m"] for run in runs),
        "solver_failures": sum(run["solver_failures"] for run in runs),
        "solve_ms": spread(run["solve_ms"] for run in runs),
    }
    for law in ("park_kuipers", "pbvs"):
        summary[law] = _summarize_law(law, runs)
    return summary


def _summarize_law(law: str, runs: list[dict[str, Any]]) -> dict[str, Any]:
    timed = [run for run in runs if run[law]["docked"] and run["minimum_time_s"]]
    return {
        "arrived": sum(run[law]["docking_time_s"] is not None for run in runs),
        "collided": sum(run[law]["min_clearance_m"] <= 0.0 for run in runs),
        "docked": sum(run[law]["docked"] for run in runs),
        "time_ratio": spread(run[law]["docking_time_s"] / run["minimum_time_s"] for run in timed),
    }


def campaign_bars(data: dict[str, Any], quick: bool, plant: str = KINEMATIC) -> list[Bar]:
    """Of the plant that was driven. With --quick the counts are of fewer runs, the limits are the same."""
    s, (heading, ratio) = data["summary"], HEADING_AND_TIME[plant]
    note = f"of {s['runs']} runs" if quick else ""
    return [
        Bar("not docked", s["runs"] - s["docked"], 0.0, "runs", note=note),
        Bar("collided", s["collided"], 0.0, "runs", note=note),
        Bar("limits violated", s["limits_violated"], 0.0, "runs", note=note),
        Bar("true position error, 95th percentile", s["position_error_mm"]["p95"], 5.0, "mm"),
        Bar("true heading error, 95th percentile", s["heading_error_deg"]["p95"], heading, "deg"),
        Bar("docking time / minimum time, median", s["time_ratio"]["median"], ratio),
        Bar("markers out of view for more than 0.5 s", s["out_of_view"], 0.0, "runs", note=note),
        Bar("runs", s["runs"], 20 if quick else 1000, "", "at least"),
    ]
