"""Obstacles between the message and the controller: what is refused, where they are held, when they are dropped."""

import math

import numpy as np
import pytest

rospy = pytest.importorskip("rospy")
pytest.importorskip("tf2_ros")
from geometry_msgs.msg import Point32, Polygon  # noqa: E402
from transforms import Transforms  # noqa: E402

from seater_common.se2 import inverse, transform_points  # noqa: E402
from seater_msgs.msg import ObstacleArray  # noqa: E402
from seater_nmpc.plan.obstacles import ObstacleMemory, usable_outlines  # noqa: E402
from seater_nmpc.ros.obstacles import Obstacles  # noqa: E402

BOX = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
DOCK = np.array([3.0, -1.0, 0.7])


def test_only_what_says_no_place_is_dropped_and_named() -> None:
    bad = [[0.0, 0.0], [1.0, math.nan], [2.0, 0.0]]
    outlines, complaints = usable_outlines([BOX[::-1], bad, np.zeros((0, 2)), [[1e30, 1e30], [2e30, 2e30]]])
    assert len(outlines) == 1 and outlines[0] == pytest.approx(BOX)  # anticlockwise again
    assert [complaint.split(":")[0] for complaint in complaints] == ["polygon 1", "polygon 2", "polygon 3"]


@pytest.mark.parametrize("corners", [[[0.5, 0.5]], [[0.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]])
def test_a_point_or_a_line_is_a_thin_thing(corners: list[list[float]]) -> None:
    (outline,), complaints = usable_outlines([corners])
    assert complaints == []
    ends = np.array([corners[0], corners[-1]])
    assert outline.min(axis=0) == pytest.approx(ends.min(axis=0) - 0.025)
    assert outline.max(axis=0) == pytest.approx(ends.max(axis=0) + 0.025)


def test_in_odom_they_stand_still_while_the_estimate_moves() -> None:
    memory = ObstacleMemory(0.0)
    memory.replace([BOX], bound_to_dock=False)
    for moved in (DOCK, DOCK + [0.2, -0.1, 0.05]):
        (seen,) = memory.in_dock(moved)
        assert transform_points(moved, seen) == pytest.approx(BOX)
    assert memory.in_dock(None) == []


def test_bound_to_the_dock_they_move_with_it() -> None:
    memory = ObstacleMemory(0.0)
    memory.replace([BOX], bound_to_dock=True)
    for dock in (None, DOCK):
        (seen,) = memory.in_dock(dock)
        assert seen == pytest.approx(BOX)


def test_those_of_a_dock_stay_where_they_are_when_another_one_is_looked_for() -> None:
    memory, other = ObstacleMemory(0.0), np.array([0.5, 2.0, -0.4])
    memory.replace([BOX], bound_to_dock=True)
    memory.leave_dock(DOCK)
    assert transform_points(other, memory.in_dock(other)[0]) == pytest.approx(transform_points(DOCK, BOX))
    memory.replace([BOX], bound_to_dock=True)
    memory.leave_dock(None)
    assert memory.in_dock(other) == []


def test_a_message_replaces_the_one_before() -> None:
    memory = ObstacleMemory(0.0)
    memory.replace([BOX, BOX + 3.0], bound_to_dock=True)
    memory.replace([BOX + 1.0], bound_to_dock=True)
    assert len(memory.in_dock(None)) == 1
    memory.replace([], bound_to_dock=True)
    assert memory.in_dock(None) == []


def test_stale_ones_are_named_and_hold() -> None:
    memory = ObstacleMemory(0.5)
    assert not memory.stale(100.0)  # nobody has told any
    memory.replace([BOX], bound_to_dock=True)
    assert [memory.stale(now) for now in (10.0, 10.4)] == [False, False]
    memory.replace([BOX], bound_to_dock=True)  # news: the age begins anew
    assert [memory.stale(now) for now in (10.8, 11.2, 11.4, 11.5)] == [False, False, True, True]
    assert len(memory.in_dock(None)) == 1
    memory.replace([], bound_to_dock=True)  # who tells that nothing is there may fall silent, too
    assert [memory.stale(now) for now in (12.0, 12.6)] == [False, True]


def test_time_that_goes_backward_makes_nothing_stale() -> None:
    memory = ObstacleMemory(0.5)
    memory.replace([BOX], bound_to_dock=True)
    assert [memory.stale(now) for now in (10.0, 2.0, 2.4)] == [False, False, False]


def test_without_a_time_out_they_hold() -> None:
    memory = ObstacleMemory(0.0)
    memory.replace([BOX], bound_to_dock=True)
    assert [memory.stale(now) for now in (0.0, 1e6)] == [False, False]
    assert len(memory.in_dock(None)) == 1


@pytest.fixture
def silent(monkeypatch) -> None:
    monkeypatch.setattr(rospy, "logwarn", lambda *_: None)
    monkeypatch.setattr(rospy, "logwarn_throttle", lambda *_: None)


def obstacle_message(frame: str, outline=BOX, stamp: float = 1.0) -> ObstacleArray:
    message = ObstacleArray()
    message.header.frame_id, message.header.stamp = frame, rospy.Time.from_sec(stamp)
    message.polygons = [Polygon([Point32(x, y, 0.3) for x, y in outline])]
    return message


def ordered(outline: np.ndarray) -> np.ndarray:
    """Corners in an order that does not depend on which of them comes first."""
    return outline[np.lexsort(np.round(outline, 3).T)]


def test_obstacles_of_a_sensor_are_placed_by_tf_at_their_own_stamp(silent) -> None:
    """The chair drove on between the measurement and the message: where it was then counts."""
    transforms, then, now = Transforms(), np.array([2.0, 0.5, 0.3]), np.array([2.5, 0.6, 0.4])
    transforms.put("odom", "laser", then, 1.0)
    transforms.put("odom", "laser", now, 2.0)
    obstacles = Obstacles(transforms, "dock", 0.0)
    obstacles.take(obstacle_message("laser"), "odom")
    (seen,) = obstacles.now("odom", DOCK)
    assert ordered(seen) == pytest.approx(
        ordered(transform_points(inverse(DOCK), transform_points(then, BOX))), abs=1e-6
    )


def test_obstacles_in_odom_and_at_the_dock_need_no_transform(silent) -> None:
    obstacles = Obstacles(Transforms(), "dock", 0.0)
    obstacles.take(obstacle_message("odom"), "odom")
    (seen,) = obstacles.now("odom", DOCK)
    assert ordered(seen) == pytest.approx(ordered(transform_points(inverse(DOCK), BOX)), abs=1e-6)
    obstacles.take(obstacle_message("dock"), "odom")
    (seen,) = obstacles.now("odom", None)
    assert seen == pytest.approx(BOX)


def test_without_its_transform_a_message_waits_and_the_last_one_holds(silent) -> None:
    transforms = Transforms()
    obstacles = Obstacles(transforms, "dock", 0.0)
    obstacles.take(obstacle_message("dock"), "odom")
    obstacles.take(obstacle_message("laser", BOX + 5.0), "odom")
    (seen,) = obstacles.now("odom", DOCK)
    assert seen == pytest.approx(BOX)
    transforms.put("odom", "laser", np.zeros(3), 1.0)
    (seen,) = obstacles.now("odom", np.zeros(3))
    assert seen == pytest.approx(BOX + 5.0, abs=1e-6)


def test_a_frame_that_cannot_be_resolved_is_trouble_until_it_can(silent) -> None:
    transforms = Transforms()
    obstacles = Obstacles(transforms, "dock", 0.0)
    said = []
    for stamp in (1.0, 1.4, 1.6):  # as a sensor tells all the time
        obstacles.take(obstacle_message("laser", stamp=1.0), "odom")
        obstacles.now("odom", DOCK)
        said.append(obstacles.trouble(stamp))
    assert said[:2] == ["", ""] and "a frame that cannot be resolved: 'laser'" in said[2]
    transforms.put("odom", "laser", np.zeros(3), 1.0)
    obstacles.now("odom", DOCK)
    assert obstacles.trouble(1.7) == ""


def test_what_is_none_and_silence_are_trouble(silent) -> None:
    obstacles = Obstacles(Transforms(), "dock", 0.5)
    assert obstacles.trouble(0.0) == ""
    obstacles.take(obstacle_message("odom", [[0.0, math.nan]]), "odom")
    assert "none: polygon 0" in obstacles.trouble(1.0)
    obstacles.take(obstacle_message("odom"), "odom")
    assert [obstacles.trouble(stamp) for stamp in (1.0, 1.4, 1.6)] == ["", "", "nothing new on `obstacles` for 0.5 s"]


@pytest.mark.parametrize("number, corners", [(101, 3), (2, 6000)])
def test_more_than_a_control_cycle_has_time_for_is_trouble(number: int, corners: int) -> None:
    polygon = np.random.default_rng(1).uniform(1.0, 2.0, (corners, 2))
    outlines, complaints = usable_outlines([polygon] * number)
    assert not outlines and complaints[0].startswith(f"{number} polygons with {number * corners} corners, at most 100")
    assert len(usable_outlines([polygon[:4]] * 100)[0]) == 100
