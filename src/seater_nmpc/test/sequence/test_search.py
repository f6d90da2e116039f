"""Turns on the spot beside the bay, in search of a dock of which only a rough pose is known."""

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock, polygon_distance
from seater_common.se2 import arc_step
from seater_nmpc.sequence.phases.search import Search

CHAIR, DOCK, PERIOD = Chair(), Dock(), 0.4


def nearest(start: list[float], *, rough: bool) -> tuple[float, float]:
    """Least distance [m] of the footprint from the walls, and the largest turn [rad], until the search ends."""
    search, pose = Search(CHAIR, DOCK, 0.1), np.array(start)
    gap, turned = np.inf, 0.0
    for k in range(750):
        speeds = search.speeds(PERIOD * k, pose, pose, [], rough=rough)
        if speeds is None:
            return gap, turned
        pose = arc_step(pose, *speeds, PERIOD)
        turned = max(turned, abs(float(pose[2]) - start[2]))
        corners = CHAIR.corners_at(pose)
        gap = min(gap, *(polygon_distance(corners, wall) for wall in DOCK.bay.outlines()))
    raise AssertionError("it searches for ever")


@pytest.mark.parametrize(("rough", "least"), [(True, 0.3), (False, 0.09)])
def test_walls_of_a_dock_that_was_not_seen_are_kept_far_away(rough: bool, least: float) -> None:
    """By the rough pose 0.34 m from the wall: it was elsewhere by 0.25 m, and a corner touched it."""
    gap, turned = nearest([-0.838, -1.226, -0.04], rough=rough)
    assert gap >= least and turned > 0.5
    assert rough or gap < 0.3
