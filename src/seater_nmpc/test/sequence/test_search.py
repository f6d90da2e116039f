"""Turns on the spot beside the bay, in search of a dock of which only a rough pose is known."""

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock, polygon_distance
from seater_common.se2 import arc_step
from seater_nmpc.sequence.goal.results import Phase
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


def test_who_loses_the_dock_again_drives_round_to_the_front(make_world) -> None:
    """A side wall began to hide the only marker, and each way from there led out of its sight once more: MARKER_LOST
    (single_marker_alone, seed 1927301448)."""

    def seen(world) -> bool:
        to_dock = np.arctan2(-world.truth[1], 0.9 - world.truth[0]) - world.truth[2]
        return bool(abs(to_dock) < 0.75)

    sequence = {"max_blind_time": 0.5, "search_after": 0.5}
    world = make_world((-2.1, 0.75, -15.0), seen=seen, sequence=sequence)
    world.period = 0.05
    world.tick()
    world.sequence.start_dock(world.now)
    world.run(8.0, until=lambda step: step.phase is Phase.APPROACH)
    world.sequence._phases._finding._lost = 1  # it has turned back once
    world.truth = np.array([-2.1, 0.75, -1.4])  # pushed round, as the odometry sees, too
    world.run(5.0, until=lambda step: step.phase is Phase.SEARCHING)
    step = world.run(30.0, until=lambda step: step.phase is not Phase.SEARCHING)
    assert world.phases[1:3] == ["APPROACH", "SEARCHING"] and step.phase in (Phase.APPROACH, Phase.FINAL)
    assert abs(world.truth[1]) < 0.5
