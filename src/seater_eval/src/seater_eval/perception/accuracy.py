"""Error over distance for each marker size, beside the Cramer-Rao bound and other detectors on the same images."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from seater_eval.peers.process import peers_for
from seater_eval.perception import subject
from seater_eval.perception.accuracy_cells import BranchJob, CellJob, count_wrong_branches, run_cell, table_bounds
from seater_eval.perception.images.degraded_camera import load_degraded_camera
from seater_eval.perception.published import published_images
from seater_eval.report.bars import Bar
from seater_eval.run.long_run import run_long

METHODS = ("seater", "opencv_none", "opencv_default", "opencv_scaled", "opencv_apriltag", "pupil_apriltags")
COMPARED = ("seater", "opencv_default")  # what the bars compare
SIZES = (0.05, 0.10, 0.15)
DISTANCES = {
    0.05: (0.2, 0.35, 0.6, 1.0, 1.4),
    0.10: (0.35, 0.6, 0.9, 1.25, 2.0, 2.84),
    0.15: (0.5, 0.9, 1.5, 2.5, 3.75),
}
ANGLES = (0.0, math.radians(15.0), math.radians(30.0))
QUICK_CELLS = (
    (0.05, 0.6, 15.0),
    (0.10, 0.35, 15.0),
    (0.10, 0.9, 30.0),
    (0.10, 1.25, 0.0),
    (0.10, 2.84, 0.0),
    (0.10, 2.84, 15.0),
    (0.10, 2.84, 30.0),
    (0.15, 1.5, 15.0),
)
NEAR = (0.35, 1.25)  # [m] where the paper calls the 100 mm marker most accurate
TIMES_BOUND, TIMES_OPENCV, FEWER = 2.0, 10.0, 5.0
FOUND = 0.9  # fraction of the images that have to be found before their errors count


def run_accuracy(
    config: str | Path, quick: bool, partial: Path | None = None, peers: Path | None = None, bars_only: bool = False
) -> dict[str, Any]:
    """All cells, the wrong-branch frames, the published images. `partial`: see run_long; `peers`: what
    tools/make_peers.sh made, for the cells; `bars_only`: in the cells no other methods than the bars compare, on the
    same images. Raises ParameterError, PeerError."""
    config = str(config)
    camera = load_degraded_camera(Path(config) / "cameras" / "degraded.yaml")
    subject.make_detector(camera, 0.1, subject.perception_parameters(config), prior=True)  # wrong parameters: now
    if quick:
        wanted = [(size, z, math.radians(angle)) for size, z, angle in QUICK_CELLS]
    else:
        wanted = [(size, z, angle) for size in SIZES for z in DISTANCES[size] for angle in ANGLES]
    methods = COMPARED if quick or bars_only else METHODS
    images, slow, frames = (24, 0, 60) if quick else (48, 12, 3000)
    methods = (*methods, *peers_for(subject.DICTIONARY, peers))
    jobs = [CellJob(config, *cell, images, slow, methods, i, peers) for i, cell in enumerate(wanted)]
    jobs.sort(key=lambda job: job.distance / job.size)  # the longest first, so that no core waits at the end
    blocks = [BranchJob(config, first, min(first + 20, frames)) for first in range(0, frames, 20)]
    files = subject.result_files(config)
    results = run_long(run_part, [*jobs, *blocks], label="perception_accuracy", files=files, partial=partial)
    cells, counts = results[: len(jobs)], results[len(jobs) :]
    cells.sort(key=lambda cell: (cell["size"], cell["distance"], cell["angle_deg"]))
    return {
        "quick": quick,
        "conditions": {k: getattr(camera, k) for k in camera.__dataclass_fields__},
        "cells": cells,
        "branches": {key: sum(c[key] for c in counts) for key in counts[0]},
        "published": published_images(config),
    }


def run_part(job: CellJob | BranchJob) -> dict[str, Any]:
    """One cell of the table, or one block of frames."""
    return run_cell(job) if isinstance(job, CellJob) else count_wrong_branches(job)


def _median(cell: dict[str, Any], method: str) -> float | None:
    entry = cell["methods"].get(method)
    return None if entry is None else entry["position_mm"]["median"]


def _pooled(cells: list[dict[str, Any]], distance: float, method: str) -> float | None:
    """Median position error [mm] over all poses of this distance (all angles); bound: of an estimator that reaches
    it."""
    key = "bound_draws_mm" if method == "bound" else None
    here = [c for c in cells if c["distance"] == distance]
    values = [v for c in here for v in (c[key] if key else c["methods"][method]["every_mm"])]
    return float(np.median(values)) if values else None


def _worst_ratio(cells: list[dict[str, Any]], over: str) -> tuple[float | None, str]:
    """The worst over the distances: ours over the bound (largest), or OpenCV default over ours (smallest). And where
    that is, with the same of the worst single cell, which is of one angle."""
    ratios, single = [], []
    for cell in cells:
        ours, other = _median(cell, "seater"), cell["bound_median_mm"] if over == "bound" else _median(cell, over)
        if ours is not None and other is not None:
            single.append((ours / other if over == "bound" else other / ours, cell["angle_deg"], cell["distance"]))
    for distance in sorted({c["distance"] for c in cells}):
        ours, other = _pooled(cells, distance, "seater"), _pooled(cells, distance, over)
        here = [c["methods"]["seater"] for c in cells if c["distance"] == distance]
        found, shown = sum(m["found"] for m in here), sum(m["shown"] for m in here)
        if ours is None or found < FOUND * shown:  # errors of a chosen few would say nothing
            return None, f"only {found} of {shown} found at {distance:g} m"
        if other is not None:  # where OpenCV finds nothing there is nothing to compare
            ratios.append((ours / other if over == "bound" else other / ours, distance))
    if not ratios or not single:
        return None, "nothing to compare"
    pick = max if over == "bound" else min
    worst, cell_worst = pick(ratios), pick(single)
    where = f"worst at {worst[1]:g} m; worst cell: {cell_worst[0]:.3g} at {cell_worst[2]:g} m, {cell_worst[1]:.0f} deg"
    return worst[0], where


def accuracy_bars(data: dict[str, Any]) -> list[Bar]:
    """The rows of the table that this command measures."""
    cells, branches, published = data["cells"], data["branches"], data["published"]
    near = [c for c in cells if c["size"] == 0.1 and NEAR[0] <= c["distance"] <= NEAR[1]]
    far = [c for c in cells if c["size"] == 0.1 and c["distance"] == 2.84]
    outside = sum(not c["nees"]["inside"] for c in cells)
    found = f"{branches['found']} of {branches['frames']} frames found"
    enough = branches["found"] >= FOUND * branches["frames"]
    enough_without = branches["found without prior"] >= FOUND * branches["frames"]
    without = branches["seater without prior"]
    by_chance = f"a right covariance: {0.05 * len(cells):.1f} of {len(cells)} cells expected by chance"
    far_outside = sum(not _inside_table_bounds(c["nees"], len(cells)) for c in cells)
    bound, at_bound = _worst_ratio(near, "bound")
    times, at_times = _worst_ratio(near, "opencv_default")
    far_times, at_far = _worst_ratio(far, "opencv_default")
    bars = [
        Bar("100 mm, 0.35-1.25 m: median position error / bound", bound, TIMES_BOUND, note=at_bound),
        Bar("same: OpenCV default / ours", times, TIMES_OPENCV, "", "at least", at_times),
        Bar("100 mm, 2.84 m: OpenCV default / ours", far_times, TIMES_OPENCV, "", "at least", at_far),
        Bar("wrong branch with prior", branches["seater"] if enough else None, 0.0, "", "at most", found),
        Bar("cells whose normalised error is out of its 95 % bounds", outside, 0.0, "", "at most", by_chance),
        Bar("cells out of the bounds that a right covariance keeps in 95 % of such tables", far_outside, 0.0),
    ]
    if branches["ippe"] > 0 or not data["quick"]:  # the quick version's frames may be too few for IPPE to err at all
        fewer = (
            without if enough_without and branches["ippe"] > 0 else None
        )  # where IPPE makes no mistake, nothing is shown
        note = f"IPPE alone: {branches['ippe']}; {branches['found without prior']} frames found"
        name = f"wrong branch without prior ({FEWER:.0f} times fewer than IPPE alone)"
        bars.append(Bar(name, fewer, branches["ippe"] / FEWER, "", "at most", note))
    if published is None:
        note = "skipped: Debian's package visp-images-data is not installed"
        return [*bars, Bar("visp-images-data", None, 0.0, "", "at most", note)]
    missed = published["tags"] - published["seater"]["found"]
    rows = []
    for kind, key in (("median", "median_mm"), ("worst", "worst_mm")):
        ours, best = published["seater"][key], published[f"best_opencv_{key}"]
        ratio = None if ours is None or best is None else ours / best
        rows.append((f"visp-images-data: {kind} position error / best of OpenCV's refinements", ratio))
    return [*bars, Bar("visp-images-data: tags missed", missed, 0.0), *(Bar(name, value, 1.0) for name, value in rows)]


def _inside_table_bounds(nees: dict[str, Any], cells: int) -> bool:
    if not nees["count"]:
        return False
    low, high = table_bounds(nees["count"], cells)
    return bool(low <= nees["mean"] <= high)
