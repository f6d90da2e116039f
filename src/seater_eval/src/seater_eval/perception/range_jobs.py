"""One end of one range by bisection; what is found in images without markers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np

from seater_eval.perception import subject
from seater_eval.perception.images.degraded_camera import DegradedCamera, load_degraded_camera
from seater_eval.perception.images.negatives import KINDS, OTHER_IDS, negative
from seater_eval.perception.images.render import Image, Print, clean_image, exposed
from seater_eval.perception.images.scenes import facing
from seater_eval.perception.peers import Detector, dictionary_of, make_peer
from seater_eval.run.parallel import job_seed

PAPER = {0.05: (0.050, 1.500), 0.10: (0.090, 2.840), 0.15: (0.140, 3.750)}  # side -> nearest, farthest [m]
NEEDED = 0.9  # fraction of the images in which the marker has to be found
FARTHER, CALIBRATION = 1.5, 0.1
ALL_IDS, TRACK, PLAIN = "seater, all ids", "seater, tracking", "opencv_none"
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
    peers: Path | None = None  # what tools/make_peers.sh made, for methods of seater_eval.peers


@dataclass(frozen=True)
class NegativeJob:
    """Images first .. last - 1 without markers."""

    config: str
    first: int
    last: int
    other_ids: bool = False  # instead: markers of the same dictionary that the dock has not


@lru_cache(maxsize=4)
def camera_of(config: str | Path) -> DegradedCamera:
    """The frozen camera. Raises ParameterError."""
    return load_degraded_camera(Path(config) / "cameras" / "degraded.yaml")


@lru_cache(maxsize=32)
def _detector(config: str, method: str, size: float, peers: Path | None) -> Detector:
    """Never one that tracks: that one has a memory."""
    camera = camera_of(config)
    if method in ("seater", ALL_IDS):
        return subject.as_peer(_subject(config, method, size))
    return make_peer(method, camera.K, size, dictionary_of(method), peers)


def _subject(config: str, method: str, size: float) -> Any:
    """seater as the nodelet runs it, with a dock whose markers are known; or with every id of the dictionary."""
    camera, parameters = camera_of(config), subject.perception_parameters(config)
    known = method != ALL_IDS
    return subject.make_detector(camera, size, parameters, prior=known, tracking=method == TRACK, ids=DOCK_IDS)


def _image(config: str, method: str, size: float, distance: float, index: int, near: bool) -> tuple[Image, int]:
    """Image `index` of a marker at this distance, and its id. `near`: it fills the image, so it is in the middle."""
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


def detection_rate(job: RangeJob, distance: float) -> float:
    """Fraction of the images, each for itself, in which the marker is found with its id."""
    if job.method == TRACK:
        return tracking_rate(job.config, job.size, distance, job.images)
    detect, found = _detector(job.config, job.method, job.size, job.peers), 0
    for index in range(job.images):
        image, marker = _image(job.config, job.method, job.size, distance, index, not job.far)
        found += any(seen.id == marker for seen in detect(image))
    return found / job.images


def tracking_rate(config: str, size: float, distance: float, images: int) -> float:
    """Fraction of the images at this distance in which the tracker shows the marker.

    It was tracked there from the distance at which the paper's camera sees it. What is lost on the way has to be found
    again by a full search.
    """
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
    """End of the range by bisection: the last distance [m] with NEEDED detections, None when not reached at all."""
    nearest, farthest = PAPER[job.size]
    rates: dict[float, float] = {}

    def good(distance: float) -> bool:
        if distance not in rates:
            rates[distance] = detection_rate(job, distance)
        return rates[distance] >= NEEDED

    # What bars ask for is measured there, not between two steps.
    if not job.far:
        probes = [2.5 * nearest, nearest, 0.5 * nearest]
    elif job.method == PLAIN:
        probes = [factor * farthest for factor in (0.5, 1.0 - CALIBRATION, 1.0, 1.0 + CALIBRATION, 4.0)]
    else:
        probes = [factor * farthest for factor in (0.5, 1.0, FARTHER, 4.0)]
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
    """Images shown by kind, and what was seen in them, by two detectors.

    One looks for the dock's ids, the other for every id of the dictionary. Neither result contains the other: with more
    ids, codes too much alike are refused.
    """
    shown, false = dict.fromkeys((*KINDS, OTHER_IDS), 0), []
    for index in range(job.first, job.last):
        kind = OTHER_IDS if job.other_ids else KINDS[index % len(KINDS)]
        image = negative_image(job.config, kind, index)
        shown[kind] += 1
        for method in ("seater",) if job.other_ids else ("seater", ALL_IDS):
            seen = _detector(job.config, method, 0.1, None)(image)
            false += [{"image": index, "kind": kind, "method": method, "id": s.id, "corners": s.corners} for s in seen]
    return {"shown": shown, "false": false}


def negative_image(config: str | Path, kind: str, index: int) -> Image:
    """Image number `index` of those without markers. The detector's threshold was chosen on others (seed 11)."""
    camera = camera_of(config)
    size = camera.image_width, camera.image_height
    return negative(kind, *size, camera.blur_sd, camera.noise_sd, job_seed(12, index))
