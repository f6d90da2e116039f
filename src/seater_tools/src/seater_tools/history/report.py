"""The history for the terminal and as a picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from tabulate import tabulate

from seater_common.command.typed import as_typed
from seater_nmpc.sequence.goal.results import ResultCode
from seater_tools.history.docking import Docking
from seater_tools.history.trends import SERIES, Notice, Series

HEAD = ["time (UTC)", "result", "s", "tries", "x mm", "y mm", "deg", "sd mm", "NIS", "contact"]
SHOWN = ("x", "y", "heading", "nis", "duration", "accepted")  # of SERIES, a panel each
TRENDS = ("x", "y", "heading", "position_sd", "nis", "duration")  # in the table of trends
RECENT = 10  # dockings


def describe(dockings: Sequence[Docking], notices: Sequence[Notice], last: int) -> str:
    """The `last` dockings, medians of the newest ones against all before, and what has changed."""
    rows = [_row(docking) for docking in dockings[-last:]]
    lines = [tabulate(rows, HEAD, floatfmt=".1f", missingval="-"), "", _trends(dockings)]
    good = sum(docking.success for docking in dockings)
    lines += ["", f"{dockings[-1].dock}: {len(dockings)} dockings, {good} docked"]
    lines += [f"\u2718 {notice.text}  -> {as_typed(notice.remedy)}" for notice in notices] or ["\u2714 no drift"]
    return "\n".join(lines)


def _row(d: Docking) -> list[object]:
    def number(value: float) -> float | None:
        return value if math.isfinite(value) else None

    name = ResultCode(d.code).name if d.code in set(map(int, ResultCode)) else str(d.code)
    numbers = (1e3 * d.x, 1e3 * d.y, math.degrees(d.heading), 1e3 * d.position_sd, d.nis)
    contact = "closed" if d.contact else "open"
    return [f"{d.time:%Y-%m-%d %H:%M}", name, d.duration, d.tries, *map(number, numbers), contact]


def _trends(dockings: Sequence[Docking]) -> str:
    rows = []
    for series in (one for one in SERIES if one.name in TRENDS):
        values = series.factor * series.values(dockings)
        rows.append([f"{series.text} [{series.unit or '1'}]", _median(values[:-RECENT]), _median(values[-RECENT:])])
    return tabulate(rows, ["median", "before", f"last {RECENT}"], floatfmt=".2f", missingval="-")


def _median(values: np.ndarray) -> float | None:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else None


def panels(notices: Sequence[Notice]) -> list[Series]:
    """What is drawn."""
    return [one for one in SERIES if one.name in SHOWN or any(n.is_of(one) for n in notices)]


def draw(dockings: Sequence[Docking], notices: Sequence[Notice], path: Path) -> None:
    """A panel for each of the shown series, and for what a notice is of, over the number of the docking; dotted: where
    a change began. Raises OSError."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    drawn = panels(notices)
    rows = (len(drawn) + 1) // 2
    figure, axes = plt.subplots(rows, 2, figsize=(11.0, 2.7 * rows), sharex=True)
    for unused in axes.ravel()[len(drawn) :]:
        unused.axis("off")
    numbers = np.arange(1, len(dockings) + 1)
    for panel, series in zip(axes.ravel(), drawn, strict=False):
        values = series.factor * series.values(dockings)
        panel.plot(numbers, values, ".", color="#2060a0", ms=5)
        retried = np.array([docking.tries > 1 for docking in dockings])
        panel.plot(numbers[retried], values[retried], "o", mfc="none", color="#d08020", label="second try")
        for notice in notices:
            if notice.at is not None and notice.is_of(series):
                panel.axvline(notice.at + 1, color="#c03030", ls=":", label="change")
        panel.set_title(series.text, fontsize=10)
        panel.set_ylabel(series.unit)
        panel.grid(alpha=0.3)
        if retried.any() or any(notice.is_of(series) for notice in notices):
            panel.legend(fontsize=8)
    for panel in axes.ravel()[: len(drawn)][-2:]:
        panel.set_xlabel("docking")
        panel.tick_params(labelbottom=True)
    figure.suptitle(f"{dockings[-1].dock}, {dockings[0].time:%Y-%m-%d} to {dockings[-1].time:%Y-%m-%d}")
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)
