"""All photographs of all folders through all detectors."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from seater_common.params import ParameterError, read_yaml
from seater_eval.peers.process import peers_for
from seater_eval.photographs.detectors import CORNERS, OPENCV, PLAIN, SEATER, Image, make_detector
from seater_eval.photographs.measures import match
from seater_eval.photographs.rows import Seen, folder_rows
from seater_eval.photographs.truth import Photograph, PhotographFolder, load_folders
from seater_eval.photographs.unlisted import with_unlisted
from seater_eval.run.parallel import run_jobs

QUICK_STEP = 5  # every fifth photograph
DETECTORS = (SEATER, CORNERS, OPENCV, PLAIN)


@dataclass(frozen=True)
class PhotographJob:
    """One photograph through one detector."""

    folder: PhotographFolder
    index: int
    detector: str
    parameters: dict[str, Any]
    peers: Path | None = None


def read_parameters(config: str | Path) -> dict[str, Any]:
    """config/perception.yaml as it is. Raises ParameterError."""
    path = Path(config) / "perception.yaml"
    try:
        return dict(read_yaml(path))
    except (TypeError, ValueError) as error:
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
    detect = make_detector(job.detector, job.folder, photograph, job.parameters, job.peers)
    detect(image)
    detection = detect(image)
    matched = with_unlisted(job.folder, photograph, match(photograph, detection.found))
    return Seen(matched=matched, milliseconds=detection.milliseconds)


def run_photographs(
    photographs: str | Path,
    config: str | Path,
    quick: bool,
    peers: Path | None = None,
    workers: int | None = None,
) -> tuple[list[PhotographFolder], dict[tuple[str, str], list[Seen]], dict[str, Any]]:
    """The folders, what was seen by (folder, detector), and the rows of the results. `quick`: every QUICK_STEP-th
    photograph; `peers`: what tools/make_peers.sh made, None: without them. Raises ParameterError, PeerError."""
    folders, parameters = load_folders(photographs), read_parameters(config)
    make_detector(SEATER, folders[0], folders[0].photographs[0], parameters)  # wrong parameters: now
    jobs = [
        PhotographJob(folder, index, name, parameters, peers)
        for folder in folders
        for name in detectors_of(folder, peers)
        for index in range(0, len(folder.photographs), QUICK_STEP if quick else 1)
    ]
    seen: dict[tuple[str, str], list[Seen]] = {}
    used: dict[tuple[str, str], list[Photograph]] = {}
    for job, result in zip(jobs, run_jobs(look, jobs, label="perception_photographs", workers=workers), strict=True):
        key = job.folder.name, job.detector
        seen.setdefault(key, []).append(result)
        used.setdefault(key, []).append(job.folder.photographs[job.index])
    rows = [
        row
        for folder in folders
        for row in folder_rows(
            folder, {name: (used[folder.name, name], seen[folder.name, name]) for name in detectors_of(folder, peers)}
        )
    ]
    return folders, seen, {"quick": quick, "photographs": str(photographs), "rows": rows}


def detectors_of(folder: PhotographFolder, peers: Path | None) -> tuple[str, ...]:
    """Those that know the folder's dictionary; ours first."""
    return (*DETECTORS, *peers_for(folder.dictionary, peers))
