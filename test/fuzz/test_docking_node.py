"""Hostile messages to the docking node: no error, nothing not finite or beyond a limit, and the next goal drives."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import rospy
from amount import EPISODES, PER_EPISODE
from drive import STEP, Drive
from geometry_msgs.msg import Point32, Polygon, PoseStamped
from hostile import Hostile
from stand import Stand
from std_msgs.msg import Bool
from test_camera_info import good
from tf2_msgs.msg import TFMessage

from seater_msgs.msg import DockGoal, DockResult, ObstacleArray, UndockGoal
from seater_nmpc.ros import conversions
from seater_nmpc.sequence.goal.results import ResultCode

MOST_AT_ONCE = max(1, PER_EPISODE // 10)  # hostile messages between two good ones
RECOVERS = 4.0  # [s] of good messages until the chair drives; forgetting obstacles takes half a second of it

Make = Callable[[Drive], Any]


def obstacles(drive: Drive) -> ObstacleArray:
    """A box beside the way, in odom."""
    message = ObstacleArray()
    message.header.stamp, message.header.frame_id = drive.stamp, "odom"
    message.polygons = [Polygon([Point32(x, y, 0.0) for x, y in ((-1.0, 1.5), (-0.8, 1.5), (-0.9, 1.8))])]
    return message


def dock_goal(drive: Drive) -> DockGoal:
    goal = DockGoal(use_dock_id=False, dock_pose=PoseStamped())
    goal.dock_pose.header.stamp, goal.dock_pose.header.frame_id = drive.stamp, "odom"
    goal.dock_pose.pose.orientation.w = 1.0
    return goal


TOPICS: dict[str, Make] = {
    "odom": Drive.odometry,
    "detections": Drive.detections,
    "gate_state": Drive.gate_state,
    "obstacles": obstacles,
    "/camera_info": lambda drive: good(),
    "charging_contact": lambda drive: Bool(False),
    "/tf": lambda drive: TFMessage([conversions.transform(drive.stamp, "odom", "base_link", (0.1, 0.2, 0.3))]),
    "/tf_static": lambda drive: TFMessage([conversions.transform(drive.stamp, "base_link", "laser", (0.1, 0.0, 0.0))]),
}
GOALS: dict[str, Make] = {"dock": dock_goal, "undock": lambda drive: UndockGoal()}


@pytest.fixture(scope="module")
def stand() -> Iterator[Stand]:
    with pytest.MonkeyPatch.context() as monkeypatch:
        yield Stand(monkeypatch)


@pytest.mark.parametrize("name", [*TOPICS, *GOALS])
def test_hostile_messages_to_the_docking_node(stand: Stand, name: str) -> None:
    hostile, drive = Hostile(name), Drive(stand)
    for episode in range(EPISODES):
        drive.begin()
        assert drive.docks(RECOVERS), f"{name}, episode {episode}: drives before"
        attack(stand, drive, hostile, name)
        stand.node._diagnostics._updater.update()
        assert stand.errors + stand.violations == [], f"{name}, episode {episode}"
        recover(stand, drive)
        assert drive.docks(RECOVERS), f"{name}, episode {episode}: {last(stand)}"


def attack(stand: Stand, drive: Drive, hostile: Hostile, name: str) -> None:
    """Hostile messages of one kind among good ones of all."""
    left = PER_EPISODE
    while left > 0:
        for _ in range(min(left, hostile.random.randint(1, MOST_AT_ONCE))):
            left -= 1
            if name in GOALS:
                stand.give(name, hostile.spoil(GOALS[name](drive)))
            else:
                stand.deliver(name, hostile.spoil(TOPICS[name](drive)))
        drive.step()
        if not stand.active and hostile.random.random() < 0.2:
            stand.give("dock", DockGoal(use_dock_id=True))


def recover(stand: Stand, drive: Drive) -> None:
    """What people do: the goal that is left is cancelled, what is out of date is said anew, the chair stands again."""
    stand.node._abort(ResultCode.CANCELED, "cancelled")
    drive.begin()
    stand.deliver("obstacles", ObstacleArray(header=obstacles(drive).header))
    stand.deliver("charging_contact", Bool(False))
    drive.advance(0.5)


def last(stand: Stand) -> str:
    return stand.results[-1].result_text if stand.results else "no result"


def test_one_unusable_odometry_from_the_future_blocks_nothing(stand: Stand) -> None:
    """Refused for its NaN, its stamp counted all the same: every later goal ended at once."""
    drive = Drive(stand)
    message = drive.odometry()
    message.header.stamp, message.twist.twist.linear.x = rospy.Time(2**31), math.nan
    stand.deliver("odom", message)
    drive.advance(0.5)
    assert drive.docks(RECOVERS), last(stand)


@pytest.mark.parametrize("frame", ["header", "child"])
def test_odometry_of_another_body_or_frame_ends_the_goal(stand: Stand, frame: str) -> None:
    """It named the front of the chair instead of base_link, and the docking asked whether the dock had been moved."""
    drive = Drive(stand)
    assert drive.docks(RECOVERS), last(stand)
    drive.advance(STEP)
    message = drive.odometry()
    message.header.stamp += rospy.Duration(0, 10000000)
    if frame == "header":
        message.header.frame_id = "map"
    else:
        message.child_frame_id = "chair_front"
    stand.deliver("odom", message)
    assert (stand.results[-1].result_code, stand.active) == (DockResult.ODOMETRY_WRONG, False)
    assert "two nodes" in last(stand) and stand.sent["velocity_request"][-1].twist.linear.x == 0.0
    drive.begin()
    drive.advance(0.5)
    assert drive.docks(RECOVERS), last(stand)
    stand.node._abort(ResultCode.CANCELED, "the test ends")


def test_after_a_pause_only_the_newest_odometry_moves_the_chair(stand: Stand) -> None:
    """A search for a way takes a second on a busy machine: commands for each cycle of that second came at once, and the
    chair, whose odometry was as old, counted as blocked."""
    drive = Drive(stand)
    assert drive.docks(RECOVERS), last(stand)
    stand.sent["velocity_request"].clear()
    waiting = drive.standing(1.0)
    for message in waiting:
        stand.arrive("odom", message)
    stand.work_off()
    requests = stand.sent["velocity_request"]
    assert 1 <= len(requests) <= 2 and requests[-1].header.stamp >= waiting[-1].header.stamp - rospy.Duration(
        0, 50000000
    )
    assert stand.active, last(stand)
    stand.node._abort(ResultCode.CANCELED, "the test ends")


def test_what_took_too_long_to_work_out_is_not_asked_for(stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    """The gate ends the consent for a request with an old stamp; after silence, which brakes, the goal goes on."""
    drive = Drive(stand)
    assert drive.docks(RECOVERS), last(stand)
    update, sent = stand.node._core.sequence.update, len(stand.sent["velocity_request"])

    def slow(*arguments: Any) -> Any:
        time.sleep(0.25)
        return update(*arguments)

    with monkeypatch.context() as busy:
        busy.setattr(stand.node._core.sequence, "update", slow)
        drive.advance(0.1)
    assert len(stand.sent["velocity_request"]) == sent
    drive.advance(0.1)
    assert len(stand.sent["velocity_request"]) > sent and stand.active, last(stand)
    stand.node._abort(ResultCode.CANCELED, "the test ends")


def test_a_watchdog_that_was_late_itself_ends_nothing(stand: Stand) -> None:
    drive = Drive(stand)
    assert drive.docks(RECOVERS), last(stand)
    stand.put("watchdog", None)
    stand.work_off()
    assert stand.active, last(stand)
    time.sleep(0.35)  # odometry_timeout
    stand.put("watchdog", None)
    stand.work_off()
    assert stand.results[-1].result_code == DockResult.ODOMETRY_LOST and not stand.active


def test_a_second_goal_replaces_the_first_and_the_other_action_is_busy(stand: Stand) -> None:
    drive = Drive(stand)
    assert drive.docks(RECOVERS)
    stand.give("undock", UndockGoal())
    assert (stand.results[-1].result_code, stand.active) == (DockResult.BUSY, True)
    stand.give("dock", DockGoal(use_dock_id=True))
    assert (stand.results[-1].result_code, stand.active) == (DockResult.CANCELED, True)
    stand.node._abort(ResultCode.CANCELED, "the test ends")


@pytest.mark.parametrize("error", [ZeroDivisionError, rospy.exceptions.ROSSerializationException])
def test_an_error_in_a_handler_ends_the_goal(
    stand: Stand, monkeypatch: pytest.MonkeyPatch, error: type[Exception]
) -> None:
    """Whatever it is: zero, and the client is told. Errors of ROS ended the worker's thread, silently."""
    drive = Drive(stand)
    assert drive.docks(RECOVERS)

    def fails(*_: Any) -> None:
        raise error("sabotaged")

    with monkeypatch.context() as broken:
        broken.setattr(stand.node._core.sequence, "add_detections", fails)
        stand.deliver("detections", drive.detections())
    assert stand.errors == [f"docking node, detections: {error.__name__}: sabotaged"]
    stand.errors.clear()
    assert (stand.results[-1].result_code, stand.active) == (DockResult.UNKNOWN, False)
    assert stand.sent["velocity_request"][-1].twist.linear.x == 0.0
    assert rospy.Time() < drive.stamp


def test_a_node_that_ends_ends_its_goal(monkeypatch: pytest.MonkeyPatch) -> None:
    """`rosnode kill`: the client waited for its result for ever."""
    stand = Stand(monkeypatch)
    drive = Drive(stand)
    assert drive.docks(RECOVERS), last(stand)
    stand.node._on_shutdown()
    assert (stand.results[-1].result_code, stand.active) == (DockResult.UNKNOWN, False)
    assert last(stand) == "the docking node ends" and stand.sent["velocity_request"][-1].twist.linear.x == 0.0
