"""Which poses of the dock an image offers to the observer, in odom; or why it offers none."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import CameraMount
from seater_nmpc.observe.innovation import Outcome
from seater_nmpc.observe.measurement import Hypothesis, Measurement, Planar, in_frame, project
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import ObserverParameters

Array = NDArray[np.float64]

# [m, -] Entries of a pose nearer to each other than this are the same number: no image has so little noise.
_SAME = 1e-7
_MOVED = (0.005, 0.03)  # [m, rad] after which an image cannot be the same (a gyro's bias turns a standing chair's odom)
_SD_BY_DISTANCE = 0.1  # standard deviation of a position that may be used, per metre of distance
_MAX_SD_HEADING = 0.35  # [rad]


class Offers:
    """Look at each image once, in the order of their arrival."""

    def __init__(self, mount: CameraMount, parameters: ObserverParameters) -> None:
        self._T_base_optical, self._parameters = mount.T_base_optical(), parameters
        self._last: Array | None = None  # poses of the last image, (n, 4, 4)
        self._since: Instant | None = None  # of the first image that showed the same

    def look(self, chair: Instant, hypotheses: list[Hypothesis]) -> list[Measurement] | Outcome:
        """`chair`: when the image was taken. At least one measurement, or FROZEN, INVALID, FLIP or UNCERTAIN."""
        if self._frozen(chair, hypotheses):
            return Outcome.FROZEN
        planar = [p for p in (project(self._T_base_optical, hypothesis) for hypothesis in hypotheses) if p is not None]
        if not planar:
            return Outcome.INVALID
        standing = [p.measurement for p in planar if self._on_the_floor(p)]
        if not standing:
            return Outcome.FLIP
        certain = [measurement for measurement in standing if self._is_certain(measurement)]
        return [in_frame(chair.pose, measurement) for measurement in certain] or Outcome.UNCERTAIN

    def _frozen(self, chair: Instant, hypotheses: list[Hypothesis]) -> bool:
        """Whether the image shows exactly what the last ones did though the wheels have turned since the first."""
        poses = np.array([hypothesis.T_optical_dock for hypothesis in hypotheses], dtype=float)
        same = self._last is not None and poses.shape == self._last.shape and np.abs(poses - self._last).max() <= _SAME
        self._last = poses
        if not same or self._since is None:
            self._since = chair
            return False
        driven, turned = chair.driven - self._since.driven, chair.turned - self._since.turned
        return driven >= _MOVED[0] or turned >= _MOVED[1]

    def _on_the_floor(self, planar: Planar) -> bool:
        return planar.tilt <= self._parameters.max_tilt and abs(planar.height) <= self._parameters.max_height

    def _is_certain(self, measurement: Measurement) -> bool:
        """Whether a chair that is steered by it can be said to see the dock."""
        largest = math.sqrt(float(np.linalg.eigvalsh(measurement.covariance[:2, :2])[-1]))
        bound = self._parameters.max_sd + _SD_BY_DISTANCE * math.hypot(*measurement.pose[:2])
        return largest <= bound and measurement.covariance[2, 2] <= _MAX_SD_HEADING**2
