"""The walls of a dock that was left for another one."""

from dataclasses import replace

import numpy as np
import pytest

from seater_common.geometry import Dock
from seater_common.se2 import compose, inverse, transform_points
from seater_nmpc.plan.left_bays import LeftBays

LAB, HALL = replace(Dock(), name="lab"), replace(Dock(), name="hall")
T_ODOM_LAB, T_ODOM_HALL = np.array([2.0, 1.0, 0.3]), np.array([1.0, 4.0, 1.2])
BEFORE_LAB = compose(T_ODOM_LAB, [-1.2, 0.0, 0.0])


@pytest.fixture
def bays() -> LeftBays:
    """The chair before the lab, on its way to the hall."""
    bays = LeftBays()
    bays.leave(LAB, T_ODOM_LAB, 0.3)
    bays.use(HALL)
    return bays


def test_walls_of_the_dock_that_was_left_are_obstacles_where_they_are(bays) -> None:
    walls = bays.in_dock(HALL.bay, T_ODOM_HALL, BEFORE_LAB)
    T_hall_lab = compose(inverse(T_ODOM_HALL), T_ODOM_LAB)
    assert len(walls) == 3
    for wall, known in zip(walls, LAB.bay.outlines(), strict=True):
        assert wall == pytest.approx(transform_points(T_hall_lab, known), abs=1e-9)


def test_far_away_they_count_no_more_as_odometry_drifts(bays) -> None:
    assert bays.in_dock(HALL.bay, T_ODOM_HALL, T_ODOM_LAB + [5.1, 0.0, 0.0]) == []
    assert bays.in_dock(HALL.bay, T_ODOM_HALL, BEFORE_LAB) == []  # nor on the way back


def test_walls_that_were_seen_long_ago_do_not_count() -> None:
    bays = LeftBays()
    bays.leave(LAB, T_ODOM_LAB, 5.1)
    assert bays.in_dock(HALL.bay, T_ODOM_HALL, BEFORE_LAB) == []


def test_the_dock_in_use_knows_its_own_walls(bays) -> None:
    bays.leave(HALL, T_ODOM_HALL, 0.3)
    bays.use(LAB)
    assert len(bays.in_dock(LAB.bay, T_ODOM_LAB, BEFORE_LAB)) == 3  # the hall's
    bays.use(HALL)
    assert bays.in_dock(HALL.bay, T_ODOM_HALL, BEFORE_LAB) == []


def test_a_wall_that_two_docks_share_is_the_own_one(bays) -> None:
    """Docks side by side: the bay is 1.0 m wide, the wall between them 0.1 m thick."""
    beside = compose(T_ODOM_LAB, [0.0, 1.12, 0.0])  # as seen 2 cm off
    walls = bays.in_dock(HALL.bay, beside, BEFORE_LAB)
    assert len(walls) == 1 and np.max(walls[0][:, 1]) < -1.5  # the far side wall; shared and back walls touch its own


def test_nothing_is_left_when_the_odometry_begins_anew(bays) -> None:
    bays.forget()
    assert bays.in_dock(HALL.bay, T_ODOM_HALL, BEFORE_LAB) == []
