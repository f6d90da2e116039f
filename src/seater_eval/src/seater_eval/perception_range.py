"""The paper's Table I: nearest and farthest distance at which a marker is found, and what is found where there is none."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from seater_eval.bars import Bar, text_table
from seater_eval.evaluation_style import figure, save
from seater_eval.parallel import job_seed, run_jobs
from seater_eval.perception import subject
from seater_eval.perception.degraded_camera import DegradedCamera, load_degraded_camera
from seater_eval.perception.negatives import KINDS, negative
from seater_eval.perception.peers import LABELS, Detector, dictionary_of, make_peer
from seater_eval.perception.render import Print, clean_picture, exposed
from seater_eval.perception.scenes import facing

PAPER = {0.05: (0.050, 1.500), 0.10: (0.090, 2.840), 0.15: (0.140, 3.750)}  # side -> nearest, farthest [m]
NEEDED = 0.9  # share of pictures in which the marker has to be found
FARTHER, CALIBRATION = 1.5, 0.1
FULL_METHODS = ("seater", "opencv_none", "opencv_default", "pupil_apriltags")
COLOURS = {"seater": "#2e9e4f", "opencv_none": "#c03030", "opencv_default": "#d1852c", "pupil_apriltags": "#1f6fb4"}


@dataclass(frozen=True)
class RangeJob:
    """One end of one method's range."""

    config: str
    method: str
    size: float  # [m]
    far: bool
    pictures: int
    steps: int


@dataclass(frozen=True)
class NegativeJob:
    """Pictures first .. last - 1 without markers."""

    config: str
    first: int
    last: int


def camera_of(config: str | Path) -> DegradedCamera:
    """The frozen camera. Raises ParameterError."""
    return load_degraded_camera(Path(config) / "cameras" / "degraded.yaml")


@lru_cache(maxsize=16)
def _detector(config: str, method: str, size: float) -> Detector:
    camera = camera_of(config)
    if method == "seater":
        parameters = subject.perception_parameters(config)
        return subject.as_peer(subject.make_detector(camera, size, parameters, prior=False))
    return make_peer(method, camera.K, size)


def detection_rate(config: str, method: str, size: float, distance: float, pictures: int, near: bool) -> float:
    """Share of pictures in which the marker is found with its id. `near`: it fills the picture, so it is in the middle."""
    camera, detect = camera_of(config), _detector(config, method, size)
    found = 0
    for index in range(pictures):
        random = np.random.default_rng(job_seed(7, index))
        spread, tilt = (0.0005, 0.001) if near else (0.1, 0.05)
        x, y = random.uniform(-spread, spread, 2) * distance
        turn = random.uniform(-tilt, tilt, 3)
        pose = facing(float(x), float(y), distance, *(float(a) for a in turn))
        print_ = Print(dictionary_of(method), int(random.integers(0, 50)), size, pose)
        picture = exposed(clean_picture([print_], camera), camera.noise_sd, random)
        found += any(seen.id == print_.id for seen in detect(picture))
    return found / pictures


def find_limit(job: RangeJob) -> dict[str, Any]:
    """The end of the range by bisection: the last distance [m] with NEEDED detections, None when it is not reached at all."""
    nearest, farthest = PAPER[job.size]
    inside, outside = (0.5 * farthest, 4.0 * farthest) if job.far else (2.5 * nearest, 0.5 * nearest)
    rates = []

    def good(distance: float) -> bool:
        rate = detection_rate(job.config, job.method, job.size, distance, job.pictures, not job.far)
        rates.append((distance, rate))
        return rate >= NEEDED

    if not good(inside):
        return {"method": job.method, "size": job.size, "far": job.far, "limit_m": None, "rates": rates}
    # The paper's own distance (and the far bar) first: what decides is measured there, not between two steps.
    for probe in (farthest, FARTHER * farthest) if job.far else (nearest,):
        if not good(probe):
            outside = probe
            break
        inside = probe
    for _ in range(job.steps):
        middle = float(np.sqrt(inside * outside))
        inside, outside = (middle, outside) if good(middle) else (inside, middle)
    limit = inside
    return {"method": job.method, "size": job.size, "far": job.far, "limit_m": limit, "rates": sorted(rates)}


def count_false(job: NegativeJob) -> dict[str, int]:
    """False detections by kind of picture; every marker of the dictionary counts."""
    camera, detect = camera_of(job.config), _detector(job.config, "seater", 0.1)
    counts = dict.fromkeys(KINDS, 0)
    for index in range(job.first, job.last):
        kind = KINDS[index % len(KINDS)]
        picture = negative(
            kind, camera.image_width, camera.image_height, camera.blur_sd, camera.noise_sd, job_seed(11, index)
        )
        counts[kind] += len(detect(picture))
    return counts


def run_range(config: str | Path, quick: bool, negatives: int | None = None) -> dict[str, Any]:
    """All ends of all ranges, then the pictures without markers."""
    config = str(config)
    camera = camera_of(config)
    subject.make_detector(camera, 0.1, subject.perception_parameters(config), prior=False)  # wrong parameters: now
    methods = ("seater", "opencv_none") if quick else FULL_METHODS
    pictures, steps = (10, 3) if quick else (50, 6)
    total = negatives if negatives is not None else (100 if quick else 10_000)
    jobs = [
        RangeJob(config, method, size, far, pictures, steps)
        for size in PAPER
        for method in methods
        for far in ((True, False) if method == "seater" or not quick else (True,))
    ]
    limits = run_jobs(find_limit, jobs, label="range")
    blocks = [NegativeJob(config, first, min(first + 20, total)) for first in range(0, total, 20)]
    counts = run_jobs(count_false, blocks, label="pictures without markers")
    return {
        "quick": quick,
        "conditions": {
            "camera": {k: getattr(camera, k) for k in camera.__dataclass_fields__},
            "pictures_per_distance": pictures,
            "needed": NEEDED,
            "bisection_steps": steps,
        },
        "limits": limits,
        "negatives": total,
        "false_detections": {kind: sum(c[kind] for c in counts) for kind in KINDS},
    }


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
        plain = limit_of(data, "opencv_none", size, True)
        off = None if plain is None else abs(plain / farthest - 1.0)
        near, far = limit_of(data, "seater", size, False), limit_of(data, "seater", size, True)
        bars += [
            Bar(f"{name}: plain OpenCV's far limit off the paper's (frozen camera)", off, CALIBRATION),
            Bar(f"{name}: nearest", near, nearest, "m", "at most"),
            Bar(f"{name}: farthest / the paper's", None if far is None else far / farthest, FARTHER, "", "at least"),
        ]
    false = sum(data["false_detections"].values())
    return [*bars, Bar(f"false detections in {data['negatives']} pictures without markers", false, 0.0)]


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
            rows.append(["", LABELS[method], *shown, "-" if far is None else f"{far / farthest:.2f}"])
    table = text_table(["marker", "method", "nearest mm", "farthest mm", "x paper"], rows)
    false = ", ".join(f"{kind} {count}" for kind, count in data["false_detections"].items())
    return f"{table}\n  False detections in {data['negatives']} pictures without markers: {false}"


def draw_range(data: dict[str, Any], path: Path) -> Path:
    """From nearest to farthest for each size and method."""
    fig, axes = figure(1, width=9.0, height=5.0)
    methods = list(dict.fromkeys(entry["method"] for entry in data["limits"]))
    step, at, ticks = 1.0 / (len(methods) + 2), 0.0, []
    for size, (nearest, farthest) in PAPER.items():
        bars = [("paper (published)", "#8a8f98", nearest, farthest)]
        for method in methods:
            near, far = (limit_of(data, method, size, end) for end in (False, True))
            if far is not None:
                bars.append((LABELS[method], COLOURS[method], near or nearest, far))
        for i, (label, colour, near, far) in enumerate(bars):
            y = at - i * step
            first = size == next(iter(PAPER))
            axes.barh(y, far - near, left=near, height=0.8 * step, color=colour, label=label if first else None)
            axes.text(far * 1.03, y, f"{far:.2f} m", va="center", fontsize=8)
        ticks.append(at - 0.5 * (len(bars) - 1) * step)
        at -= 1.0
    axes.set_yticks(ticks, [f"{1e3 * size:.0f} mm marker" for size in PAPER])
    axes.set_xscale("log")
    marks = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
    axes.set_xticks(marks, [f"{m:g}" for m in marks])
    axes.minorticks_off()
    axes.set(xlabel="distance [m]", xlim=(0.03, 20.0), title="Where at least 90 % of the pictures give the marker")
    axes.grid(alpha=0.3, axis="x")
    axes.set_ylim(min(ticks) - 0.6, 1.1)
    axes.legend(fontsize=8, loc="upper left", ncols=3)
    return save(fig, path)
