"""Scans of outlines by rays, so that a test says what stands where and not what a sensor tells."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.se2 import compose, transform_points
from seater_obstacles.scan import scan_sight
from seater_obstacles.sight import Sight

Array = NDArray[np.float64]

SCANNER = (0.70, 0.0, 0.0)  # in base_link
REACH = 8.0  # [m]


def box(x: float, y: float, length: float = 0.3, width: float = 0.3) -> Array:
    """Anticlockwise corners of a box with this middle."""
    return np.array([x, y]) + 0.5 * np.array([[-length, -width], [length, -width], [length, width], [-length, width]])


def disc(x: float, y: float, radius: float = 0.2) -> Array:
    """A person seen from above."""
    angles = np.linspace(0.0, 2.0 * math.pi, 16, endpoint=False)
    return np.array([x, y]) + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def ranges(pose: ArrayLike, outlines: list[Array], angles: Array) -> Array:
    """(n,) [m] from a scanner at `pose` along each bearing to the first edge; infinite: none within REACH."""
    x, y, heading = pose
    d = np.column_stack([np.cos(angles + heading), np.sin(angles + heading)])
    first = np.full(len(angles), np.inf)
    for outline in outlines:
        for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
            e, s = b - a, a - np.array([x, y])
            det = e[0] * d[:, 1] - e[1] * d[:, 0]
            with np.errstate(divide="ignore", invalid="ignore"):
                t, u = (e[0] * s[1] - e[1] * s[0]) / det, (d[:, 0] * s[1] - d[:, 1] * s[0]) / det
            hit = (t > 0.0) & (u >= 0.0) & (u <= 1.0)
            first = np.where(hit, np.minimum(first, t), first)
    return np.where(first <= REACH, first, np.inf)


def scan(base: ArrayLike, outlines: list[Array], half_angle: float = 2.0) -> Sight:
    """What a scanner at the front sees of outlines in odom, half a degree apart."""
    angles = np.arange(-half_angle, half_angle, math.radians(0.5))
    T = np.eye(4)
    T[:2, 3] = SCANNER[:2]
    r = ranges(compose(base, SCANNER), outlines, angles)
    return scan_sight(r, angles[0], math.radians(0.5), (0.05, REACH), T, 4.0)


def covers(outlines: list[Array], points: ArrayLike) -> bool:
    """Whether each of the points (n, 2) lies in one of the convex outlines, or within a millimetre of it."""

    def inside(outline: Array, p: Array) -> bool:
        e, f = np.roll(outline, -1, axis=0) - outline, p - outline
        return bool(np.all(e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0] >= -1e-3 * np.hypot(e[:, 0], e[:, 1])))

    return all(any(inside(o, p) for o in outlines) for p in np.asarray(points, dtype=float).reshape(-1, 2))


def placed(pose: ArrayLike, outlines: list[Array]) -> list[Array]:
    """Outlines in the frame that `pose` is given in."""
    return [transform_points(pose, outline) for outline in outlines]
