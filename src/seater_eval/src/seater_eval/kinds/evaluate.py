"""Drawn images of each kind of camera through perception as shipped, OpenCV's detector, and others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_eval.kinds.cameras import KINDS, OPTICS, Grey, behind_lens, delivered, photograph
from seater_eval.peers.process import peers_for
from seater_eval.perception import subject
from seater_eval.perception.images.render import Print, corners_of
from seater_eval.perception.images.scenes import normalised_error_squared, pose_error
from seater_eval.photographs.branches import branch_of, count_broken
from seater_eval.photographs.detectors import CORNERS, OPENCV, SEATER, Image, make_detector
from seater_eval.photographs.measures import match
from seater_eval.photographs.truth import KnownMarker, Photograph, PhotographFolder
from seater_eval.run.long_run import run_long
from seater_eval.run.parallel import job_seed

Array = NDArray[np.float64]

DICTIONARIES = ("DICT_4X4_50", "DICT_6X6_250", "DICT_APRILTAG_36h11")
SIDES = (18.0, 22.0, 27.0, 33.0, 40.0, 49.0, 60.0)  # [px]
SHIFTS = (0.0, 0.1, 0.2, 0.3)  # [px]
SIZE = 1.0  # of a print: poses count in sides, as of photographs
COLUMNS, ROWS = (90.0, 243.0, 396.0, 549.0), (80.0, 240.0, 400.0)  # [px] where markers are, about
TILT = (math.radians(8.0), math.radians(45.0))  # of a print, from the line of sight
TURN = 0.3  # [rad] at most, in its plane


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
class SceneJob:
    """One scene as each kind of camera delivers it, with each shift, for ours alone."""

    dictionary: str
    side: float
    seed: int
    parameters: dict[str, Any]


@dataclass(frozen=True)
class Look:
    """What came of one image: markers found and false finds by each detector; of ours, normalised squared errors of the
    poses (6 degrees of freedom), how many were called certain, how many of these have the wrong branch, and what became
    of those that corners alone decide (count_broken)."""

    found: dict[str, int]
    false: dict[str, int]
    errors: list[float]
    certain: int
    wrong: int
    branches: dict[str, int] = field(default_factory=dict)


def scene(job: KindJob | SceneJob) -> tuple[list[Print], np.random.Generator]:
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
    return _look_at(job, prints, image, (OPENCV, *peers_for(job.dictionary, job.peers)), job.peers)


def look_at_scene(job: SceneJob) -> list[Look]:
    """All images of a scene, drawn and looked at: kind by kind and shift by shift."""
    prints, random = scene(job)
    clean: dict[float | None, Grey] = {}  # drawing takes ten times longer than all that comes after it
    looks = []
    for name, kind in KINDS.items():
        if kind.blur not in clean:
            clean[kind.blur] = behind_lens(prints, kind.blur)
        for shift in SHIFTS:
            looks.append(_look_at(job, prints, delivered(clean[kind.blur], name, shift, random), ()))
    return looks


def _look_at(
    job: KindJob | SceneJob, prints: list[Print], image: Image, others: Sequence[str], peers: Path | None = None
) -> Look:
    """Ours and `others`."""
    known, folder = _known(job, prints)
    finds = {
        name: match(known, make_detector(name, folder, known, job.parameters, peers)(image).found)
        for name in (SEATER, CORNERS, *others)
    }
    poses, errors = {p.id: p.pose for p in prints}, []
    by_corners, shipped = (
        {f.id: branch_of(f, poses[f.id]) for f in finds[name].found.values()} for name in (CORNERS, SEATER)
    )
    for f in finds[SEATER].found.values():
        assert f.pose is not None and f.covariance is not None  # ours have both
        errors.append(normalised_error_squared(pose_error(f.pose, poses[f.id]), f.covariance))
    del finds[CORNERS]  # no detector of its own: its finds are those of ours
    return Look(
        found={name: len(matched.found) for name, matched in finds.items()},
        false={name: len(matched.false) for name, matched in finds.items()},
        errors=errors,
        certain=sum(b.certain for b in shipped.values()),
        wrong=sum(b.wrong_and_certain for b in shipped.values()),
        branches=count_broken(by_corners, shipped),
    )


def _known(job: KindJob | SceneJob, prints: list[Print]) -> tuple[Photograph, PhotographFolder]:
    """The image as one of a folder of photographs, whose markers are known."""
    markers = []
    for p in prints:
        corners = corners_of(p, OPTICS.K)
        side = float(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).mean())
        markers.append(KnownMarker(id=p.id, center=corners.mean(axis=0), side=side))
    width, height = OPTICS.image_width, OPTICS.image_height
    known = Photograph(
        path=Path(job.dictionary), width=width, height=height, K=OPTICS.K, D=np.zeros(5), markers=tuple(markers)
    )
    return known, PhotographFolder(name=job.dictionary, dictionary=job.dictionary, photographs=(known,))


def run_kinds(
    parameters: dict[str, Any],
    images: int,
    seed: int,
    peers: Path | None = None,
    workers: int | None = None,
    *,
    ours_only: bool = False,
    partial: Path | None = None,
) -> dict[str, Any]:
    """Rows by kind and shift; `images`: of each kind, shift, dictionary and side. `ours_only`: nobody beside ours, and
    all kinds and shifts have the same scenes, which takes a tenth of the time; `partial`: see run_long. Raises
    ParameterError, PeerError."""
    cells = [(kind, shift) for kind in KINDS for shift in SHIFTS]
    sizes = [(dictionary, side) for dictionary in DICTIONARIES for side in SIDES for _ in range(images)]
    jobs: list[KindJob | SceneJob]
    if ours_only:
        jobs = [SceneJob(*size, job_seed(seed, k), parameters) for k, size in enumerate(sizes)]
    else:
        images_of = [(*cell, *size) for cell in cells for size in sizes]
        jobs = [KindJob(*image, job_seed(seed, k), parameters, peers) for k, image in enumerate(images_of)]
    known, folder = _known(jobs[0], scene(jobs[0])[0])
    make_detector(SEATER, folder, known, parameters)  # wrong parameters: now
    files = subject.library_files()
    function = look_at_scene if ours_only else look
    seen = run_long(function, jobs, label="perception_kinds", files=files, partial=partial, workers=workers)
    if ours_only:
        seen = [list(looks) for looks in zip(*seen, strict=True)]
    else:
        seen = [seen[k : k + len(sizes)] for k in range(0, len(seen), len(sizes))]
    rows = [_row(*cell, looks) for cell, looks in zip(cells, seen, strict=True)]
    return {"images": images, "seed": seed, "ours_only": ours_only, "rows": rows}


def _row(kind: str, shift: float, seen: list[Look]) -> dict[str, Any]:
    errors = np.concatenate([one.errors for one in seen])
    names = list(dict.fromkeys(name for one in seen for name in one.found))
    by_detector = {}
    for name in names:  # a peer that does not know a dictionary is compared on the others
        mine = [one for one in seen if name in one.found]
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
        "certain": sum(one.certain for one in seen),
        "wrong_and_certain": sum(one.wrong for one in seen),
        "branches": {key: sum(one.branches[key] for one in seen) for key in seen[0].branches},
    }
