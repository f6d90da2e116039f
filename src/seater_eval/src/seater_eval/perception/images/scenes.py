"""Where prints are seen from, and how far an estimate is from the truth."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
WRONG_BRANCH = math.radians(10.0)  # a normal that is farther off is the other solution's


def facing(x: float, y: float, z: float, yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0) -> Array:
    """T_optical_marker (4, 4) of a print at (x, y, z) [m] that faces the camera and is then turned about the vertical
    by yaw, about the horizontal by pitch, and in its plane by roll [rad]."""
    T = np.eye(4)
    turns = [(0.0, yaw, 0.0), (pitch, 0.0, 0.0)]
    about_y, about_x = (cv2.Rodrigues(np.array(turn))[0] for turn in turns)
    about_z = cv2.Rodrigues(np.array([0.0, 0.0, roll]))[0]
    T[:3, :3] = about_y @ about_x @ np.diag([1.0, -1.0, -1.0]) @ about_z
    T[:3, 3] = [x, y, z]
    return T


def upright(
    distance: float, yaw: float, random: np.random.Generator, spread: float = 0.25, tilt: float = 0.01
) -> Array:
    """A print on a wall at about this distance along the axis, somewhere in the image (`spread`: of distance, to each
    side), turned by +- yaw, with small errors of mounting and floor (`tilt` [rad] standard deviation of pitch and
    roll)."""
    x, y = random.uniform(-spread, spread) * distance, random.uniform(-0.4 * spread, 0.4 * spread) * distance
    sign = 1.0 if random.random() < 0.5 else -1.0
    pitch, roll = tilt * random.standard_normal(2)
    return facing(x, y, distance * random.uniform(0.99, 1.01), sign * yaw, float(pitch), float(roll))


def pose_error(estimate: Array, truth: Array) -> Array:
    """(6,): d [m], w [rad] with t_true = t + d, R_true = exp([w]x) R."""
    w = cv2.Rodrigues(truth[:3, :3] @ estimate[:3, :3].T)[0].ravel()
    return np.concatenate([truth[:3, 3] - estimate[:3, 3], w])


def normal_error(estimate: Array, truth: Array) -> float:
    """Angle between the prints' normals [rad]."""
    return math.acos(min(1.0, max(-1.0, float(estimate[:3, 2] @ truth[:3, 2]))))


def normalised_error_squared(error: Array, covariance: Array) -> float:
    """e^T C^-1 e; chi-squared with 6 degrees of freedom when the covariance is right."""
    scale = 1.0 / np.sqrt(np.diag(covariance))
    e = scale * error
    return float(e @ np.linalg.solve(covariance * np.outer(scale, scale), e))
