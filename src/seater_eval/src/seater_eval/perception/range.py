"""The paper's Table I: nearest and farthest distance at which a marker is found, and what is found where there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import takewhile
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from seater_eval.perception import subject
from seater_eval.perception.images.degraded_camera import DegradedCamera, load_degraded_camera
from seater_eval.perception.images.negatives import KINDS, OTHER_IDS, negative
from seater_eval.perception.images.render import Image, Print, clean_image, exposed
from seater_eval.perception.images.scenes import facing
from seater_eval.perception.peers import LABELS, Detector, dictionary_of, make_peer
from seater_eval.report.bars import Bar
from seater_eval.report.evaluation_style import figure, save
from seater_eval.report.tables import text_table
from seater_eval.run.long_run import run_long
from seater_eval.run.parallel import job_seed

PAPER = {0.05: (0.050, 1.500), 0.10: (0.090, 2.840), 0.15: (0.140, 3.750)}  # side -> nearest, farthest [m]
NEEDED = 0.9  # share of images in which the marker has to be found
FARTHER, CALIBRATION = 1.5, 0.1
ALL_IDS, TRACK, PLAIN = "seater, all ids", "seater, tracking", "opencv_none"
FULL_METHODS = ("seater", ALL_IDS, TRACK, PLAIN, "opencv_default", "pupil_apriltags")
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
}
DOCK_IDS = (0, 1, 2)  # of config/docks/default.yaml: what the nodelet looks for
AWAY = 0.03  # tracking: how much farther away from image to image [parts of the distance]


@dataclass(frozen=True)
class RangeJob:
    """One end of one method's range."""

    config: str
    method: str
    size: float  # [m]
    far: bool
    images: int
    steps: int


@dataclass(frozen=True)
class NegativeJob:
    """Images first .. last - 1 without markers."""

    config: str
    first: int
    last: int
    other_ids: bool = False  # instead: markers of the same dictionary that the dock has not


def camera_of(config: str | Path) -> DegradedCamera:
    """The frozen camera. Raises ParameterError."""
    return load_degraded_camera(Path(config) / "cameras" / "degraded.yaml")


@lru_cache(maxsize=32)
def _detector(config: str, method: str, size: float) -> Detector:
    """Never one that tracks: that one has a memory."""
    camera = camera_of(config)
    if method in ("seater", ALL_IDS):
        return subject.as_peer(_subject(config, method, size))
    return make_peer(method, camera.K, size)


def _subject(config: str, method: str, size: float) -> Any:
    """seater as the nodelet runs it, with a dock whose markers are known; or with every id of the dictionary."""
    camera, parameters = camera_of(config), subject.perception_parameters(config)
    known = method != ALL_IDS
    return subject.make_detector(camera, size, parameters, prior=known, tracking=method == TRACK, ids=DOCK_IDS)


def _image(config: str, method: str, size: float, distance: float, index: int, near: bool) -> tuple[Image, int]:
    """Image number `index` of a marker at this distance, and its id. `near`: it fills the image, so it is in the middle."""
    camera = camera_of(config)
    random = np.random.default_rng(job_seed(7, index))
    spread, tilt = (0.0005, 0.001) if near else (0.1, 0.05)
    x, y = random.uniform(-spread, spread, 2) * distance
    turn = random.uniform(-tilt, tilt, 3)
    pose = facing(float(x), float(y), distance, *(float(a) for a in turn))
    marker = int(random.integers(0, 50))
    if method in ("seater", TRACK):
        marker = DOCK_IDS[marker % len(DOCK_IDS)]
    print_ = Print(dictionary_of(method), marker, size, pose)
    return exposed(clean_image([print_], camera), camera.noise_sd, random), marker


def detection_rate(config: str, method: str, size: float, distance: float, images: int, near: bool) -> float:
    """Share of images, each for itself, in which the marker is found with its id."""
    if method == TRACK:
        return tracking_rate(config, size, distance, images)
    detect, found = _detector(config, method, size), 0
    for index in range(images):
        image, marker = _image(config, method, size, distance, index, near)
        found += any(seen.id == marker for seen in detect(image))
    return found / images


def tracking_rate(config: str, size: float, distance: float, images: int) -> float:
    """Share of images at this distance in which the track shows the marker, after it was followed there from the distance
    at which the paper's camera sees it. What is lost on the way has to be found again by a full search."""
    camera = camera_of(config)
    tracker, found = _subject(config, TRACK, size), 0
    start = min(0.8 * PAPER[size][1], distance)
    way = [start * (1.0 + AWAY) ** k for k in range(math.ceil(math.log(distance / start) / math.log(1.0 + AWAY)))]
    random = np.random.default_rng(job_seed(8, round(1e4 * distance)))
    turn = random.uniform(-0.05, 0.05, 3)
    for index, z in enumerate([*way, *([distance] * images)]):
        x, y = (float(a) * z for a in 0.05 + random.uniform(-0.002, 0.002, 2))  # the chair sways
        print_ = Print(subject.DICTIONARY, 0, size, facing(x, y, z, *(float(a) for a in turn)))
        image = exposed(clean_image([print_], camera), camera.noise_sd, random)
        seen = any(m.id == 0 for m in tracker.detect(image).markers)
        found += seen and index >= len(way)
    return found / images


def find_limit(job: RangeJob) -> dict[str, Any]:
    """The end of the range by bisection: the last distance [m] with NEEDED detections, None when it is not reached at all."""
    nearest, farthest = PAPER[job.size]
    rates: dict[float, float] = {}

    def good(distance: float) -> bool:
        if distance not in rates:
            rates[distance] = detection_rate(job.config, job.method, job.size, distance, job.images, not job.far)
        return rates[distance] >= NEEDED

    # What bars ask for is measured there, not between two steps.
    if not job.far:
        probes = [2.5 * nearest, nearest, 0.5 * nearest]
    elif job.method == PLAIN:
        probes = [share * farthest for share in (0.5, 1.0 - CALIBRATION, 1.0, 1.0 + CALIBRATION, 4.0)]
    else:
        probes = [share * farthest for share in (0.5, 1.0, FARTHER, 4.0)]
    # The first one and the last one are only looked at when the others do not decide.
    passed = list(takewhile(good, probes[1:-1]))
    inside = passed[-1] if passed else probes[0]
    outside = probes[probes.index(inside) + 1]
    if passed or good(inside):
        for _ in range(job.steps):
            middle = float(np.sqrt(inside * outside))
            inside, outside = (middle, outside) if good(middle) else (inside, middle)
    limit = inside if good(inside) else None
    rows = [{"distance": distance, "rate": rate} for distance, rate in sorted(rates.items())]
    return {"method": job.method, "size": job.size, "far": job.far, "limit_m": limit, "rates": rows}


def count_false(job: NegativeJob) -> dict[str, Any]:
    """Images shown by kind, and what was seen in them: by the detector that looks for the dock's ids and by the one that
    looks for every id of the dictionary (neither contains the other: with more ids, codes too much alike are refused)."""
    shown, false = dict.fromkeys((*KINDS, OTHER_IDS), 0), []
    for index in range(job.first, job.last):
        kind = OTHER_IDS if job.other_ids else KINDS[index % len(KINDS)]
        image = negative_image(job.config, kind, index)
        shown[kind] += 1
        for method in ("seater",) if job.other_ids else ("seater", ALL_IDS):
            seen = _detector(job.config, method, 0.1)(image)
            false += [{"image": index, "kind": kind, "method": method, "id": s.id, "corners": s.corners} for s in seen]
    return {"shown": shown, "false": false}


def negative_image(config: str | Path, kind: str, index: int) -> Image:
    """Image number `index` of those without markers. The detector's threshold was chosen on others (seed 11)."""
    camera = camera_of(config)
    size = camera.image_width, camera.image_height
    return negative(kind, *size, camera.blur_sd, camera.noise_sd, job_seed(12, index))


def run_range(
    config: str | Path, quick: bool, negatives: int | None = None, partial: Path | None = None
) -> dict[str, Any]:
    """All ends of all ranges, then the images without markers. `partial`: see run_long. Raises ParameterError."""
    config = str(config)
    camera = camera_of(config)
    subject.make_detector(camera, 0.1, subject.perception_parameters(config), prior=False)  # wrong parameters: now
    methods = ("seater", PLAIN) if quick else FULL_METHODS
    # The frozen camera stands and falls with the plain detector's far end, and its window is narrow: more images there.
    images, plain_images, steps, plain_steps = (10, 60, 2, 0) if quick else (50, 1000, 6, 1)
    total = negatives if negatives is not None else (100 if quick else 10_000)
    jobs = [
        RangeJob(config, method, size, far, plain_images, plain_steps)
        if method == PLAIN and far
        else RangeJob(config, method, size, far, images, steps)
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
