"""The speed table for a person: text and a figure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from seater_eval.peers import catalogue
from seater_eval.perception.peers import LABELS
from seater_eval.perception.speed import PLAIN, SEARCH, TRACKING, mostly_found
from seater_eval.report.evaluation_style import figure, save
from seater_eval.report.tables import text_table

COLOURS = {
    SEARCH: "#2e9e4f",
    TRACKING: "#83c99a",
    PLAIN: "#8a8f98",
    "opencv_default": "#c03030",
    "opencv_apriltag": "#7a4fb0",
    "pupil_apriltags": "#1f6fb4",
    **catalogue.COLOURS,
}


def describe_speed(data: dict[str, Any]) -> str:
    """One line for each resolution and number of markers."""
    names = list(dict.fromkeys(row["method"] for row in data["rows"]))
    rows = []
    for width, height, markers in dict.fromkeys((r["width"], r["height"], r["markers"]) for r in data["rows"]):
        cells = [
            r for n in names for r in data["rows"] if (r["method"], r["width"], r["markers"]) == (n, width, markers)
        ]
        shown = [f"{r['cpu_ms']['median']:.1f} ({r['found']:.0f})" for r in cells]
        rows.append([f"{width} x {height}, {markers} markers", *shown])
    head = ["image", *(name.replace("_", " ") for name in names)]
    return text_table(head, rows) + "\n  Median processor time in ms (markers found)."


def draw_speed(data: dict[str, Any], path: Path) -> Path:
    """A panel for each resolution: time over the number of markers."""
    resolutions = list(dict.fromkeys((row["width"], row["height"]) for row in data["rows"]))
    fig, axes = figure(len(resolutions), width=max(5.0, 12.0 / len(resolutions)), height=5.0)
    for axis, (width, height) in zip(np.atleast_1d(axes), resolutions, strict=True):
        for name in COLOURS:
            rows = [r for r in data["rows"] if r["method"] == name and r["width"] == width]
            if not rows:
                continue
            x, y = [r["markers"] for r in rows], [r["cpu_ms"]["median"] for r in rows]
            axis.loglog(x, y, "o-", color=COLOURS[name], label=LABELS.get(name, name))
            few = [k for k, row in enumerate(rows) if not mostly_found(row)]
            axis.plot([x[k] for k in few], [y[k] for k in few], "o", color=COLOURS[name], markerfacecolor="white")
        ticks = sorted({row["markers"] for row in data["rows"]})
        axis.set_xticks(ticks, [str(t) for t in ticks])
        marks = (0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
        axis.set_yticks(marks, [str(m) for m in marks])
        axis.minorticks_off()
        axis.set_ylim(0.2, 2000.0)
        axis.set(xlabel="markers in the image", title=f"{width} x {height}")
        axis.grid(alpha=0.3)
    first = np.atleast_1d(axes)[0]
    first.set_ylabel("processor time per image, one core [ms]")
    first.plot([], [], "o", color="black", markerfacecolor="white", label="finds less than 90 % of the markers")
    fig.get_layout_engine().set(rect=(0.0, 0.17, 1.0, 0.83))
    fig.legend(*first.get_legend_handles_labels(), loc="lower center", ncols=3, fontsize=9)
    return save(fig, path)
