"""The figures of a campaign's page: distributions, paths, success against each parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from seater_common.geometry import Dock
from seater_eval.campaign.report.summary import MEASURES, measured
from seater_eval.report.evaluation_style import draw_bay, figure

Row = Mapping[str, Any]

DOCKED, FAILED = "#1f6fb4", "#c03030"
SHOWN_INFLUENCES = 12


def distributions(rows: Sequence[Row]) -> Any:
    """A histogram for each measure, of docked runs, with median and 95th percentile."""
    docked = [row for row in rows if row["docked"]]
    missing = "not measured" if docked else "no docked run"  # the shortest time is, by option
    fig, axes = figure(4, -(-len(MEASURES) // 4), width=3.3, height=2.3)
    for place, (column, factor, name) in zip(axes.ravel(), MEASURES, strict=False):
        _histogram(place, measured(docked, column, factor), name, missing)
    for place in axes.ravel()[len(MEASURES) :]:
        place.set_axis_off()
    return fig


def _histogram(axes: Axes, values: list[float], name: str, missing: str) -> None:
    axes.set_title(name, fontsize=9)
    axes.tick_params(labelsize=7)
    if not values:
        axes.text(0.5, 0.5, missing, ha="center", va="center", transform=axes.transAxes, fontsize=8)
        return
    whole = all(float(value).is_integer() for value in values)
    bins = np.arange(min(values) - 0.5, max(values) + 1.5) if whole and max(values) < 60 else 30
    axes.hist(values, bins=bins, color=DOCKED)
    for level, style in ((0.5, "-"), (0.95, "--")):
        axes.axvline(float(np.quantile(values, level)), color="black", lw=0.8, ls=style)


def paths(rows: Sequence[Row], dock: Dock) -> Any:
    """True paths of base_link, red where a run did not dock; the bay is that of the default dock."""
    fig, axes = figure(1, width=8.0, height=5.5)
    draw_bay(axes, dock)
    thin = max(0.06, min(0.6, 20.0 / max(1, len(rows))))
    for row in sorted(rows, key=lambda row: not row["docked"]):
        if not row.get("path"):
            continue
        poses = np.asarray(row["path"])
        colour, alpha = (DOCKED, thin) if row["docked"] else (FAILED, 0.9)
        axes.plot(poses[:, 0], poses[:, 1], color=colour, lw=0.7, alpha=alpha)
        axes.plot(*poses[0, :2], ".", color=colour, ms=3, alpha=max(alpha, 0.3))
    axes.set(aspect="equal", xlabel="x in the dock frame [m]", ylabel="y [m]")
    axes.grid(alpha=0.3)
    return fig


def influence_bars(summary: Mapping[str, Any]) -> Any | None:
    """Share of docked runs with its 95 % interval for each group of the clearest parameters; None without any."""
    shown = summary["influences"][:SHOWN_INFLUENCES]
    if not shown:
        return None
    fig, axes = figure(3, -(-len(shown) // 3), width=4.4, height=2.6)
    places = np.atleast_1d(axes).ravel()
    for place, influence in zip(places, shown, strict=False):
        _groups(place, influence)
    for place in places[len(shown) :]:
        place.set_axis_off()
    return fig


def _groups(axes: Axes, influence: Mapping[str, Any]) -> None:
    groups = influence["groups"]
    share = np.array([group["docked"] / group["runs"] for group in groups])
    low, high = np.array([group["interval"] for group in groups]).T
    at = np.arange(len(groups))
    axes.errorbar(100 * share, at, xerr=100 * np.array([share - low, high - share]), fmt="o", color=DOCKED, ms=4, lw=1)
    axes.set_yticks(at, [f"{group['value']} ({group['runs']})" for group in groups], fontsize=7)
    axes.tick_params(axis="x", labelsize=7)
    axes.set_xlim(min(80.0, 100.0 * float(np.min(low)) - 3.0), 101.0)
    axes.set_ylim(-0.6, len(groups) - 0.4)
    axes.set_title(influence["parameter"], fontsize=9)
    axes.grid(alpha=0.3, axis="x")


def worst(rows: Sequence[Row], count: int) -> list[Row]:
    """The runs to look at first: those that touched, crashed or failed, then the least exact."""

    def badness(row: Row) -> tuple[bool, bool, bool, float]:
        return bool(row["touched"]), "start" not in row, not row["docked"], row.get("position_error_m") or 0.0

    return sorted(rows, key=badness, reverse=True)[:count]
