"""One cell of the accuracy table: a marker size, a distance and an angle; all methods on the same images."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

from seater_eval.perception import subject
from seater_eval.perception.images.bound import cramer_rao, unknowns
from seater_eval.perception.images.degraded_camera import load_degraded_camera
from seater_eval.perception.images.render import Print, box_of, clean_image, exposed
from seater_eval.perception.images.scenes import (
    WRONG_BRANCH,
    normal_error,
    normalised_error_squared,
    pose_error,
    upright,
)
from seater_eval.perception.peers import Detector, Seen, best_of_ippe, dictionary_of, make_peer
from seater_eval.report.statistics import spread
from seater_eval.run.parallel import job_seed


@dataclass(frozen=True)
class CellJob:
    """What one cell needs."""

    config: str
    size: float  # [m]
    distance: float  # [m]
    angle: float  # [rad]
    images: int
    slow_images: int  # of them also given to OpenCV's APRILTAG refinement
    methods: tuple[str, ...]
    index: int  # of the cell, for its random numbers
    peers: Path | None = None  # what tools/make_peers.sh made, for methods of seater_eval.peers


@lru_cache(maxsize=64)
def _detector(config: str, method: str, size: float, peers: Path | None = None) -> Any:
    camera = load_degraded_camera(f"{config}/cameras/degraded.yaml")
    if method.startswith("seater"):
        parameters = subject.perception_parameters(config)
        return subject.make_detector(camera, size, parameters, prior=method != "seater without prior")
    return make_peer(method, camera.K, size, dictionary_of(method), peers)


def run_cell(job: CellJob) -> dict[str, Any]:
    """Errors of every method, normalised errors of ours, and the bound."""
    camera = load_degraded_camera(f"{job.config}/cameras/degraded.yaml")
    unknown = unknowns(subject.perception_parameters(job.config))
    errors: dict[str, list[tuple[float, float]]] = {name: [] for name in job.methods}
    shown = dict.fromkeys(job.methods, 0)
    nees, bounds, wrong = [], [], 0
    for k in range(job.images):
        random = np.random.default_rng(job_seed(job.index, k))
        pose = upright(job.distance, job.angle, random)
        clean, exposures = {}, {}
        for dictionary in dict.fromkeys(dictionary_of(name) for name in job.methods):
            clean[dictionary] = clean_image([Print(dictionary, 0, job.size, pose)], camera)
            exposures[dictionary] = exposed(clean[dictionary], camera.noise_sd, random)
        truth = Print(subject.DICTIONARY, 0, job.size, pose)
        if k % 4 == 0:
            bounds.append(bound_entry(cramer_rao(truth, camera, psf=unknown.psf, slope=unknown.slope)))
        for name in job.methods:
            if name == "opencv_apriltag" and k >= job.slow_images:
                continue
            shown[name] += 1
            image = exposures[dictionary_of(name)]
            if name == "seater":
                markers = [m for m in _detector(job.config, name, job.size).detect(image).markers if m.id == 0]
                if markers:
                    estimate = markers[0].hypotheses[0].pose
                    nees.append(normalised_error_squared(pose_error(estimate, pose), markers[0].covariance))
                    wrong += normal_error(estimate, pose) > WRONG_BRANCH
                    errors[name].append(_lengths(estimate, pose))
                continue
            detect: Detector = _detector(job.config, name, job.size, job.peers)
            seen = _cut_detect(detect, image, truth, camera) if name == "opencv_apriltag" else detect(image)
            errors[name] += [_lengths(s.pose, pose) for s in seen if s.id == 0][:1]
    return {
        "size": job.size,
        "distance": job.distance,
        "angle_deg": math.degrees(job.angle),
        "images": job.images,
        "bound_mm": float(np.mean([b[0] for b in bounds])),
        "bound_median_mm": float(np.mean([b[1] for b in bounds])),
        "bound_draws_mm": [float(length) for b in bounds for length in b[3]],
        "bound_deg": float(np.mean([b[2] for b in bounds])),
        "nees": nees_entry(nees),
        "wrong_branch": wrong,
        "methods": {name: _entry(errors[name], shown[name]) for name in job.methods},
    }


def _cut_detect(detect: Detector, image: Any, truth: Print, camera: Any) -> list[Seen]:
    """The part of the image round the marker only, because this method takes up to a second for a whole one."""
    x0, y0, x1, y1 = box_of(truth, camera, 4.0, 40.0)
    x0, y0 = x0 - x0 % 16, y0 - y0 % 16
    K = camera.K.copy()
    K[0, 2] -= x0
    K[1, 2] -= y0
    cut = make_peer("opencv_apriltag", K, truth.size)
    return cut(np.ascontiguousarray(image[y0:y1, x0:x1]))


def bound_entry(C: Any) -> tuple[float, float, float, Any]:
    """Of a bound's covariance: rms position error [mm], median length of the position error [mm] of an estimator that
    reaches it (drawn: the length of an anisotropic normal error has no closed median), rms rotation error [deg], and 40
    equally spaced quantiles of that length [mm], so that bounds of several poses can be pooled."""
    draws = np.random.default_rng(0).multivariate_normal(np.zeros(3), 1e6 * C[:3, :3], 4000, method="cholesky")
    rms = np.sqrt([np.trace(C[:3, :3]), np.trace(C[3:, 3:])])
    lengths = np.linalg.norm(draws, axis=1)
    quantiles = np.quantile(lengths, (np.arange(40) + 0.5) / 40)
    return 1e3 * float(rms[0]), float(np.median(lengths)), math.degrees(float(rms[1])), quantiles


def _lengths(estimate: Any, truth: Any) -> tuple[float, float]:
    """Error of position [m] and of rotation [rad]."""
    error = pose_error(estimate, truth)
    return float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))


def _entry(errors: list[tuple[float, float]], shown: int) -> dict[str, Any]:
    """Medians and percentiles of what was found."""
    position, angle = spread([1e3 * e[0] for e in errors]), spread([math.degrees(e[1]) for e in errors])
    every = [1e3 * e[0] for e in errors]
    return {"found": len(errors), "shown": shown, "position_mm": position, "angle_deg": angle, "every_mm": every}


def nees_entry(nees: list[float]) -> dict[str, Any]:
    """Mean normalised error squared with the bounds that a right covariance keeps in 95 % of such cells: chi-squared
    with 6 n degrees of freedom over n (Bar-Shalom, "Estimation with Applications to Tracking and Navigation",
    5.4.2)."""
    n = len(nees)
    if n == 0:
        return {"count": 0, "mean": None, "low": None, "high": None, "inside": False}
    low, high = (float(chi2.ppf(p, 6 * n)) / n for p in (0.025, 0.975))
    mean = float(np.mean(nees))
    return {"count": n, "mean": mean, "low": low, "high": high, "inside": low <= mean <= high}


def table_bounds(count: int, cells: int) -> tuple[float, float]:
    """Bounds of the mean normalised error of `count` images that a right covariance keeps in all of `cells` independent
    cells with a probability of 95 % (Sidak, "Rectangular confidence regions", 1967)."""
    outside = 0.5 * (1.0 - 0.95 ** (1.0 / cells))
    low, high = (float(chi2.ppf(p, 6 * count)) / count for p in (outside, 1.0 - outside))
    return low, high


@dataclass(frozen=True)
class BranchJob:
    """Frames first .. last - 1 of the wrong-branch test."""

    config: str
    first: int
    last: int


def count_wrong_branches(job: BranchJob) -> dict[str, int]:
    """Frames with the normal more than 10 deg off: ours with and without prior, IPPE alone on OpenCV's corners.

    100 mm, 0.35 to 2 m, every second frame frontal (within 3 deg), the others turned by up to 30 deg.
    """
    camera, size = load_degraded_camera(f"{job.config}/cameras/degraded.yaml"), 0.1
    counts = dict.fromkeys(
        ("frames", "found", "found without prior", "seater", "seater without prior", "ippe", "ippe, default corners"), 0
    )
    for k in range(job.first, job.last):
        random = np.random.default_rng(job_seed(23, k))
        angle = math.radians(random.uniform(0.0, 3.0) if k % 2 == 0 else random.uniform(3.0, 30.0))
        pose = upright(float(random.uniform(0.35, 2.0)), angle, random)
        clean = clean_image([Print(subject.DICTIONARY, 0, size, pose)], camera)
        image = exposed(clean, camera.noise_sd, random)
        counts["frames"] += 1
        for name in ("seater", "seater without prior"):
            for marker in _detector(job.config, name, size).detect(image).markers:
                counts["found" if name == "seater" else "found without prior"] += 1
                counts[name] += normal_error(marker.hypotheses[0].pose, pose) > WRONG_BRANCH
        for name, method in (("ippe", "opencv_scaled"), ("ippe, default corners", "opencv_default")):
            for seen in _detector(job.config, method, size)(image):
                counts[name] += normal_error(best_of_ippe(seen, camera.K, size), pose) > WRONG_BRANCH
    return counts
