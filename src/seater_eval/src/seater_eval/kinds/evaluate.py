"""Drawn images of each kind of camera through perception as shipped, OpenCV's detector, and others."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import seater_perception as sp
from seater_common.params import ParameterError
from seater_eval.kinds.cameras import KINDS, OPTICS, photograph
from seater_eval.peers.process import peer_process, peers_for
from seater_eval.perception.images.render import Print, corners_of
from seater_eval.perception.images.scenes import normal_error, normalised_error_squared, pose_error
from seater_eval.perception.peers import make_peer
from seater_eval.run.parallel import job_seed, run_jobs

Array = NDArray[np.float64]
Finds = list[tuple[int, Array]]  # id, corners (4, 2) [px]

SEATER, OPENCV = "seater", "opencv_default"
DICTIONARIES = ("DICT_4X4_50", "DICT_6X6_250", "DICT_APRILTAG_36h11")
SIDES = (18.0, 22.0, 27.0, 33.0, 40.0, 49.0, 60.0)  # [px]
SHIFTS = (0.0, 0.1, 0.2, 0.3)  # [px]
SIZE = 0.1  # [m]
COLUMNS, ROWS = (90.0, 243.0, 396.0, 549.0), (80.0, 240.0, 400.0)  # [px] where markers are, about
TILT = (math.radians(8.0), math.radians(45.0))  # of a print, from the line of sight
TURN = 0.3  # [rad] at most, in its plane
SAME_PLACE = 0.35  # [sides] of a find from the marker's middle
WRONG_BRANCH = math.radians(15.0)
CERTAIN = 0.05  # ambiguity


@dataclass(frozen=True)
class KindJob:
    """One image. `peers`: folder that tools/make_peers.sh made."""

    kind: str
    shift: float
    dictionary: str
    side: float
    seed: int
    parameters: dict[str, Any]
    peers: Path | None = None


@dataclass(frozen=True)
class Look:
    """What came of one image: markers found and false finds by each detector; of ours, normalised squared errors of the
    poses (6 degrees of freedom), how many were called certain, and how many of these have the wrong branch."""

    found: dict[str, int]
    false: dict[str, int]
    errors: list[float]
    certain: int
    wrong: int


def scene(job: KindJob) -> tuple[list[Print], np.random.Generator]:
    """Twelve prints, and the generator for the image."""
    random = np.random.default_rng(job.seed)
    ids = random.choice(50, len(COLUMNS) * len(ROWS), replace=False)
    places = [(u, v) for v in ROWS for u in COLUMNS]
    prints = [
        Print(job.dictionary, int(i), SIZE, _pose(u, v, job.side, random))
        for i, (u, v) in zip(ids, places, strict=True)
    ]
    return prints, random


def _pose(u: float, v: float, side: float, random: np.random.Generator) -> Array:
    """T_optical_marker (4, 4) of a print that is about `side` px wide near the pixel (u, v)."""
    pixel = np.array([*(np.array([u, v]) + random.uniform(-8.0, 8.0, 2)), 1.0])
    ray = np.linalg.inv(OPTICS.K) @ pixel
    sight = ray / np.linalg.norm(ray)
    across = np.cross([0.0, 1.0, 0.0], sight)
    across /= np.linalg.norm(across)
    facing = np.column_stack([across, np.cross(sight, across), sight]) @ np.diag([1.0, -1.0, -1.0])
    azimuth, tilt, turn = random.uniform(0.0, 2.0 * math.pi), random.uniform(*TILT), random.uniform(-TURN, TURN)
    axis = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
    T = np.eye(4)
    T[:3, :3] = facing @ cv2.Rodrigues(tilt * axis)[0] @ cv2.Rodrigues(np.array([0.0, 0.0, turn]))[0]
    T[:3, 3] = ray * OPTICS.focal_length * SIZE / (side * random.uniform(0.85, 1.15))
    return T


def look(job: KindJob) -> Look:
    """One image, drawn and looked at."""
    prints, random = scene(job)
    image = photograph(prints, job.kind, job.shift, random)
    markers = _detector(job).detect(image).markers
    finds: dict[str, Finds] = {
        SEATER: [(m.id, np.asarray(m.corners)) for m in markers],
        OPENCV: [(seen.id, seen.corners) for seen in make_peer(OPENCV, OPTICS.K, SIZE, job.dictionary)(image)],
    }
    for name in peers_for(job.dictionary, job.peers):
        assert job.peers is not None  # peers_for has none then
        finds[name] = peer_process(job.peers, name, job.dictionary).look(image).found
    right = {name: _right(prints, found) for name, found in finds.items()}
    poses = {p.id: p.pose for p in prints}
    mine = [m for k, m in enumerate(markers) if k in right[SEATER]]
    certain = [m for m in mine if m.ambiguity < CERTAIN]
    return Look(
        found={name: len(those) for name, those in right.items()},
        false={name: len(finds[name]) - len(those) for name, those in right.items()},
        errors=[
            normalised_error_squared(pose_error(m.hypotheses[0].pose, poses[m.id]), np.asarray(m.covariance))
            for m in mine
        ],
        certain=len(certain),
        wrong=sum(normal_error(m.hypotheses[0].pose, poses[m.id]) > WRONG_BRANCH for m in certain),
    )


def _detector(job: KindJob) -> Any:
    K = OPTICS.K.ravel().tolist()
    camera = sp.CameraModel.raw(sp.Calibration(OPTICS.image_width, OPTICS.image_height, K, [0.0] * 5))
    return sp.DockDetector(camera, sp.layout_of_equal_markers(job.dictionary, SIZE), job.parameters)


def _right(prints: list[Print], found: Finds) -> list[int]:
    """Indices of finds of a marker at its place, the first of each."""
    middles = {p.id: corners_of(p, OPTICS.K) for p in prints}
    right: dict[int, int] = {}
    for k, (i, corners) in enumerate(found):
        if i not in middles or i in right:
            continue
        side = float(np.linalg.norm(middles[i] - np.roll(middles[i], 1, axis=0), axis=1).mean())
        if float(np.linalg.norm(corners.mean(axis=0) - middles[i].mean(axis=0))) <= SAME_PLACE * side:
            right[i] = k
    return sorted(right.values())


def run_kinds(
    parameters: dict[str, Any], images: int, seed: int, peers: Path | None = None, workers: int | None = None
) -> dict[str, Any]:
    """Rows by kind and shift; `images`: of each kind, shift, dictionary and side. Raises ParameterError, PeerError."""
    jobs = [
        KindJob(kind, shift, dictionary, side, 0, parameters, peers)
        for kind in KINDS
        for shift in SHIFTS
        for dictionary in DICTIONARIES
        for side in SIDES
        for _ in range(images)
    ]
    jobs = [KindJob(**{**vars(job), "seed": job_seed(seed, k)}) for k, job in enumerate(jobs)]
    try:
        _detector(jobs[0])  # wrong parameters: now
    except sp.ConfigurationError as error:
        raise ParameterError(str(error)) from error
    looks = run_jobs(look, jobs, label="perception_kinds", workers=workers)
    cells: dict[tuple[str, float], list[tuple[KindJob, Look]]] = {}
    for job, seen in zip(jobs, looks, strict=True):
        cells.setdefault((job.kind, job.shift), []).append((job, seen))
    return {"images": images, "seed": seed, "rows": [_row(*key, seen) for key, seen in cells.items()]}


def _row(kind: str, shift: float, seen: list[tuple[KindJob, Look]]) -> dict[str, Any]:
    errors = np.concatenate([one.errors for _, one in seen])
    names = list(dict.fromkeys(name for _, one in seen for name in one.found))
    by_detector = {}
    for name in names:  # a peer that does not know a dictionary is compared on the others
        mine = [one for _, one in seen if name in one.found]
        by_detector[name] = {
            "markers": len(mine) * len(COLUMNS) * len(ROWS),
            "found": sum(one.found[name] for one in mine),
            "found_by_seater": sum(one.found[SEATER] for one in mine),
            "false": sum(one.false[name] for one in mine),
        }
    return {
        "kind": kind,
        "shift_px": shift,
        "detectors": by_detector,
        "normalised_error_squared": float(errors.mean()) if len(errors) else None,
        "certain": sum(one.certain for _, one in seen),
        "wrong_and_certain": sum(one.wrong for _, one in seen),
    }
