"""Whether the chair could still stop short of what stands in the way. The last look at a command among obstacles."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair
from seater_common.se2 import arc_step
from seater_nmpc.separation import edge_gaps, footprints

Array = NDArray[np.float64]

_POSES = 9  # along the way to standstill; at 0.6 m/s some 6 cm apart
_CREEP = 1e-3  # [m] by which an obstacle that is too near already may come nearer in this time: numerical noise


class BrakingCheck:
    """The optimal control problem keeps clear of obstacles softly, so that it always has a solution. This does not.

    A command passes when the chair, after it held for one period, could brake to standstill along the same arc with its whole
    footprint `margin` clear of every obstacle. Each such command leaves one more that passes (braking), so obstacles that stand
    still are never touched, whatever the plan says; only what appears within the stopping distance can be.
    """

    def __init__(self, chair: Chair, margin: float, period: float, lag: float) -> None:
        """`margin` [m] to be kept; `period` [s] for which a command holds; `lag` [s] of the motors."""
        self._corners, self._limits = chair.corners(), chair.limits
        self._margin, self._hold = margin, period + lag

    def passes(self, pose: ArrayLike, v: float, omega: float, outlines: list[Array]) -> bool:
        """`pose` (x, y, heading): where the command begins to act. `outlines`: convex, anticlockwise, (n, 2) [m], same frame.

        Where an obstacle is nearer than the margin already, what does not bring it nearer passes: the way out stays open.
        """
        if not outlines or (v == 0.0 and omega == 0.0):
            return True
        shapes = footprints(self._corners, self._way(pose, v, omega))
        for outline in outlines:
            gaps = edge_gaps(shapes, outline)
            if float(np.min(gaps)) < min(self._margin, float(gaps[0]) - _CREEP):
                return False
        return True

    def _way(self, pose: ArrayLike, v: float, omega: float) -> Array:
        """Poses (n, 3) from here to standstill: the arc that is driven in as much time at full speed as braking takes twice."""
        braking = max(0.5 * abs(v) / self._limits.a_max, 0.5 * abs(omega) / self._limits.alpha_max)
        return np.array([arc_step(pose, v, omega, t) for t in np.linspace(0.0, self._hold + braking, _POSES)])
