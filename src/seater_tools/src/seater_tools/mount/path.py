"""The odometry with its errors taken out, at the images' times."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import wrap_angles
from seater_tools.drive.drive import Drive

Array = NDArray[np.float64]


class Path:
    """Odometry measures way' = (1 + scale) way and turn' = (1 + heading scale) turn + drift way (the model of the
    docking observer). Beyond it, the chair moves ahead by (way per turn) turn, as wheels of different sizes do on the
    spot, and to the left by (side creep) |way|, as on a slope across. Images are `delay` later than their stamps.
    """

    def __init__(self, drive: Drive) -> None:
        rows = drive.odometry
        step = np.diff(rows, axis=0)
        turn = np.asarray(wrap_angles(step[:, 3]))
        middle = rows[:-1, 3] + 0.5 * turn
        self._times = rows[:, 0]
        self._way = step[:, 1] * np.cos(middle) + step[:, 2] * np.sin(middle)
        self._turn = turn
        self._stamps = drive.stamps
        # Of way and turn without sign, between the images: what their noise grows with.
        done = np.concatenate([np.zeros((1, 2)), np.cumsum(np.abs(np.column_stack([self._way, turn])), axis=0)])
        self.effort = np.diff(self._at(done, drive.stamps), axis=0)

    def _at(self, rows: Array, times: Array) -> Array:
        return np.column_stack([np.interp(times, self._times, column) for column in rows.T])

    def poses(self, errors: Array) -> Array:
        """(images, 3) in a frame that begins at the first odometry; `errors` (6,) as in layout.ODOMETRY."""
        scale, heading_scale, drift, way_per_turn, creep, delay = errors
        turn = (self._turn - drift * self._way) / (1.0 + heading_scale)
        rolled = self._way / (1.0 + scale)
        way, side = rolled + way_per_turn * turn, creep * np.abs(rolled)
        heading = np.concatenate([[0.0], np.cumsum(turn)])
        c, s = np.cos(heading[:-1] + 0.5 * turn), np.sin(heading[:-1] + 0.5 * turn)
        x = np.concatenate([[0.0], np.cumsum(way * c - side * s)])
        y = np.concatenate([[0.0], np.cumsum(way * s + side * c)])
        return self._at(np.column_stack([x, y, heading]), self._stamps + delay)


def steps(poses: Array) -> Array:
    """(n - 1, 3): each pose as seen from the one before, (n, 3); headings are not wrapped."""
    move, heading = np.diff(poses[:, :2], axis=0), poses[:-1, 2]
    c, s = np.cos(heading), np.sin(heading)
    return np.column_stack([c * move[:, 0] + s * move[:, 1], -s * move[:, 0] + c * move[:, 1], np.diff(poses[:, 2])])
