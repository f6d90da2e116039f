"""The campaign for a person: a table and a figure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from seater_common.geometry import Chair, Dock
from seater_eval.report.evaluation_style import COLOURS, draw_bay, figure, save
from seater_eval.report.tables import text_table

LAWS = ("park_kuipers", "pbvs")
_DOCKED, _FAILED = "#1f6fb4", "#c03030"


def describe_campaign(data: dict[str, Any]) -> str:
    """Statistics over all runs, and the runs that did not dock."""
    s = data["summary"]
    rows = [_spread_row("true position error [mm]", s["position_error_mm"])]
    rows.append(_spread_row("true heading error [deg]", s["heading_error_deg"]))
    rows.append(_spread_row("docking time [s]", s["docking_time_s"]))
    rows.append(_spread_row("minimum time [s]", s["minimum_time_s"]))
    rows.append(_spread_row("docking time / minimum time", s["time_ratio"]))
    rows.append(_spread_row("markers out of view [s]", s["out_of_view_s"]))
    rows.append(_spread_row("median solve time of a run [ms]", s["solve_ms"]))
    lines = [
        f"  {s['docked']} of {s['runs']} docked  ({', '.join(f'{k} {v}' for k, v in s['results'].items())})",
        f"  collided {s['collided']}, limits violated {s['limits_violated']}, retried {s['retried']}, "
        f"smallest clearance {s['smallest_clearance_mm']:.0f} mm, cycles without a solution {s['solver_failures']}",
        f"  obstacles: {data['conditions']['obstacles']};  solver: {data['conditions']['solver']}",
        "",
        text_table(["", "median", "p95", "p99", "max"], rows),
        "",
        "  From the same starts with a perfect chair and perfect state, walls unknown to them:",
        text_table(["", "docked", "collided", "median time / minimum time"], [_law_row(s, law) for law in LAWS]),
    ]
    if s["faster_than_the_bound"]:
        lines.append(
            f"  {s['faster_than_the_bound']} runs were faster than their bound: its search missed the optimum there."
        )
    bad = [run for run in data["runs"] if not run["docked"] or run["limits_violated"] or run["collisions"]]
    lines += [f"  {_complaint(run)}" for run in bad[:10]]
    if len(bad) > 10:
        lines.append(f"  ... and {len(bad) - 10} more, see the file")
    return "\n".join(lines)


def _complaint(run: dict[str, Any]) -> str:
    x, y, heading = run["start"]
    start = f"({x:.2f} m, {y:.2f} m, {np.degrees(heading):.0f} deg)"
    return (
        f"run {run['index']} from {start}: {run['result']} {run['text']}, "
        f"{1e3 * run['position_error_m']:.1f} mm, collisions {run['collisions']}, "
        f"too fast in the bay by {1e3 * run['excess_bay_speed']:.1f} mm/s"
    )


def _law_row(summary: dict[str, Any], law: str) -> list[str]:
    of_law = summary[law]
    ratio = of_law["time_ratio"]["median"]
    return [law, str(of_law["docked"]), str(of_law["collided"]), "-" if ratio is None else f"{ratio:.2f}"]


def _spread_row(name: str, values: dict[str, float | None]) -> list[str]:
    return [name, *("-" if values[key] is None else f"{values[key]:.3f}" for key in ("median", "p95", "p99", "max"))]


def draw_campaign(data: dict[str, Any], dock: Dock, chair: Chair, path: Path) -> Path:
    """Paths, final errors, docking times and clearances."""
    fig, axes = figure(2, 2, width=7.0, height=5.2)
    _draw_paths(axes[0, 0], data["runs"], dock)
    _draw_errors(axes[0, 1], data["runs"])
    _draw_times(axes[1, 0], data["runs"])
    _draw_clearances(axes[1, 1], data["runs"], dock, chair)
    s = data["summary"]
    fig.suptitle(f"{s['docked']} of {s['runs']} docked, {s['collided']} collided ({data['conditions']['solver']})")
    return save(fig, path)


def _draw_paths(axes: Axes, runs: list[dict[str, Any]], dock: Dock) -> None:
    draw_bay(axes, dock)
    thin = max(0.08, min(0.6, 20.0 / len(runs)))
    for run in runs:
        poses = np.asarray(run["path"])
        colour = _DOCKED if run["docked"] else _FAILED
        axes.plot(poses[:, 0], poses[:, 1], color=colour, lw=0.6, alpha=thin if run["docked"] else 0.9)
    starts = np.array([run["start"] for run in runs])
    colours = [_DOCKED if run["docked"] else _FAILED for run in runs]
    axes.quiver(*starts[:, :2].T, np.cos(starts[:, 2]), np.sin(starts[:, 2]), color=colours, width=0.0025, scale=40)
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="Starts and true paths (red: not docked)")
    axes.grid(alpha=0.3)


def _draw_errors(axes: Axes, runs: list[dict[str, Any]]) -> None:
    percent = 100.0 * (np.arange(len(runs)) + 1) / len(runs)
    axes.semilogx(np.sort([1e3 * run["position_error_m"] for run in runs]), percent, label="position [mm]")
    axes.semilogx(np.sort([run["heading_error_deg"] for run in runs]), percent, label="heading [deg]")
    axes.plot([5.0], [95.0], "v", color="C0", label="bar, position")
    axes.plot([0.5], [95.0], "v", color="C1", label="bar, heading")
    axes.set(xlabel="true final error", ylabel="runs with at most this error [%]", title="Final error")
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize=8)


def _draw_times(axes: Axes, runs: list[dict[str, Any]]) -> None:
    for name in ("park_kuipers", "pbvs"):
        points = [(run["minimum_time_s"], run[name]["docking_time_s"]) for run in runs if run[name]["docked"]]
        points = [point for point in points if None not in point]
        if points:
            axes.plot(
                *np.array(points, float).T, ".", ms=3, alpha=0.5, color=COLOURS[name], label=f"{name} (perfect state)"
            )
    points = [(run["minimum_time_s"], run["docking_time_s"]) for run in runs if run["docked"]]
    points = [point for point in points if None not in point]
    if points:
        axes.plot(*np.array(points, float).T, ".", ms=4, color=COLOURS["seater"], label="seater (noise, lag, delay)")
    low, high = axes.get_xlim()
    axes.plot([low, high], [low, high], "k-", lw=0.8, label="minimum time")
    axes.plot([low, high], [1.3 * low, 1.3 * high], "k--", lw=0.8, label="1.3 times")
    axes.set(xlabel="minimum time [s]", ylabel="docking time [s]", xlim=(low, high), ylim=(low, 3.0 * high))
    axes.set_title("Time to stay within 10 mm and 1°")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)


def _draw_clearances(axes: Axes, runs: list[dict[str, Any]], dock: Dock, chair: Chair) -> None:
    axes.hist([1e3 * run["min_clearance_m"] for run in runs], bins=40, color=_DOCKED)
    docked = min(0.5 * (dock.bay.width - chair.width), dock.bay.back_wall_x - chair.length_front)
    axes.axvline(1e3 * docked, color="black", ls="--", lw=0.8, label="when docked")
    axes.axvline(0.0, color=_FAILED, lw=1.0, label="collision")
    axes.set(xlabel="smallest clearance of a run [mm]", ylabel="runs", title="Clearance")
    axes.legend(fontsize=8)
