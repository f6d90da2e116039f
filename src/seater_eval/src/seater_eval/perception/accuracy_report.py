"""The accuracy table for a person: text and a figure."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from seater_eval.peers import catalogue
from seater_eval.perception.accuracy import _median
from seater_eval.perception.peers import LABELS
from seater_eval.report.bars import Bar
from seater_eval.report.evaluation_style import figure, save
from seater_eval.report.tables import text_table

WORSE = 1.10  # times an earlier version's median position error: no cell may be beyond it

COLOURS = {
    "seater": "#2e9e4f",
    "opencv_none": "#8a8f98",
    "opencv_default": "#c03030",
    "opencv_scaled": "#d1852c",
    "opencv_apriltag": "#7a4fb0",
    "pupil_apriltags": "#1f6fb4",
    **catalogue.COLOURS,
}


def describe_accuracy(data: dict[str, Any]) -> str:
    """One line for each cell; then wrong branches and published images."""
    methods = [m for m in data["cells"][0]["methods"] if m != "seater"]
    head = ["cell", "found", "bound", "seater", "p95", "deg", *methods, "NEES", "95 % bounds", "wrong"]
    rows = []
    for cell in data["cells"]:
        ours, nees = cell["methods"]["seater"], cell["nees"]
        name = f"{1e3 * cell['size']:.0f} mm {cell['distance']:.2f} m {cell['angle_deg']:.0f} deg"
        found = f"{ours['found']}/{ours['shown']}"
        bounds = (
            "-" if nees["mean"] is None else f"{nees['low']:.1f}-{nees['high']:.1f}{'' if nees['inside'] else ' !'}"
        )
        values = [cell["bound_median_mm"], ours["position_mm"]["median"], ours["position_mm"]["p95"]]
        values += [ours["angle_deg"]["median"], *(_median(cell, m) for m in methods), nees["mean"]]
        rows.append([name, found, *(_short(v) for v in values), bounds, str(cell["wrong_branch"])])
    branches = ", ".join(f"{key} {value}" for key, value in data["branches"].items())
    text = (
        f"{text_table(head, rows)}\n  Median position errors in mm (of what was found).\n  Wrong branches: {branches}"
    )
    if data["published"] is None:
        return text + "\n  SKIPPED: the published images (Debian's package visp-images-data is not installed)"
    lines = [
        f"    {LABELS[m]}: {p['found']} found, median {_short(p['median_mm'])} mm, worst {_short(p['worst_mm'])} mm;"
        f" from the common poses {_short(p['from_corners_median_mm'])}, {_short(p['from_corners_worst_mm'])} mm"
        for m, p in data["published"].items()
        if isinstance(p, dict)
    ]
    title = f"\n  Published images, {data['published']['tags']} tags"
    return text + title + " (common poses: of the package's corners in all three images):\n" + "\n".join(lines)


def beside_before(data: dict[str, Any], before: dict[str, Any]) -> list[dict[str, Any]]:
    """Cells of both results of this command: found and median position error [mm], now and `before`. The same seeds
    draw the same images in both."""

    def by_place(results: dict[str, Any]) -> dict[tuple[float, float, float], dict[str, Any]]:
        return {(c["size"], c["distance"], round(c["angle_deg"], 3)): c["methods"]["seater"] for c in results["cells"]}

    now, earlier = by_place(data), by_place(before)
    return [
        {
            "cell": f"{1e3 * place[0]:.0f} mm {place[1]:.2f} m {place[2]:.0f} deg",
            "found": now[place]["found"],
            "found_before": earlier[place]["found"],
            "median_mm": now[place]["position_mm"]["median"],
            "median_mm_before": earlier[place]["position_mm"]["median"],
        }
        for place in now
        if place in earlier
    ]


def before_bars(rows: list[dict[str, Any]]) -> list[Bar]:
    """Of beside_before: no cell is worse by more than a tenth, none has fewer found."""
    pairs = [(row["median_mm"], row["median_mm_before"], row["cell"]) for row in rows]
    ratios = [(now / earlier, cell) for now, earlier, cell in pairs if now is not None and earlier is not None]
    worst, where = max(ratios, default=(None, "no cell is in both"))
    fewer = sum(max(0, row["found_before"] - row["found"]) for row in rows)
    return [
        Bar("median position error / before, worst cell", worst, WORSE, note=f"{where}; {len(ratios)} cells"),
        Bar("markers found fewer than before, all cells", float(fewer) if rows else None, 0.0),
    ]


def _short(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def draw_accuracy(data: dict[str, Any], path: Path) -> Path:
    """The paper's missing figure: position error over distance, a panel for each size, medians over the angles."""
    sizes = sorted({cell["size"] for cell in data["cells"]})
    fig, axes = figure(len(sizes), width=5.2, height=5.6)
    for axis, size in zip(np.atleast_1d(axes), sizes, strict=True):
        cells = [cell for cell in data["cells"] if cell["size"] == size]
        distances = sorted({cell["distance"] for cell in cells})

        def over(value: Any, cells: Any = cells, distances: Any = distances) -> list[float]:
            found = [[value(c) for c in cells if c["distance"] == z and value(c) is not None] for z in distances]
            return [float(np.median(f)) if f else math.nan for f in found]

        for method in cells[0]["methods"]:
            medians = over(lambda c, m=method: _median(c, m))
            style = {"lw": 2.5, "zorder": 3} if method == "seater" else {"lw": 1.2}
            axis.loglog(distances, medians, "o-", color=COLOURS[method], label=LABELS[method], ms=4, **style)
        axis.loglog(distances, over(lambda c: c["bound_median_mm"]), "k.--", label=LABELS["bound"])
        axis.set_xticks(distances, [f"{z:g}" for z in distances], fontsize=8)
        axis.minorticks_off()
        axis.set(xlabel="distance [m]", title=f"{1e3 * size:.0f} mm marker")
        axis.grid(alpha=0.3)
    first = np.atleast_1d(axes)[0]
    first.set_ylabel("median position error [mm]")
    handles, labels = first.get_legend_handles_labels()
    fig.get_layout_engine().set(rect=(0.0, 0.12, 1.0, 0.88))
    fig.legend(handles, labels, loc="lower center", ncols=4, fontsize=9)
    fig.suptitle(
        "How exactly a marker's position is measured: 0 to 30 deg from frontal, all methods on the same images"
    )
    return save(fig, path)
