"""Whether the chair could still stop short of what stands in the way. The last look at a command among obstacles."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair
from seater_common.se2 import arc_poses, wrap_angles
from seater_common.separation import edge_distances, footprints

Array = NDArray[np.float64]

_POSES = 9  # along the arc to standstill; at 0.6 m/s some 6 cm apart
_CREEP = 1e-3  # [m] by which an obstacle that is too near already may come nearer in this time: numerical noise
_SHORTEST = 5e-3  # [m] pieces of a path shorter than this have no curvature: the chair turns on the spot or back


class BrakingCheck:
    """The optimal control problem keeps clear of obstacles softly, so that it always has a solution. This does not.

    A command passes when the chair, after it held for one period, could brake to standstill with its whole footprint
    `margin` clear of every obstacle, either along the same arc or along the planned path (`braked` brakes along that).
    So an obstacle that stands still is not touched, whatever later plans say; only what appears within the stopping
    distance can be.
    """

    def __init__(self, chair: Chair, margin: float, period: float, lag: float) -> None:
        """`margin` [m] to be kept; `period` [s] for which a command holds; `lag` [s] of the motors."""
        self._corners, self._limits = chair.corners(), chair.limits
        self.margin = margin  # [m]
        self.hold = period + lag  # [s] for which a command goes on after the next one

    def passes(self, pose: ArrayLike, v: float, omega: float, outlines: list[Array], path: Array | None = None) -> bool:
        """`pose` (x, y, heading): where the command begins to act. `outlines`: convex, anticlockwise, (n, 2) [m].

        `path` (n, 3): the plan's poses from there on. Where an obstacle is nearer than the margin already, what does
        not bring it nearer passes: the way out stays open.
        """
        if not outlines or (v == 0.0 and omega == 0.0):
            return True
        if self._clear(self._arc(pose, v, omega), outlines):
            return True
        return path is not None and self._clear(self._stretch(np.vstack([pose, path]), v, omega), outlines)

    def _clear(self, poses: Array, outlines: list[Array]) -> bool:
        shapes = footprints(self._corners, poses)
        for outline in outlines:
            distances = edge_distances(shapes, outline)
            if float(np.min(distances)) < min(self.margin, float(distances[0]) - _CREEP):
                return False
        return True

    def _arc(self, pose: ArrayLike, v: float, omega: float) -> Array:
        """Poses (n, 3) on the arc to standstill, which takes at full speed half of the time that braking takes."""
        braking = max(0.5 * abs(v) / self._limits.a_max, 0.5 * abs(omega) / self._limits.alpha_max)
        return arc_poses(pose, v, omega, np.linspace(0.0, self.hold + braking, _POSES))

    def _stretch(self, path: Array, v: float, omega: float) -> Array:
        """As much of the path (n, 3) as is driven, and turned, until the chair stands."""
        limits = self._limits
        way = abs(v) * self.hold + 0.5 * v * v / limits.a_max
        turn = abs(omega) * self.hold + 0.5 * omega * omega / limits.alpha_max
        driven = np.cumsum(np.hypot(*np.diff(path[:, :2], axis=0).T))
        turned = np.cumsum(np.abs(wrap_angles(np.diff(path[:, 2]))))
        rest = np.flatnonzero((driven >= way) & (turned >= turn))
        return path[: rest[0] + 2] if len(rest) else path


def braked(before: tuple[float, float], change: float, curvature: float | None) -> tuple[float, float]:
    """(v, omega) after braking by `change` [m/s], along a path of this curvature [1/m]; None: the last command's."""
    v, omega = before
    if abs(v) <= change:
        return 0.0, 0.0
    slower = v - math.copysign(change, v)
    return slower, slower * (omega / v if curvature is None else curvature)


def curvature_at(path: Array, pose: ArrayLike) -> float | None:
    """Curvature [1/m] of the path (n, 3) nearest to `pose`: turn per way driven forward; None where it has none."""
    pose = np.asarray(pose, dtype=float)
    i = min(int(np.argmin(np.hypot(*(path[:, :2] - pose[:2]).T))), len(path) - 2)
    step, turn = path[i + 1, :2] - path[i, :2], float(wrap_angles(path[i + 1, 2] - path[i, 2]))
    heading = path[i, 2] + 0.5 * turn
    way = float(step[0] * math.cos(heading) + step[1] * math.sin(heading))  # negative: the path leads backward
    return turn / way if abs(way) > _SHORTEST else None
