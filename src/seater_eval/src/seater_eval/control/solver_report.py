"""The solver benchmark for a person: a table and a figure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from seater_eval.control.solver_benchmark import BAR_HORIZON, HORIZONS, OTHERS, WANTED
from seater_eval.report.evaluation_style import COLOURS, figure, save
from seater_eval.report.tables import text_table


def describe_benchmark(data: dict[str, Any]) -> str:
    """One line for each method and horizon."""
    head = ["solver", "N", "cycles", "median", "p99", "max", "cold", "cpu median", "cpu p99", "failed", "final error"]
    rows = []
    for row in sorted(data["rows"], key=lambda row: (row["horizon"], [*WANTED, *OTHERS].index(row["solver"]))):
        solve = [_ms(row["solve_ms"][key]) for key in ("median", "p99", "max")]
        cost = [_ms(row["solve_cpu_ms"][key]) for key in ("median", "p99")]
        cells = [row["solver"], str(row["horizon"]), str(row["cycles"]), *solve, _ms(row["cold_ms"]["median"]), *cost]
        rows.append([*cells, str(row["failures"]), f"{row['final_error_mm']:.2f} mm"])
    missing = "".join(f"\n  The solver {name} is not available in seater_nmpc." for name in data["missing_solvers"])
    return (
        text_table(head, rows)
        + "\n  Times in the solver in ms; cpu: on the processor, what the bars look at."
        + missing
    )


def _ms(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


def draw_benchmark(data: dict[str, Any], path: Path) -> Path:
    """Cost over horizon, and the spread at the bar's horizon."""
    fig, (growth, bars) = figure(2, width=7.0, height=5.5)
    for name in WANTED:
        rows = sorted((row for row in data["rows"] if row["solver"] == name), key=lambda row: row["horizon"])
        if not rows:
            continue
        N = [row["horizon"] for row in rows]
        growth.loglog(N, [row["solve_cpu_ms"]["median"] for row in rows], "o-", color=COLOURS[name], label=name)
        growth.loglog(N, [row["solve_cpu_ms"]["p99"] for row in rows], ":", color=COLOURS[name])
    growth.set(
        xlabel="horizon N", ylabel="processor time in the solver [ms]", title="Growth (- median, ·· 99th percentile)"
    )
    growth.set_xticks(list(HORIZONS), [str(N) for N in HORIZONS])
    growth.grid(alpha=0.3, which="both")
    growth.legend()
    rows = [row for row in data["rows"] if row["horizon"] == BAR_HORIZON]
    at = np.arange(len(rows))
    colours = [COLOURS[row["solver"]] for row in rows]
    bars.barh(at, [row["solve_cpu_ms"]["p99"] for row in rows], color=colours, alpha=0.35, label="99th percentile")
    bars.barh(at, [row["solve_cpu_ms"]["median"] for row in rows], color=colours, height=0.4, label="median")
    bars.set_yticks(at, [row["solver"] for row in rows])
    bars.set(xscale="log", xlabel="processor time in the solver [ms]", title=f"N = {BAR_HORIZON}")
    bars.grid(alpha=0.3, axis="x", which="both")
    fig.suptitle("What a control cycle costs in closed loop, called from Python")
    return save(fig, path)
