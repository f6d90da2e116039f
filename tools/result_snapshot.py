#!/usr/bin/env python3
"""Prove that a change of shape changed no result: store results before it, compare to the last bit after it.

usage (from the repository, in the project's environment):
  ./seater run python3 tools/result_snapshot.py write before.json
  ... refactor, build ...
  ./seater run python3 tools/result_snapshot.py compare before.json

Stored are detections (all markers, corners, poses, covariances, the dock's poses) on some 180 rendered images, 30
images without markers and, where ../shared/data/real_markers stands beside the repository, the photographs, with four
configurations; a tracked sequence; and runs of the controller's campaign. Numbers are stored as their shortest text
that reads back to the same bits. Equal means equal on one machine: other processors and libraries round otherwise.
"""

from __future__ import annotations

import argparse
import copy
import json
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

import seater_perception as sp
from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import load_file
from seater_eval.control.controller_campaign import run_campaign
from seater_eval.perception.images.degraded_camera import load_degraded_camera
from seater_eval.perception.images.negatives import KINDS, OTHER_IDS, negative
from seater_eval.perception.images.render import Print, clean_image, exposed
from seater_eval.perception.images.scenes import upright
from seater_eval.run.progress import progress_bar
from seater_sim.camera.camera import Camera

ROOT = Path(__file__).resolve().parent.parent
PHOTOGRAPHS = ROOT.parent / "shared" / "data" / "real_markers"
DICTIONARY = "DICT_4X4_50"
VARIANTS: dict[str, dict[str, Any]] = {
    "default": {},
    "corners": {"refinement": "corners_visp", "detector": {"min_evidence": 2.5}},
    "opencv": {"detector": {"search": "opencv"}},
    "lowest": {"selection": "lowest_id", "photometric": {"blur": "estimated"}},
}
NOT_COMPARED = {"solve_ms", "solve_max_ms"}  # wall time


@dataclass(frozen=True)
class Shot:
    """An image and what is known about it."""

    name: str
    pixels: NDArray[np.uint8]
    K: list[float]
    D: list[float] = field(default_factory=lambda: [0.0] * 5)
    dictionary: str = DICTIONARY
    size: float = 0.1  # [m]
    of_dock: bool = False  # the configured dock is looked for; else markers of one size


def rendered(config: Path) -> Iterator[Shot]:
    """The evaluation's renderer: three sizes, seven distances, four angles, each fifth with motion blur; negatives."""
    camera, rng = load_degraded_camera(config / "cameras" / "degraded.yaml"), np.random.default_rng(5)
    K = [float(k) for k in camera.K.ravel()]
    index = 0
    for size in (0.05, 0.1, 0.15):
        for distance in (0.2, 0.35, 0.7, 1.25, 2.0, 2.84, 4.0):
            for yaw in (0, 15, 30, 45):
                pose = upright(distance, math.radians(yaw), rng)
                motion = (3.0, 1.0) if index % 5 == 0 else (0.0, 0.0)
                light = clean_image([Print(DICTIONARY, index % 50, size, pose)], camera, motion)
                pixels = exposed(light, camera.noise_sd, np.random.default_rng(1000 + index))
                yield Shot(f"render_{index:03d}", pixels, K, size=size)
                index += 1
    for kind, name in enumerate([*KINDS, OTHER_IDS]):
        for i in range(5):
            pixels = negative(
                name, camera.image_width, camera.image_height, camera.blur_sd, camera.noise_sd, 100 * kind + i
            )
            yield Shot(f"negative_{kind}_{i}", pixels, K)


def simulated(config: Path) -> Iterator[Shot]:
    """The simulator's camera on a way to the dock, now and then with a covered marker."""
    values = yaml.safe_load((config / "cameras" / "d455.yaml").read_text())
    camera = Camera(
        CameraModel.from_mapping(values), Chair().camera, load_file(Dock, config / "docks" / "default.yaml")
    )
    for i in range(60):
        pose = (-3.2 + 3.2 * i / 59, 0.3 * math.cos(i / 12), 0.15 * math.sin(i / 9))
        pixels = camera.render(pose, 0.3 if i % 3 else 0.0, 0.1, covered=[0] if i % 11 == 0 else [], seed=3, index=i)
        yield Shot(f"simulated_{i:02d}", pixels, [float(k) for k in values["camera_matrix"]["data"]], of_dock=True)


def photographs() -> Iterator[Shot]:
    """None, with a message, where the folder is not there."""
    if not PHOTOGRAPHS.is_dir():
        print(f"{PHOTOGRAPHS} is not there: no photographs in this comparison", file=sys.stderr)
        return
    for truth in sorted(PHOTOGRAPHS.glob("*/truth.json")):
        content = json.loads(truth.read_text())
        for name, image in content["images"].items():
            pixels = cv2.imread(str(truth.parent / name), cv2.IMREAD_GRAYSCALE)
            yield Shot(f"{truth.parent.name}/{name}", pixels, image["K"], image["D"], content["dictionary"])


def with_progress(shots: list[Shot]) -> Iterator[Shot]:
    with progress_bar("images", len(shots)) as bar:
        for shot in shots:
            yield shot
            bar.update()


def exact(values: Any) -> list[str]:
    return [repr(float(value)) for value in np.ravel(values)]


def hypothesis(h: Any) -> dict[str, Any]:
    return {
        "pose": exact(h.pose),
        "covariance": exact(h.covariance),
        "error": exact(h.error),
        "weight": exact(h.weight),
    }


def result(found: Any) -> dict[str, Any]:
    markers = [
        {"id": m.id, "corners": exact(m.corners), "hypotheses": [hypothesis(h) for h in m.hypotheses]}
        for m in found.markers
    ]
    return {"markers": markers, "dock": [hypothesis(h) for h in found.dock]}


def merged(values: dict[str, Any], change: dict[str, Any]) -> dict[str, Any]:
    values = copy.deepcopy(values)
    for key, value in change.items():
        values[key] = merged(values[key], value) if isinstance(value, dict) else value
    return values


def detections(config: Path) -> dict[str, Any]:
    """Of every image with every variant, and of the simulated ones as a tracked sequence."""
    defaults = yaml.safe_load((config / "perception.yaml").read_text())
    dock = sp.load_dock_layout(yaml.safe_load((config / "docks" / "default.yaml").read_text()))
    parameters = {name: merged(defaults, change) for name, change in VARIANTS.items()}
    results, tracker = {}, None
    for shot in with_progress([*rendered(config), *simulated(config), *photographs()]):
        height, width = shot.pixels.shape
        camera = sp.CameraModel.raw(sp.Calibration(width, height, shot.K, shot.D))
        layout = dock if shot.of_dock else sp.layout_of_equal_markers(shot.dictionary, shot.size)
        for name, values in parameters.items():
            results[f"{shot.name} {name}"] = result(sp.DockDetector(camera, layout, values).detect(shot.pixels))
        if shot.of_dock:
            tracker = tracker or sp.DockTracker(camera, layout, defaults)
            results[f"{shot.name} tracked"] = result(tracker.detect(shot.pixels))
    return results


def snapshot(config: Path, runs: int) -> dict[str, Any]:
    campaign = run_campaign(config, runs)["runs"] if runs else []
    rows = [{key: value for key, value in run.items() if key not in NOT_COMPARED} for run in campaign]
    return {"detections": detections(config), "campaign": json.loads(json.dumps(rows, default=lambda a: a.tolist()))}


def differences(before: Any, after: Any, path: str = "") -> Iterator[str]:
    """Places where two snapshots differ."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in sorted({*before, *after}):
            if key in before and key in after:
                yield from differences(before[key], after[key], f"{path}/{key}")
            else:
                yield f"{path}/{key}: only {'before' if key in before else 'after'}"
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for i, (a, b) in enumerate(zip(before, after, strict=True)):
            yield from differences(a, b, f"{path}[{i}]")
    elif before != after:
        yield f"{path}: {before} -> {after}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("action", choices=("write", "compare"))
    parser.add_argument("file", type=Path)
    parser.add_argument("--runs", type=int, default=40, help="of the campaign (%(default)s)")
    parser.add_argument(
        "--config", type=Path, default=ROOT / "config", help="folder of the configuration (%(default)s)"
    )
    options = parser.parse_args()
    before = json.loads(options.file.read_text()) if options.action == "compare" else None
    now = snapshot(options.config, len(before["campaign"]) if before else options.runs)
    if before is None:
        options.file.write_text(json.dumps(now, indent=0) + "\n")
        print(f"{options.file}: {len(now['detections'])} detections, {len(now['campaign'])} runs")
        return 0
    found = list(differences(before, now))
    print("\n".join(found[:40]))
    print(f"{len(now['detections'])} detections, {len(now['campaign'])} runs, {len(found)} differences")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
