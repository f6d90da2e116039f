"""Goals that cannot be worked on are refused with the code that says why."""

import math
from dataclasses import replace

import numpy as np
import pytest

rospy = pytest.importorskip("rospy")
pytest.importorskip("tf2_ros")
from geometry_msgs.msg import PoseStamped  # noqa: E402
from transforms import Transforms  # noqa: E402

from seater_common.files.docks import DockDatabase, DockEntry  # noqa: E402
from seater_common.geometry import Dock, Marker  # noqa: E402
from seater_common.params import as_mapping  # noqa: E402
from seater_common.se2 import compose  # noqa: E402
from seater_msgs.msg import DockGoal, UndockGoal  # noqa: E402
from seater_nmpc.ros.goal_checks import RefusedError, check_goal, dock_of  # noqa: E402
from seater_nmpc.sequence.goal.results import ResultCode  # noqa: E402

MAP = np.array([1.0, -0.5, 0.4])


@pytest.fixture
def transforms() -> Transforms:
    buffer = Transforms()
    buffer.put("odom", "map", MAP, 5.0)
    return buffer


def goal_at(pose, frame="map", stamp=5.0) -> DockGoal:
    stamped = PoseStamped()
    stamped.header.frame_id, stamped.header.stamp = frame, rospy.Time.from_sec(stamp)
    stamped.pose.position.x, stamped.pose.position.y = pose[0], pose[1]
    stamped.pose.orientation.z, stamped.pose.orientation.w = math.sin(pose[2] / 2), math.cos(pose[2] / 2)
    return DockGoal(use_dock_id=False, dock_pose=stamped)


def check(kind, goal, transforms):
    return check_goal(kind, goal, transforms, "odom")


def docks() -> DockDatabase:
    """Home, which is configured, and another one."""
    other = as_mapping(replace(Dock(), name="other", markers=[Marker(id=9)]))
    return DockDatabase(
        DockEntry.of(as_mapping(replace(Dock(), name="home")), "~dock"), [DockEntry.of(other, "other.yaml")]
    )


def test_a_pose_in_the_map_comes_back_in_odom(transforms) -> None:
    pose = np.array([3.0, 0.2, -0.7])
    assert check("dock", goal_at(pose), transforms) == pytest.approx(compose(MAP, pose), abs=1e-9)


def test_a_goal_without_a_pose_says_nothing_of_where_the_dock_is(transforms) -> None:
    assert check("dock", DockGoal(), transforms) is None
    assert (
        check("dock", DockGoal(dock_id="home", dock_pose=goal_at([1, 0, 0]).dock_pose, use_dock_id=True), transforms)
        is None
    )
    assert check("undock", UndockGoal(), transforms) is None


@pytest.mark.parametrize(("dock_id", "name"), [("", "home"), ("home", "home"), ("other", "other")])
def test_a_goal_names_its_dock_with_or_without_a_pose(dock_id, name) -> None:
    for goal in (DockGoal(dock_id=dock_id), DockGoal(dock_id=dock_id, dock_pose=goal_at([1, 0, 0]).dock_pose)):
        assert dock_of("dock", goal, docks(), "other") == name


def test_a_chair_leaves_the_dock_that_is_in_use() -> None:
    assert dock_of("undock", UndockGoal(), docks(), "other") == "other"


def test_an_unknown_dock_is_refused_with_the_names_of_the_known_ones() -> None:
    with pytest.raises(RefusedError, match="known are home, other") as refused:
        dock_of("dock", DockGoal(dock_id="attic"), docks(), "home")
    assert refused.value.code is ResultCode.DOCK_NOT_IN_DB


@pytest.mark.parametrize(
    ("goal", "code", "text"),
    [
        (DockGoal(dock_pose=PoseStamped(header=rospy.Header(frame_id="map"))), ResultCode.DOCK_NOT_VALID, "rotation"),
        (DockGoal(use_dock_id=True, timeout=-1.0), ResultCode.DOCK_NOT_VALID, "timeout"),
        (DockGoal(use_dock_id=True, timeout=math.nan), ResultCode.DOCK_NOT_VALID, "timeout"),
        (goal_at([math.nan, 0.0, 0.0]), ResultCode.DOCK_NOT_VALID, "finite"),
        (goal_at([1.0, 0.0, 0.0], frame="moon"), ResultCode.DOCK_NOT_VALID, "moon"),
        (goal_at([1.0, 0.0, 0.0], stamp=99.0), ResultCode.DOCK_NOT_VALID, "dock_pose"),
    ],
)
def test_what_cannot_be_used_is_refused(transforms, goal, code, text) -> None:
    with pytest.raises(RefusedError) as refused:
        check("dock", goal, transforms)
    assert refused.value.code is code and text in refused.value.text
