"""The gate is told of the bay's walls while a person drives, in base_link, and of none while the chair docks."""

import math

import numpy as np
import pytest
import rospy
from conftest import Sent

from seater_common.geometry import Bay, Chair, Dock
from seater_common.se2 import relative, transform_points
from seater_nmpc.ros.docks.walls import SPACING, BayWalls, wall_points

DOCK = (2.0, 0.5, 0.3)  # in odom


@pytest.mark.parametrize("base", [DOCK, (1.5, 0.3, 0.4)])
def test_the_points_lie_on_the_walls_and_leave_no_gap(base: tuple[float, float, float]) -> None:
    bay = Bay()
    points = transform_points(relative(DOCK, base), wall_points(bay, relative(base, DOCK)))
    for outline in bay.outlines():
        for share in np.linspace(0.0, 1.0, 37):
            for begin, end in zip(outline, np.roll(outline, -1, axis=0), strict=True):
                at = begin + share * (end - begin)
                assert np.hypot(*(points - at).T).min() <= 0.5 * SPACING + 1e-9
    ahead = points[np.abs(points[:, 1]) < 0.3]
    assert ahead[:, 0].min() == pytest.approx(bay.back_wall_x)


def test_what_is_far_away_is_not_told() -> None:
    assert len(wall_points(Bay(), relative((-4.0, 0.5, 0.0), DOCK))) == 0


def test_they_are_told_while_nobody_docks_and_taken_back_at_once(sent: Sent) -> None:
    bay = Dock().bay
    tellings = BayWalls()
    for time, docks in ((10.0, False), (10.05, False), (10.1, False), (10.15, True), (10.2, True), (10.3, False)):
        tellings.update(rospy.Time(time), bay, DOCK, DOCK, docks=docks)
    told = [(round(m.header.stamp.to_sec(), 3), m.header.frame_id, m.source, len(m.x) > 0) for m in sent]
    walls_told, none = ("base_link", "bay", True), ("base_link", "bay", False)
    assert told == [(10.0, *walls_told), (10.1, *walls_told), (10.15, *none), (10.3, *walls_told)]
    tellings.update(rospy.Time(10.35), bay, None, DOCK, docks=False)  # the dock is out of sight
    assert len(sent) == 5 and not sent[-1].x
    tellings.update(rospy.Time(3.0), bay, DOCK, DOCK, docks=False)  # time went backward
    assert len(sent) == 6


def test_the_chair_of_a_backward_dock_has_them_behind_it() -> None:
    turned = (DOCK[0], DOCK[1], DOCK[2] + math.pi)
    points, chair = wall_points(Bay(), relative(turned, DOCK)), Chair()
    beside = np.abs(points[:, 1]) < 0.5 * chair.width
    assert points[beside, 0].max() == pytest.approx(-Bay().back_wall_x)
