"""What becomes of odometry on its way: rows (6,) of stamp, x, y [m], heading [rad], v [m/s], omega [rad/s]."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np

X, Y, HEADING = 3.0, -1.5, 0.6  # [m], [rad] in odom, where the simulator's odometry begins (simulator.yaml)


def zero_stamp(row: np.ndarray) -> np.ndarray:
    """A driver that does not fill it in."""
    return np.array([0.0, *row[1:]])


def reversed_way(row: np.ndarray) -> np.ndarray:
    """Way counted backward: encoders of the wrong polarity. Right while the chair has not turned much."""
    c, s = math.cos(HEADING), math.sin(HEADING)
    ahead = (row[1] - X) * c + (row[2] - Y) * s
    return row - 2.0 * ahead * np.array([0.0, c, s, 0.0, 0.0, 0.0])


def turned_about(row: np.ndarray) -> np.ndarray:
    """Turns counted the other way."""
    return np.array([*row[:3], 2.0 * HEADING - row[3], row[4], -row[5]])


def scaled(factor: float) -> Callable[[np.ndarray], np.ndarray]:
    """Ways so many times what they are."""
    origin = np.array([0.0, X, Y, 0.0, 0.0, 0.0])
    return lambda row: origin + (row - origin) * [1.0, factor, factor, 1.0, factor, 1.0]


def frozen(row: np.ndarray) -> np.ndarray:
    """The same pose and no speed, with fresh stamps."""
    return np.array([row[0], X, Y, HEADING, 0.0, 0.0])


def drifting(row: np.ndarray) -> np.ndarray:
    """A gyro with a bias of 0.03 rad/s."""
    return row + 0.03 * row[0] * np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])


def every(n: int) -> Callable[[np.ndarray], np.ndarray | None]:
    """Only one message of n."""
    count = itertools.count()
    return lambda row: row if next(count) % n == 0 else None
