"""A marker across the edge of a shadow: whether it is found and how exact its pose is, beside OpenCV's detector."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from seater_eval.perception import subject
from seater_eval.perception.images.degraded_camera import DegradedCamera, load_degraded_camera
from seater_eval.perception.images.render import Image, Print, clean_image, corners_of, exposed
from seater_eval.perception.images.scenes import normalised_error_squared, pose_error, upright
from seater_eval.perception.peers import make_peer
from seater_eval.report.bars import Bar
from seater_eval.report.evaluation_style import figure, save
from seater_eval.report.statistics import spread
from seater_eval.report.tables import text_table
from seater_eval.run.parallel import job_seed, run_jobs

SIZE, ANGLE = 0.10, math.radians(15.0)  # [m], [rad]
EDGE_SD = 1.5  # [px] of the shadow's edge
CASES = ((0.35, 0.4), (0.6, 0.6), (0.6, 0.4), (0.6, 0.2), (1.25, 0.5), (2.0, 0.5))  # distance [m], light in the shadow
QUICK_CASES = ((0.6, 0.6), (1.25, 0.5))
WEAK = 0.5  # from this light in the shadow on, the bar holds
FOUND = 0.9


@dataclass(frozen=True)
class ShadowJob:
    """Images with one distance [m] and one light in the shadow, 0 .. 1."""

    config: str
    distance: float
    light: float
    images: int


def shaded(
    clean: NDArray[np.float32], print_: Print, camera: DegradedCamera, light: float, random: np.random.Generator
) -> NDArray[np.float32]:
    """A noise-free image with a shadow whose edge goes through the print's middle in any direction."""
    middle, angle = corners_of(print_, camera.K).mean(axis=0), random.uniform(0.0, 2.0 * math.pi)
    rows, columns = np.indices(clean.shape, dtype=np.float32)
    deep = (columns - middle[0]) * math.cos(angle) + (rows - middle[1]) * math.sin(angle)
    return np.asarray(clean * (1.0 - (1.0 - light) * ndtr(deep / EDGE_SD)), dtype=np.float32)


def shadow_image(job: ShadowJob, index: int) -> tuple[Image, NDArray[np.float64]]:
    """Image number `index` of a job, and T_optical_marker (4, 4)."""
    camera = load_degraded_camera(f"{job.config}/cameras/degraded.yaml")
    random = np.random.default_rng(job_seed(55, index))
    pose = upright(job.distance, ANGLE, random)
    print_ = Print(subject.DICTIONARY, 0, SIZE, pose)
    clean = shaded(clean_image([print_], camera), print_, camera, job.light, random)
    return exposed(clean, camera.noise_sd, random), pose


def run_case(job: ShadowJob) -> dict[str, Any]:
    """Found by both, errors and normalised errors of ours."""
    camera = load_degraded_camera(f"{job.config}/cameras/degraded.yaml")
    detector = subject.make_detector(camera, SIZE, subject.perception_parameters(job.config), prior=True)
    peer = make_peer("opencv_default", camera.K, SIZE)
    errors, normalised, by_peer = [], [], 0
    for index in range(job.images):
        image, pose = shadow_image(job, index)
        by_peer += any(seen.id == 0 for seen in peer(image))
        for marker in [m for m in detector.detect(image).markers if m.id == 0]:
            error = pose_error(marker.hypotheses[0].pose, pose)
            errors.append(1e3 * float(np.linalg.norm(error[:3])))
            normalised.append(normalised_error_squared(error, marker.covariance))
    return {
        "distance": job.distance,
        "light": job.light,
        "images": job.images,
        "found": len(errors),
        "found_opencv_default": by_peer,
        "position_mm": spread(errors),
        "normalised_error_squared": float(np.mean(normalised)) if normalised else None,
    }


def run_shadows(config: str | Path, quick: bool) -> dict[str, Any]:
    """All cases. Raises ParameterError."""
    camera = load_degraded_camera(Path(config) / "cameras" / "degraded.yaml")
    subject.make_detector(camera, SIZE, subject.perception_parameters(config), prior=True)  # wrong parameters: now
    jobs = [ShadowJob(str(config), *case, 12 if quick else 24) for case in (QUICK_CASES if quick else CASES)]
    return {"quick": quick, "rows": run_jobs(run_case, jobs, label="perception_shadows")}


def shadow_bars(data: dict[str, Any]) -> list[Bar]:
    """No fewer found than 90 % and than by OpenCV, and errors that the covariance covers, in shadows with half the
    light."""
    rows = [row for row in data["rows"] if row["light"] >= WEAK]
    fraction = min((row["found"] / row["images"] for row in rows), default=None)
    fewer = max((row["found_opencv_default"] - row["found"] for row in data["rows"]), default=None)
    normalised = [row["normalised_error_squared"] for row in rows]
    worst = None if None in normalised else max(normalised, default=None)
    return [
        Bar("fraction found, half the light or more in the shadow", fraction, FOUND, "", "at least"),
        Bar("images that OpenCV default finds more, worst case", fewer, 0.0),
        Bar("mean normalised error squared, half the light or more", worst, 6.0),
    ]


def describe_shadows(data: dict[str, Any]) -> str:
    """One line for each case."""
    rows = []
    for row in data["rows"]:
        errors = [row["position_mm"]["median"], row["position_mm"]["max"], row["normalised_error_squared"]]
        shown = ["-" if e is None else f"{e:.3g}" for e in errors]
        found = [f"{row[key]}/{row['images']}" for key in ("found", "found_opencv_default")]
        rows.append([f"{row['distance']:.2f} m, light {row['light']:.0%}", *found, *shown])
    return text_table(["case", "found", "OpenCV default", "median mm", "max mm", "NEES"], rows)


def draw_shadows(config: str | Path, data: dict[str, Any], path: Path) -> Path:
    """One image of each case, the part round the marker."""
    fig, axes = figure(len(data["rows"]), width=2.6, height=3.3)
    camera = load_degraded_camera(Path(config) / "cameras" / "degraded.yaml")
    for axis, row in zip(np.atleast_1d(axes), data["rows"], strict=True):
        image, pose = shadow_image(ShadowJob(str(config), row["distance"], row["light"], 1), 0)
        u, v = corners_of(Print(subject.DICTIONARY, 0, SIZE, pose), camera.K).mean(axis=0)
        half = 0.9 * camera.focal_length * SIZE / row["distance"]
        axis.imshow(image, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
        axis.set(xlim=(u - half, u + half), ylim=(v + half, v - half), xticks=[], yticks=[])
        axis.set_title(
            f"{row['distance']:g} m, light {row['light']:.0%}\nfound {row['found']} of {row['images']}", fontsize=9
        )
    return save(fig, path)
