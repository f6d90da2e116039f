"""All photographs of all folders through all detectors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml

from seater_common.params import ParameterError
from seater_eval.photographs.board import board_of
from seater_eval.photographs.detectors import OPENCV, SEATER, Image, make_detector, timed
from seater_eval.photographs.measures import Matched, errors_on_board, match
from seater_eval.photographs.truth import Photograph, PhotographFolder, load_folders
from seater_eval.report.statistics import spread
from seater_eval.run.parallel import run_jobs

QUICK_STEP = 5  # every fifth photograph
DETECTORS = (SEATER, OPENCV)


@dataclass(frozen=True)
class PhotographJob:
    """One photograph through one detector."""

    folder: PhotographFolder
    index: int
    detector: str
    parameters: dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Seen:
    """What a detector made of a photograph."""

    matched: Matched
    milliseconds: float


def read_parameters(config: str | Path) -> dict[str, Any]:
    """config/perception.yaml as it is. Raises ParameterError."""
    path = Path(config) / "perception.yaml"
    try:
        return dict(yaml.safe_load(path.read_text()))
    except (OSError, TypeError, ValueError, yaml.YAMLError) as error:
        raise ParameterError(f"cannot read {path}: {error}") from error


def read_image(photograph: Photograph) -> Image:
    """Grey, not turned by EXIF: K and truth count in the file's pixels. Raises ParameterError."""
    image = cv2.imread(str(photograph.path), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
    if image is None or image.shape != (photograph.height, photograph.width):
        size = "no image" if image is None else f"{image.shape[1]} x {image.shape[0]}"
        raise ParameterError(f"{photograph.path}: is {size}, must be {photograph.width} x {photograph.height}")
    return np.ascontiguousarray(image)


def look(job: PhotographJob) -> Seen:
    """Looked at twice: only the second look, with all tables made, is timed."""
    photograph = job.folder.photographs[job.index]
    image = read_image(photograph)
    detect = make_detector(job.detector, job.folder, photograph, job.parameters)
    detect(image)
    detection = timed(detect, image)
    return Seen(matched=match(photograph, detection.found), milliseconds=detection.milliseconds)


def run_photographs(
    photographs: str | Path, config: str | Path, quick: bool, workers: int | None = None
) -> tuple[list[PhotographFolder], dict[tuple[str, str], list[Seen]], dict[str, Any]]:
    """The folders, what was seen by (folder, detector), and the rows of the results. `quick`: every QUICK_STEP-th
    photograph. Raises ParameterError."""
    folders, parameters = load_folders(photographs), read_parameters(config)
    make_detector(SEATER, folders[0], folders[0].photographs[0], parameters)  # wrong parameters: now
    jobs = [
        PhotographJob(folder, index, name, parameters)
        for folder in folders
        for name in DETECTORS
        for index in range(0, len(folder.photographs), QUICK_STEP if quick else 1)
    ]
    seen: dict[tuple[str, str], list[Seen]] = {}
    used: dict[tuple[str, str], list[Photograph]] = {}
    for job, result in zip(jobs, run_jobs(look, jobs, label="perception_photographs", workers=workers), strict=True):
        key = job.folder.name, job.detector
        seen.setdefault(key, []).append(result)
        used.setdefault(key, []).append(job.folder.photographs[job.index])
    rows = [
        row_of(folder, name, used[folder.name, name], seen[folder.name, name])
        for folder in folders
        for name in DETECTORS
    ]
    return folders, seen, {"quick": quick, "photographs": str(photographs), "rows": rows}


def row_of(
    folder: PhotographFolder, name: str, photographs: Sequence[Photograph], seen: Sequence[Seen]
) -> dict[str, Any]:
    """Recall, false finds, errors on the board and times of one detector in one folder."""
    finds = [{i: f.corners for i, f in s.matched.found.items()} for s in seen]
    board = board_of(folder.board, list(zip(photographs, finds, strict=True)), folder.board_marker_side)
    errors = [
        e for p, s in zip(photographs, seen, strict=True) if board for e in errors_on_board(board, p, s.matched.found)
    ]
    stages = [f.stage for s in seen for f in s.matched.found.values() if f.stage]
    return {
        "folder": folder.name,
        "detector": name,
        "images": len(seen),
        "markers": sum(len(p.markers) for p in photographs),
        "found": sum(len(s.matched.found) for s in seen),
        "false": sum(len(s.matched.false) for s in seen),
        "milliseconds": spread(s.milliseconds for s in seen),
        "stages": {stage: stages.count(stage) for stage in sorted(set(stages))},
        "on_board": len(errors),
        "board_marker_side": None if board is None else board_side(folder, board.corners),
        "corner_px": spread(c for e in errors for c in e.corners),
        "inwards_px": float(np.median([e.inwards for e in errors])) if errors else None,
        "certain": sum(e.certain for e in errors),
        "wrong_and_certain": sum(e.wrong_and_certain for e in errors),
        "nees": nees_of(e.nees for e in errors),
        "corner_nees": nees_of(e.corner_nees for e in errors),
    }


def board_side(folder: PhotographFolder, corners: dict[int, Any]) -> float | None:
    """Of a marker, in the unit of `board_marker_centers`."""
    a, b = sorted(corners)[:2]
    return float(
        np.linalg.norm(folder.board[a] - folder.board[b])
        / np.linalg.norm(corners[a].mean(axis=0) - corners[b].mean(axis=0))
    )


def nees_of(values: Any) -> dict[str, float | None]:
    """Mean and spread."""
    numbers = [v for v in values if v is not None]
    return {"mean": float(np.mean(numbers)) if numbers else None, **spread(numbers)}
