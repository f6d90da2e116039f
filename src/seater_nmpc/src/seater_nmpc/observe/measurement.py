"""From a dock pose in the camera's optical frame to a planar measurement of the dock in odom, with its covariance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import planar_pose
from seater_common.se2 import compose, relative, wrap_angle

Array = NDArray[np.float64]

_FARTHEST, _LARGEST = 1e4, 1e9  # entries of a pose [m] and a covariance beyond which sums of squares may overflow


@dataclass(frozen=True)
class Hypothesis:
    """One possible pose of the dock, from one image (seater_msgs/DockObservation)."""

    T_optical_dock: Array  # 4x4
    covariance: Array  # 6x6: x, y, z [m], rotation about x, y, z of the optical frame [rad]
    weight: float = 1.0  # probability among those of the same image


@dataclass(frozen=True)
class MarkerSight:
    """One marker in one image (seater_msgs/MarkerDetection)."""

    number: int  # its id
    T_optical_marker: Array  # 4x4

    @property
    def finite(self) -> bool:
        """Whether its pose is."""
        return bool(np.all(np.isfinite(self.T_optical_marker)))


@dataclass(frozen=True)
class Measurement:
    """The dock in some planar frame: (x, y, heading) and its covariance (3, 3)."""

    pose: Array
    covariance: Array
    weight: float = 1.0


@dataclass(frozen=True)
class Planar:
    """A hypothesis laid on the floor: the dock in base_link, and what a dock on the floor cannot have."""

    measurement: Measurement
    tilt: float  # angle between the dock's z axis and the vertical [rad]
    height: float  # of the dock's origin above the floor [m]


def project(T_base_optical: Array, hypothesis: Hypothesis) -> Planar | None:
    """The hypothesis in base_link's plane; None when it is not finite, absurdly large, or its covariance is not
    positive."""
    T, P = np.asarray(hypothesis.T_optical_dock, float), np.asarray(hypothesis.covariance, float)
    if not (np.all(np.abs(T) <= _FARTHEST) and np.all(np.abs(P) <= _LARGEST) and math.isfinite(hypothesis.weight)):
        return None
    T_base_dock = T_base_optical @ T
    rotation = np.zeros((6, 6))
    rotation[:3, :3] = rotation[3:, 3:] = T_base_optical[:3, :3]
    planar = (rotation @ P @ rotation.T)[np.ix_([0, 1, 5], [0, 1, 5])]
    planar = 0.5 * (planar + planar.T)
    if np.min(np.linalg.eigvalsh(planar)) <= 0.0 or hypothesis.weight <= 0.0:
        return None
    tilt = math.acos(min(1.0, max(-1.0, float(T_base_dock[2, 2]))))
    measurement = Measurement(planar_pose(T_base_dock), planar, hypothesis.weight)
    return Planar(measurement, tilt, float(T_base_dock[2, 3]))


def in_frame(T_odom_base: ArrayLike, measurement: Measurement) -> Measurement:
    """A measurement given in base_link, in odom."""
    pose = compose(T_odom_base, measurement.pose)
    c, s = math.cos(float(np.asarray(T_odom_base)[2])), math.sin(float(np.asarray(T_odom_base)[2]))
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return Measurement(pose, turn @ measurement.covariance @ turn.T, measurement.weight)


def difference(a: ArrayLike, b: ArrayLike) -> Array:
    """a - b of two poses in one frame, the heading wrapped."""
    result = np.asarray(a, float) - np.asarray(b, float)
    result[2] = wrap_angle(float(result[2]))
    return result


def distance(a: ArrayLike, b: ArrayLike, covariance: Array) -> float:
    """Squared Mahalanobis distance."""
    residual = difference(a, b)
    return float(residual @ np.linalg.solve(covariance, residual))


def between(a: Measurement, b: Measurement) -> float:
    """Squared Mahalanobis distance of two independent measurements."""
    return distance(a.pose, b.pose, a.covariance + b.covariance)


def sd_of_place(covariance: Array, far: float) -> float:
    """Standard deviation [m] of the way of `apart`, for a dock `far` [m] from the chair whose pose has this covariance
    (3, 3): its heading, too, swings it about the chair."""
    return math.hypot(math.sqrt(float(np.linalg.eigvalsh(covariance[:2, :2])[-1])), far * math.sqrt(covariance[2, 2]))


def combine(measurements: list[Measurement]) -> Measurement:
    """The mean weighted by information, with the covariance that independent measurements give."""
    reference, information, vector = measurements[0].pose, np.zeros((3, 3)), np.zeros(3)
    for measurement in measurements:
        weight = np.linalg.inv(measurement.covariance)
        information += weight
        vector += weight @ difference(measurement.pose, reference)
    covariance = np.linalg.inv(information)
    mean = reference + covariance @ vector
    return Measurement(np.array([mean[0], mean[1], wrap_angle(float(mean[2]))]), 0.5 * (covariance + covariance.T))


def apart(T_odom_base: ArrayLike, before: ArrayLike, now: ArrayLike) -> tuple[float, float]:
    """(way [m], turn [rad]) between two poses of the dock in odom, as odometry would have to have drifted.

    A heading of the odometry that is off turns the dock about the chair, so that much of its shift is no way.
    """
    here, there = relative(T_odom_base, before), relative(T_odom_base, now)
    turn = wrap_angle(float(there[2] - here[2]))
    turned = compose([0.0, 0.0, turn], here)
    return math.dist(turned[:2], there[:2]), turn


_MIRRORED = 0.15  # [rad] that two poses of one marker may be off from mirroring each other
_SAME_PLACE = 0.1  # [m] that its place may differ between them


def mirrors(eye: ArrayLike, front: ArrayLike, one: ArrayLike, other: ArrayLike) -> bool:
    """Whether two poses of the dock (3,) are the two that one view of its markers leaves open: the markers stay where
    they are, and the direction in which they face is mirrored about the line of sight.

    Args:
        eye: place (2,) from which they are seen, in the frame of the poses.
        front: (x, y, direction) of the markers' middle in the dock's frame.
    """
    a, b = compose(one, front), compose(other, front)
    if math.dist(a[:2], b[:2]) > _SAME_PLACE:
        return False
    x, y = 0.5 * (a[:2] + b[:2]) - np.asarray(eye, float)[:2]
    sight = math.atan2(-y, -x)
    return abs(wrap_angle(float(a[2] - sight)) + wrap_angle(float(b[2] - sight))) <= _MIRRORED
