"""Goals that cannot be worked on are refused with the code that says why."""

import math

import numpy as np
import pytest

rospy = pytest.importorskip("rospy")
pytest.importorskip("tf2_ros")
from geometry_msgs.msg import PoseStamped  # noqa: E402
from transforms import Transforms  # noqa: E402

from seater_common.se2 import compose  # noqa: E402
from seater_msgs.msg import DockGoal, UndockGoal  # noqa: E402
from seater_nmpc.ros.goal_checks import RefusedError, check_goal  # noqa: E402
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
    return check_goal(kind, goal, "home", transforms, "odom")


def test_a_pose_in_the_map_comes_back_in_odom(transforms) -> None:
    pose = np.array([3.0, 0.2, -0.7])
    assert check("dock", goal_at(pose), transforms) == pytest.approx(compose(MAP, pose), abs=1e-9)


@pytest.mark.parametrize("name", ["", "home"])
def test_a_named_dock_needs_no_pose(transforms, name) -> None:
    assert check("dock", DockGoal(use_dock_id=True, dock_id=name), transforms) is None
    assert check("undock", UndockGoal(), transforms) is None


def test_an_empty_goal_is_one_to_the_configured_dock(transforms) -> None:
    assert check("dock", DockGoal(), transforms) is None
    assert check("dock", DockGoal(dock_id="home"), transforms) is None


@pytest.mark.parametrize(
    ("goal", "code", "text"),
    [
        (DockGoal(dock_id="other"), ResultCode.DOCK_NOT_IN_DB, "other"),
        (DockGoal(dock_pose=PoseStamped(header=rospy.Header(frame_id="map"))), ResultCode.DOCK_NOT_VALID, "rotation"),
        (DockGoal(use_dock_id=True, dock_id="other"), ResultCode.DOCK_NOT_IN_DB, "other"),
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
