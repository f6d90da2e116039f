"""Planar poses.

A pose is an array (x [m], y [m], heading [rad]). `T_a_b` is the pose of b in a: it takes coordinates in b to
coordinates in a. Headings are wrapped to [-pi, pi] by `wrap_angle` (one) and `wrap_angles` (arrays) and nowhere else in
Python.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def wrap_angle(angle: float) -> float:
    """The same direction in [-pi, pi] [rad]; NaN stays NaN."""
    return math.remainder(angle, 2.0 * math.pi) if math.isfinite(angle) else math.nan


def wrap_angles(angles: ArrayLike) -> Array:
    """The same directions in [-pi, pi) [rad], for arrays of any shape."""
    return np.asarray(np.remainder(np.asarray(angles, dtype=float) + math.pi, 2.0 * math.pi) - math.pi)


def compose(T_a_b: ArrayLike, T_b_c: ArrayLike) -> Array:
    """T_a_c, shape (3,)."""
    x, y, heading = np.asarray(T_a_b, dtype=float).tolist()
    bx, by, b_heading = np.asarray(T_b_c, dtype=float).tolist()
    c, s = math.cos(heading), math.sin(heading)
    return np.array([x + c * bx - s * by, y + s * bx + c * by, wrap_angle(heading + b_heading)])


def inverse(T_a_b: ArrayLike) -> Array:
    """T_b_a, shape (3,)."""
    x, y, heading = np.asarray(T_a_b, dtype=float).tolist()
    c, s = math.cos(heading), math.sin(heading)
    return np.array([-c * x - s * y, s * x - c * y, wrap_angle(-heading)])


def relative(T_a_b: ArrayLike, T_a_c: ArrayLike) -> Array:
    """T_b_c, shape (3,): c as seen from b, both given in a."""
    x, y, heading = np.asarray(T_a_b, dtype=float).tolist()
    cx, cy, c_heading = np.asarray(T_a_c, dtype=float).tolist()  # compose(inverse(...)) takes twice as long
    c, s, dx, dy = math.cos(heading), math.sin(heading), cx - x, cy - y
    return np.array([c * dx + s * dy, c * dy - s * dx, wrap_angle(c_heading - heading)])


def transform_points(T_a_b: ArrayLike, points_b: ArrayLike) -> Array:
    """Points of shape (n, 2), given in b, in a."""
    x, y, heading = np.asarray(T_a_b, dtype=float).tolist()
    c, s = math.cos(heading), math.sin(heading)
    rotation = np.array([[c, -s], [s, c]])
    return np.asarray(points_b, dtype=float) @ rotation.T + np.array([x, y])


def arc_step(pose: ArrayLike, v: float, omega: float, duration: float) -> Array:
    """Pose after driving with constant v [m/s] and omega [rad/s] for duration [s], exactly: an arc of a circle."""
    x, y, heading = np.asarray(pose, dtype=float).tolist()
    half = 0.5 * omega * duration
    chord = v * duration * (math.sin(half) / half if half != 0.0 else 1.0)
    direction = heading + half
    return np.array(
        [x + chord * math.cos(direction), y + chord * math.sin(direction), wrap_angle(heading + 2.0 * half)]
    )


def arc_length(x: float, y: float, turn: float) -> float:
    """Way [m] along the arc of a circle from the origin, heading along x, to (x, y), turning by `turn` [rad] on it;
    negative where x is."""
    half = 0.5 * turn
    return math.copysign(math.hypot(x, y), x) * (half / math.sin(half) if half != 0.0 else 1.0)


def arc_poses(pose: ArrayLike, v: float, omega: float, durations: Array) -> Array:
    """arc_step for each of the durations (n,), (n, 3)."""
    x, y, heading = np.asarray(pose, dtype=float)
    half = 0.5 * omega * durations
    chord, direction = v * durations * np.sinc(half / math.pi), heading + half
    return np.column_stack(
        [x + chord * np.cos(direction), y + chord * np.sin(direction), wrap_angles(heading + 2.0 * half)]
    )
