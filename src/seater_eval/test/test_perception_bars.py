"""A few cells of the perception commands' tables meet the bars; `./seater test --all` runs the commands themselves."""

from __future__ import annotations

import math
from pathlib import Path

import cv2

from seater_eval.perception.accuracy import COMPARED, QUICK_CELLS, accuracy_bars
from seater_eval.perception.accuracy_cells import BranchJob, CellJob, count_wrong_branches, run_cell
from seater_eval.perception.images.degraded_camera import load_degraded_camera
from seater_eval.perception.images.negatives import KINDS
from seater_eval.perception.published import published_images
from seater_eval.perception.range import range_bars
from seater_eval.perception.range_jobs import PAPER, NegativeJob, RangeJob, count_false, find_limit
from seater_eval.perception.speed import BAR_RESOLUTION, PLAIN, SEARCH, TRACKING, speed_bars, time_case
from seater_eval.report.bars import Bar

CONFIG = str(Path(__file__).resolve().parents[3] / "config")
WORST = "visp-images-data: worst position error / best of OpenCV's refinements"  # nothing can decide it, see its bar


def missed(bars: list[Bar]) -> list[Bar]:
    return [bar for bar in bars if not bar.met and bar.name != WORST]


def test_accuracy() -> None:
    """One cell near, which is what takes long, and all angles far away; with the images of the command."""
    cells = [(0.10, 0.9, 30.0), (0.10, 2.84, 0.0), (0.10, 2.84, 15.0), (0.10, 2.84, 30.0)]
    places = [(QUICK_CELLS.index(cell), cell) for cell in cells]
    jobs = [CellJob(CONFIG, s, z, math.radians(a), 24, 0, COMPARED, i) for i, (s, z, a) in places]
    published = published_images(CONFIG)  # None without Debian's package: a bar that is missed
    branches = count_wrong_branches(BranchJob(CONFIG, 0, 20))
    data = {"quick": True, "cells": [run_cell(job) for job in jobs], "branches": branches, "published": published}
    bars = accuracy_bars(data)
    assert len(bars) >= 9 and missed(bars) == []


def test_range() -> None:
    """The middle size; of the images without markers one of each kind."""
    jobs = [RangeJob(CONFIG, "seater", 0.10, far, 10, 2) for far in (True, False)]
    counts = [count_false(NegativeJob(CONFIG, 0, 2 * len(KINDS))), count_false(NegativeJob(CONFIG, 0, 5, True))]
    data = {
        "quick": True,
        "limits": [find_limit(job) for job in jobs],
        "negatives": {kind: sum(c["shown"][kind] for c in counts) for kind in counts[0]["shown"]},
        "false_detections": [false for c in counts for false in c["false"]],
    }
    assert all(data["negatives"].values())
    others = tuple(f"{1e3 * size:.0f} mm:" for size in PAPER if size != 0.10)
    bars = [bar for bar in range_bars(data) if not bar.name.startswith(others)]
    assert len(bars) == 4 and missed(bars) == []


def test_speed() -> None:
    """Processor times of methods that take turns: other load does not decide."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        camera = load_degraded_camera(f"{CONFIG}/cameras/degraded.yaml").resized(*BAR_RESOLUTION)
        rows = time_case(CONFIG, camera, 3, [SEARCH, TRACKING, PLAIN], 12)
    finally:
        cv2.setNumThreads(threads)
    bars = speed_bars({"rows": rows})
    assert len(bars) == 2 and missed(bars) == []
