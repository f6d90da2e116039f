"""The range table for a person: text, a figure, and images with false detections."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from seater_eval.peers import catalogue
from seater_eval.perception.peers import LABELS
from seater_eval.perception.range import limit_of
from seater_eval.perception.range_jobs import ALL_IDS, PAPER, TRACK, negative_image
from seater_eval.report.evaluation_style import figure, save
from seater_eval.report.tables import text_table

NAMES = LABELS | {
    "seater": "seater (the dock's ids)",
    ALL_IDS: "seater (all 50 ids)",
    TRACK: "seater, tracking (moving away)",
}
COLOURS = {
    "seater": "#2e9e4f",
    ALL_IDS: "#83c99a",
    TRACK: "#14602a",
    "opencv_none": "#c03030",
    "opencv_default": "#d1852c",
    "pupil_apriltags": "#1f6fb4",
    **catalogue.COLOURS,
}


def describe_range(data: dict[str, Any]) -> str:
    """Table I with a row for each method."""
    rows = []
    for size, (nearest, farthest) in PAPER.items():
        rows.append(
            [f"{1e3 * size:.0f} mm", "paper (published)", f"{1e3 * nearest:.0f}", f"{1e3 * farthest:.0f}", "1.00"]
        )
        for method in dict.fromkeys(entry["method"] for entry in data["limits"]):
            near, far = (limit_of(data, method, size, end) for end in (False, True))
            shown = ["-" if value is None else f"{1e3 * value:.0f}" for value in (near, far)]
            rows.append(["", NAMES[method], *shown, "-" if far is None else f"{far / farthest:.2f}"])
    table = text_table(["marker", "method", "nearest mm", "farthest mm", "x paper"], rows)
    seen = data["false_detections"]
    kinds = ", ".join(
        f"{kind} {sum(f['kind'] == kind for f in seen)} in {shown}" for kind, shown in data["negatives"].items()
    )
    return f"{table}\n  False detections in images without markers: {kinds}"


def save_false(config: str | Path, data: dict[str, Any], folder: Path) -> list[Path]:
    """The first ten images in which something was seen that is not there, with it outlined."""
    paths = []
    for false in data["false_detections"][:10]:
        image = negative_image(config, false["kind"], false["image"])
        shown = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
        cv2.polylines(shown, [np.rint(false["corners"]).astype(np.int32)], True, (0, 0, 255), 1)
        paths.append(folder / f"perception_range_false_{false['image']}.png")
        cv2.imwrite(str(paths[-1]), shown)
    return paths


def draw_range(data: dict[str, Any], path: Path) -> Path:
    """From nearest to farthest for each size and method."""
    fig, axes = figure(1, width=9.0, height=5.0)
    methods = list(dict.fromkeys(entry["method"] for entry in data["limits"]))
    step, at, ticks = 1.0 / (len(methods) + 2), 0.0, []
    for size, (nearest, farthest) in PAPER.items():
        bars: list[tuple[str, str, float | None, float]] = [("paper (published)", "#8a8f98", nearest, farthest)]
        for method in methods:
            near, far = (limit_of(data, method, size, end) for end in (False, True))
            if far is not None:
                bars.append((NAMES[method], COLOURS[method], near, far))
        for i, (label, colour, near, far) in enumerate(bars):
            y = at - i * step
            first = size == next(iter(PAPER))
            left = near or 0.7 * far  # a stump where the near end was not measured
            axes.barh(y, far - left, left=left, height=0.8 * step, color=colour, label=label if first else None)
            axes.text(far * 1.03, y, f"{far:.2f} m", va="center", fontsize=8)
        ticks.append(at - 0.5 * (len(bars) - 1) * step)
        at -= 1.0
    axes.set_yticks(ticks, [f"{1e3 * size:.0f} mm marker" for size in PAPER])
    axes.set_xscale("log")
    marks = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
    axes.set_xticks(marks, [f"{m:g}" for m in marks])
    axes.minorticks_off()
    axes.set(xlabel="distance [m]", xlim=(0.03, 20.0), title="Where at least 90 % of the images give the marker")
    axes.grid(alpha=0.3, axis="x")
    axes.set_ylim(min(ticks) - 0.6, 1.1)
    axes.legend(fontsize=8, loc="upper left", ncols=3)
    return save(fig, path)
