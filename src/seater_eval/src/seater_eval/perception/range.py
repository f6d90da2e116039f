"""The paper's Table I: nearest and farthest distance at which a marker is found, and what is found where there is
none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from seater_eval.peers.process import peers_for
from seater_eval.perception import subject
from seater_eval.perception.images.negatives import KINDS, OTHER_IDS
from seater_eval.perception.range_jobs import (
    ALL_IDS,
    CALIBRATION,
    FARTHER,
    NEEDED,
    PAPER,
    PLAIN,
    TRACK,
    NegativeJob,
    RangeJob,
    camera_of,
    count_false,
    find_limit,
)
from seater_eval.report.bars import Bar
from seater_eval.run.long_run import run_long

FULL_METHODS = ("seater", ALL_IDS, TRACK, PLAIN, "opencv_default", "pupil_apriltags")


def run_range(
    config: str | Path,
    quick: bool,
    negatives: int | None = None,
    partial: Path | None = None,
    peers: Path | None = None,
) -> dict[str, Any]:
    """All ends of all ranges, then the images without markers. `partial`: see run_long; `peers`: what
    tools/make_peers.sh made. Raises ParameterError, PeerError."""
    config = str(config)
    camera = camera_of(config)
    subject.make_detector(camera, 0.1, subject.perception_parameters(config), prior=False)  # wrong parameters: now
    methods = ("seater", PLAIN) if quick else FULL_METHODS
    methods = (*methods, *peers_for(subject.DICTIONARY, peers))
    # The frozen camera stands and falls with the plain detector's far end, and its window is narrow: more images there
    # (with `quick` nothing is judged by it: it only runs).
    images, plain_images, steps, plain_steps = (10, 10, 2, 0) if quick else (50, 1000, 6, 1)
    total = negatives if negatives is not None else (100 if quick else 10_000)
    jobs = [
        RangeJob(config, method, size, far, plain_images, plain_steps)
        if method == PLAIN and far
        else RangeJob(config, method, size, far, images, steps, peers)
        for size in PAPER
        for method in methods
        for far in ((True, False) if method == "seater" or not (quick or method == TRACK) else (True,))
    ]
    jobs.sort(key=lambda job: job.far)  # those that take longest first, so that no core waits at the end
    blocks = [NegativeJob(config, first, min(first + 20, total)) for first in range(0, total, 20)]
    others = max(1, total // 10)
    blocks += [NegativeJob(config, first, min(first + 20, others), True) for first in range(0, others, 20)]
    files = subject.result_files(config)
    results = run_long(run_part, [*jobs, *blocks], label="perception_range", files=files, partial=partial)
    limits, counts = results[: len(jobs)], results[len(jobs) :]
    return {
        "quick": quick,
        "conditions": {
            "camera": {k: getattr(camera, k) for k in camera.__dataclass_fields__},
            "images_per_distance": images,
            "images_per_distance_plain_far": plain_images,
            "needed": NEEDED,
            "bisection_steps": steps,
        },
        "limits": limits,
        "negatives": {kind: sum(c["shown"][kind] for c in counts) for kind in (*KINDS, OTHER_IDS)},
        "false_detections": [false for c in counts for false in c["false"]],
    }


def run_part(job: RangeJob | NegativeJob) -> dict[str, Any]:
    """One end of one range, or one block of images without markers."""
    return find_limit(job) if isinstance(job, RangeJob) else count_false(job)


def limit_of(data: dict[str, Any], method: str, size: float, far: bool) -> float | None:
    """[m]; None when it was not measured or not reached."""
    for entry in data["limits"]:
        if (entry["method"], entry["size"], entry["far"]) == (method, size, far):
            return None if entry["limit_m"] is None else float(entry["limit_m"])
    return None


def range_bars(data: dict[str, Any]) -> list[Bar]:
    """Two bars and the check of the camera for each size; no false detection."""
    bars = []
    for size, (nearest, farthest) in PAPER.items():
        name = f"{1e3 * size:.0f} mm"
        plain = limit_of(data, PLAIN, size, True)
        off = None if plain is None else abs(plain / farthest - 1.0)
        near, far = limit_of(data, "seater", size, False), limit_of(data, "seater", size, True)
        if not data["quick"]:  # takes 1000 images a distance: with few of them chance would decide
            bars.append(Bar(f"{name}: plain OpenCV's far limit off the paper's (frozen camera)", off, CALIBRATION))
        bars += [
            Bar(f"{name}: nearest", near, nearest, "m", "at most"),
            Bar(f"{name}: farthest / the paper's", None if far is None else far / farthest, FARTHER, "", "at least"),
        ]
    for others in (False, True):
        shown = sum(n for kind, n in data["negatives"].items() if (kind == OTHER_IDS) == others)
        false = [f for f in data["false_detections"] if (f["kind"] == OTHER_IDS) == others]
        note = ", ".join(f"image {f['image']} ({f['kind']}, {f['method']})" for f in false[:5])
        what = "images of markers that the dock has not" if others else "images without markers"
        bars.append(Bar(f"false detections in {shown} {what}", len(false) if shown else None, 0.0, note=note))
    return bars
