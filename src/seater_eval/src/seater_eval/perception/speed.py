"""Milliseconds per image on one core, at three resolutions, with few and many markers; all methods take turns."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_eval.peers.catalogue import PEERS
from seater_eval.peers.process import PeerProcess, peers_for
from seater_eval.perception import subject
from seater_eval.perception.images.degraded_camera import DegradedCamera, load_degraded_camera
from seater_eval.perception.images.render import Print, clean_image, exposed
from seater_eval.perception.images.scenes import facing
from seater_eval.perception.peers import dictionary_of, make_peer
from seater_eval.perception.timed_detector import Timed, TimedElsewhere, TimedPeer
from seater_eval.report.bars import Bar
from seater_eval.report.statistics import spread
from seater_eval.run.progress import progress_bar

Image = NDArray[np.uint8]
RESOLUTIONS = ((640, 480), (1280, 720), (1920, 1080))
MARKERS, QUICK_MARKERS = (1, 3, 10, 30), (1, 3)
BAR_RESOLUTION = (1280, 720)
SEARCH, TRACKING, PLAIN = "seater search", "seater tracking", "opencv_none"
METHODS = (SEARCH, TRACKING, PLAIN, "opencv_default", "opencv_apriltag", "pupil_apriltags")
SLOWER, TRACKED = 1.3, 0.35
FOUND = 0.9  # fraction of the markers that have to be found
SLOWEST = "opencv_apriltag"  # takes up to a second: measured with a few images only


def scene(camera: DegradedCamera, markers: int, dictionary: str, size: float, shift: float) -> list[Print]:
    """Markers on a wall in a grid that fills the view, `shift` [m] to the side; one marker: in the middle."""
    columns = int(np.ceil(np.sqrt(markers * 16.0 / 9.0)))
    rows = int(np.ceil(markers / columns))
    distance = 0.9 if markers < 4 else 1.5
    half_width = 0.5 * camera.image_width / camera.focal_length * distance
    half_height = 0.5 * camera.image_height / camera.focal_length * distance
    prints = []
    for i in range(markers):
        x = ((i % columns + 0.5) / columns - 0.5) * 1.8 * half_width
        y = ((i // columns + 0.5) / rows - 0.5) * 1.7 * half_height
        prints.append(Print(dictionary, i, size, facing(x + shift, y, distance, 0.1)))
    return prints


def images_of(camera: DegradedCamera, markers: int, dictionary: str, size: float, count: int) -> list[Image]:
    """A sequence in which the camera moves 2 mm to the side from image to image."""
    random = np.random.default_rng(5)
    return [
        exposed(clean_image(scene(camera, markers, dictionary, size, 0.002 * k), camera), camera.noise_sd, random)
        for k in range(count)
    ]


def time_case(
    config: str, camera: DegradedCamera, markers: int, names: list[str], repeats: int, peers: Path | None = None
) -> list[dict[str, Any]]:
    """Processor time of this thread for each method on the same sequence, in turns, after one image to warm up. Raises
    PeerError."""
    size = 0.06 if markers >= 10 else 0.1
    parameters = subject.perception_parameters(config)
    detectors: dict[str, Timed] = {}
    for name in names:
        if name in (SEARCH, TRACKING):
            made = subject.make_detector(camera, size, parameters, prior=False, tracking=name == TRACKING)
            detectors[name] = Timed(subject.as_peer(made))
        elif name == "pupil_apriltags":
            detectors[name] = TimedElsewhere(name, camera.K, size)
        elif peers is not None and name in PEERS:
            detectors[name] = TimedPeer(PeerProcess(peers, name, dictionary_of(name)))
        else:
            detectors[name] = Timed(make_peer(name, camera.K, size))
    sequences = {d: images_of(camera, markers, d, size, repeats + 1) for d in {dictionary_of(n) for n in names}}
    times: dict[str, list[float]] = {name: [] for name in names}
    found: dict[str, list[int]] = {name: [] for name in names}
    for k in range(repeats + 1):
        for name in names:
            if name == SLOWEST and k > 3:
                continue
            image = sequences[dictionary_of(name)][k]
            ids, taken = detectors[name](image)
            if k > 0:
                times[name].append(taken)
                found[name].append(len(ids))
    for detector in detectors.values():
        detector.end()
    base = {"width": camera.image_width, "height": camera.image_height, "markers": markers}
    return [
        {**base, "method": n, "cpu_ms": spread(times[n]), "found": float(np.mean(found[n])), "images": len(times[n])}
        for n in names
    ]


def run_speed(config: str | Path, quick: bool, peers: Path | None = None) -> dict[str, Any]:
    """All cases, one after another in this process. `peers`: what tools/make_peers.sh made. Raises ParameterError,
    PeerError."""
    cv2.setNumThreads(1)
    config = str(config)
    camera = load_degraded_camera(Path(config) / "cameras" / "degraded.yaml")
    names = [*METHODS, *peers_for(subject.DICTIONARY, peers)]
    if quick:
        names = [name for name in names if name != SLOWEST]
    resolutions, counts, repeats = ((BAR_RESOLUTION,), QUICK_MARKERS, 12) if quick else (RESOLUTIONS, MARKERS, 40)
    rows = []
    with progress_bar("perception_speed", len(resolutions) * len(counts)) as progress:
        for width, height in resolutions:
            for markers in counts:
                rows += time_case(config, camera.resized(width, height), markers, names, repeats, peers)
                progress.update()
    return {
        "quick": quick,
        "conditions": {
            "time": "processor time of the thread, OpenCV with one thread, methods in turns on the same images",
            "pupil_apriltags": "quad_decimate 1 (its most accurate setting), tags of 36h11 in the same places",
            "cores": os.cpu_count(),
            "load_average": os.getloadavg(),
        },
        "rows": rows,
    }


def _row(data: dict[str, Any], method: str, markers: int) -> dict[str, Any] | None:
    """At the resolution of the bars; None when it was not measured."""
    for row in data["rows"]:
        if (row["method"], row["width"], row["height"], row["markers"]) == (method, *BAR_RESOLUTION, markers):
            return dict(row) if row["cpu_ms"]["median"] is not None else None
    return None


def mostly_found(row: dict[str, Any]) -> bool:
    return bool(row["found"] >= FOUND * row["markers"])


def speed_bars(data: dict[str, Any]) -> list[Bar]:
    """Ratios to plain OpenCV within this run, for each number of markers. Our time says nothing where we do not find
    them; what plain OpenCV does not find only makes it quicker."""
    bars = []
    for method, limit in ((SEARCH, SLOWER), (TRACKING, TRACKED)):
        for markers in sorted({row["markers"] for row in data["rows"]}):
            ours, plain = (_row(data, name, markers) for name in (method, PLAIN))
            ratio, note = None, "not measured, or not all markers found"
            if ours is not None and plain is not None and mostly_found(ours):
                ratio = ours["cpu_ms"]["median"] / plain["cpu_ms"]["median"]
                p95 = [row["cpu_ms"]["p95"] for row in (ours, plain)]
                note = f"median of {ours['images']}; p95 {p95[0]:.1f} ms, plain {p95[1]:.1f} ms"
                note += "" if mostly_found(plain) else f"; plain finds {plain['found']:.1f}"
            name = f"{method} / plain OpenCV detection, 1280 x 720, {markers} markers"
            bars.append(Bar(name, ratio, limit, note=note))
    return bars
