"""A laser scan as a sight."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_obstacles.sight import Sight, View

Array = NDArray[np.float64]

_LEVEL = 0.2  # [rad] that a scanner may be tilted; farther, its rays meet floor or pass over things


class TiltedError(ValueError):
    """The scanner's plane is not level."""


def scan_sight(
    ranges: ArrayLike,
    angle_min: float,
    angle_increment: float,
    limits: tuple[float, float],
    T_base_sensor: ArrayLike,
    max_range: float,
) -> Sight:
    """The sight of one scan, in the convention of sensor_msgs/LaserScan.

    Args:
        ranges: (n,) [m]. NaN and what is below the least range: not measured. Infinite or beyond the largest: nothing.
        angle_min: bearing of the first ray [rad]; `angle_increment` to the next one.
        limits: least and largest range [m].
        T_base_sensor: 4x4 pose of the scanner in base_link, level (also upside down).
        max_range: [m] from base_link within which things count.

    Raises:
        TiltedError: the scanner is tilted by more than 0.2 rad.
        ValueError: angles or limits are none.
    """
    T, r = np.asarray(T_base_sensor, dtype=float), np.asarray(ranges, dtype=float).reshape(-1)
    if abs(T[2, 2]) < np.cos(_LEVEL):
        raise TiltedError("the scanner is tilted by more than 0.2 rad: use its points as a cloud")
    if not (
        np.isfinite(angle_min) and np.isfinite(angle_increment) and angle_increment and 0.0 <= limits[0] < limits[1]
    ):
        raise ValueError(f"the scan's rays begin at {angle_min}, step {angle_increment}, limits {limits}: cannot be")
    angles = angle_min + angle_increment * np.arange(len(r))
    low, high = limits
    measured = ~np.isnan(r) & (r >= low)
    r, angles = r[measured], angles[measured]
    hit = r < high
    directions = np.column_stack([np.cos(angles), np.sin(angles)]) @ T[:2, :2].T
    points = T[:2, 3] + r[hit, None] * directions[hit]
    bearings = np.arctan2(directions[:, 1], directions[:, 0])
    view = View(T[:2, 3], bearings, np.full(len(r), low), np.minimum(r, high), angle_increment)
    return Sight(points[np.hypot(points[:, 0], points[:, 1]) <= max_range], view, len(points))
