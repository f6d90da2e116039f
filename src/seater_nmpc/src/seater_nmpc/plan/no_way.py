"""Why there is no way to the dock, in words that name what could be changed."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from seater_common.geometry import Bay, Chair
from seater_nmpc.parameters import PlannerParameters

OBSTACLES = "obstacles leave no way into the bay"
NO_HEADING = "no clear way begins with the chair's heading: there is no room to turn it"


def narrow(chair: Chair, bay: Bay, margin: float) -> str:
    """The bay's walls are nearer to the chair than the planner's `margin` [m]."""
    gap = 0.5 * (bay.width - chair.width)
    return (
        f"the bay's walls leave no way in: its width of {bay.width:.3f} m leaves {gap:.3f} m on each side of the "
        f"chair, and {margin:.3f} m are kept (control/margin and planner/extra_margin)"
    )


def outside(start: ArrayLike, parameters: PlannerParameters) -> str:
    """`start` (x, y, heading) is beyond the lattice."""
    x, y, _ = np.asarray(start, dtype=float)
    return (
        f"the chair at ({x:.2f}, {y:.2f}) m is outside the searched area: up to {parameters.reach:.1f} m ahead of the "
        f"dock (planner/reach), {parameters.half_width:.1f} m aside (planner/half_width)"
    )


def too_near(what: str, margin: float) -> str:
    """The chair stands within the planner's `margin` [m] of a wall or an obstacle."""
    return f"the chair stands nearer than {margin:.3f} m to {what} (control/margin and planner/extra_margin)"


def enclosed(by_obstacles: bool) -> str:
    """Free where it stands, but nothing leads from there to the bay."""
    return f"{'walls and obstacles' if by_obstacles else 'the bay walls'} enclose the chair"
