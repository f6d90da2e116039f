"""A recorded drive: what was commanded, what the wheels measured, what the camera saw of the dock."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import wrap_angle

Array = NDArray[np.float64]

FINEST = 0.02  # [s] odometry that comes faster is thinned out: encoder ticks would fill the increments with noise
STANDING = 0.5  # [s] before the first command, for a gyro's bias
FEWEST = 20  # messages of each kind without which nothing can be said


class RecordingError(ValueError):
    """The recording holds too little, or what it holds is no drive."""


@dataclass(frozen=True)
class Recording:
    """Times are stamps of one clock [s]; rows are sorted by time and finite, whatever came in.

    commands: (n, 3) time sent, v [m/s], omega [rad/s]; each holds until the next
    odometry: (m, 4) stamp, x, y [m], heading [rad] of base_link in odom
    dock: (k, 4) stamp of the image, x, y [m], heading [rad] of the dock in base_link; may be empty
    dock_covariance: (k, 3, 3) of (x, y, heading)

    Raises RecordingError when commands or odometry are too few, or do not overlap in time.
    """

    commands: Array
    odometry: Array
    dock: Array = field(default_factory=lambda: np.zeros((0, 4)))
    dock_covariance: Array = field(default_factory=lambda: np.zeros((0, 3, 3)))

    def __post_init__(self) -> None:
        commands, _ = _tidied(self.commands, 3)
        odometry, _ = _tidied(self.odometry, 4)
        dock, kept = _tidied(self.dock, 4)
        for name, rows in (("commands", commands), ("odometry", odometry)):
            if len(rows) < FEWEST:
                raise RecordingError(f"{name}: {len(rows)} usable messages, at least {FEWEST} are needed")
        if commands[-1, 0] < odometry[0, 0] or commands[0, 0] > odometry[-1, 0]:
            raise RecordingError("commands and odometry do not overlap in time: are their stamps of one clock?")
        covariance = np.asarray(self.dock_covariance, dtype=float).reshape(-1, 3, 3)[kept]
        for name, value in (("commands", commands), ("odometry", odometry), ("dock", dock)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "dock_covariance", covariance)

    @property
    def duration(self) -> float:
        """[s] of odometry."""
        return float(self.odometry[-1, 0] - self.odometry[0, 0])


@dataclass(frozen=True)
class Increments:
    """What the odometry measured between two of its stamps. All of shape (n,)."""

    begin: Array  # [s]
    end: Array  # [s]
    way: Array  # [m] along the mean heading; negative: backward
    turn: Array  # [rad]
    heading: Array  # [rad] in odom, of the middle

    @property
    def duration(self) -> Array:
        """[s]."""
        return self.end - self.begin


def increments(recording: Recording) -> Increments:
    """Of the poses, not of the twists: drivers filter twists, or leave them at zero.

    A turn while the chair stood before its first command is a gyro's bias, which is taken out of all turns.
    """
    rows = _thinned(recording.odometry)
    step = np.diff(rows, axis=0)
    turn = np.array([wrap_angle(float(angle)) for angle in step[:, 3]])
    direction = rows[:-1, 3] + 0.5 * turn
    way = step[:, 1] * np.cos(direction) + step[:, 2] * np.sin(direction)
    turn -= _bias(recording, rows[1:, 0], turn) * np.diff(rows[:, 0])
    return Increments(rows[:-1, 0], rows[1:, 0], way, turn, direction)


def _bias(recording: Recording, end: Array, turn: Array) -> float:
    """[rad/s] turning rate of the standing chair; 0 when it did not stand for STANDING."""
    moving = np.flatnonzero(np.any(recording.commands[:, 1:] != 0.0, axis=1))
    first = recording.commands[moving[0], 0] if len(moving) else recording.commands[-1, 0]
    begin = max(recording.commands[0, 0] + STANDING, recording.odometry[0, 0])  # what was commanded before has ended
    inside = (end > begin) & (end <= first)
    if first - begin < STANDING or not np.any(inside):
        return 0.0
    return float(np.sum(turn[inside]) / (end[inside][-1] - begin))


def _tidied(rows: Array, columns: int) -> tuple[Array, NDArray[np.intp]]:
    """Finite rows in the order of their time, one for each time; and which they were."""
    rows = np.asarray(rows, dtype=float).reshape(-1, columns)
    finite = np.flatnonzero(np.all(np.isfinite(rows), axis=1))
    order = finite[np.argsort(rows[finite, 0], kind="stable")]
    last = np.append(np.diff(rows[order, 0]) > 0.0, True) if len(order) else np.zeros(0, dtype=bool)
    return rows[order[last]], order[last]


def _thinned(odometry: Array) -> Array:
    """Rows at least (about) FINEST apart."""
    kept, last = [], -np.inf
    for index, stamp in enumerate(odometry[:, 0]):
        if stamp - last >= 0.9 * FINEST:
            kept.append(index)
            last = stamp
    return odometry[kept]
