"""Turns on the spot beside the bay, in search of a dock of which only a rough pose is known."""

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock, polygon_distance
from seater_common.se2 import arc_step
from seater_nmpc.sequence.phases.search import Search

CHAIR, DOCK, PERIOD = Chair(), Dock(), 0.4


VIEWPOINT = np.array([-2.05, 0.0])  # 1.3 m ahead of the bay with its front


def nearest(start: list[float], *, rough: bool) -> tuple[float, float, float]:
    """Least distance [m] of the footprint from the walls, the largest turn [rad], and how near to the viewpoint [m] it
    comes, until the search ends."""
    search, pose = Search(CHAIR, DOCK, 0.1), np.array(start)
    gap, turned, off = np.inf, 0.0, np.inf
    for k in range(750):
        speeds = search.speeds(PERIOD * k, pose, pose, [], rough=rough)
        if speeds is None:
            return gap, turned, off
        pose = arc_step(pose, *speeds, PERIOD)
        turned = max(turned, abs(float(pose[2]) - start[2]))
        corners = CHAIR.corners_at(pose)
        off = min(off, float(np.linalg.norm(pose[:2] - VIEWPOINT)))
        gap = min(gap, *(polygon_distance(corners, wall) for wall in DOCK.bay.outlines()))
    raise AssertionError("it searches for ever")


@pytest.mark.parametrize(("rough", "least"), [(True, 0.3), (False, 0.09)])
def test_walls_of_a_dock_that_was_not_seen_are_kept_far_away(rough: bool, least: float) -> None:
    """By the rough pose 0.34 m from the wall: it was elsewhere by 0.25 m, and a corner touched it."""
    gap, turned, _ = nearest([-0.838, -1.226, -0.04], rough=rough)
    assert gap >= least and turned > 0.5
    assert rough or gap < 0.3


@pytest.mark.parametrize("start", [[-0.872, -1.371, 0.743], [-0.483, -1.566, 0.702], [-0.427, 1.202, 0.181]])
def test_room_is_made_where_no_turn_is_clear(start: list[float]) -> None:
    """As told to three of 50 chairs beside the bay: FAILED_TO_DETECT_DOCK after 4 to 13 s, "looked all round"."""
    gap, _, off = nearest(start, rough=True)
    corners = CHAIR.corners_at(np.array(start))
    begun = min(polygon_distance(corners, wall) for wall in DOCK.bay.outlines())
    assert off < 0.15 and gap >= min(0.3, begun - 0.002)
