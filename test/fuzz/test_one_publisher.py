"""Two nodes that send one input in turns, or a camera that becomes another one, end the docking and are named."""

from __future__ import annotations

import copy
from collections.abc import Iterator

import pytest
import yaml
from drive import Drive
from geometry_msgs.msg import Point32, Polygon
from sensor_msgs.msg import CameraInfo
from stand import CONFIG, Stand

from seater_msgs.msg import DockResult, ObstacleArray, UndockGoal
from seater_nmpc.sequence.goal.results import ResultCode

RECOVERS = 4.0  # [s]
INFO = "/camera_info"  # beside the topic "image", whose name has no folder on the stand


@pytest.fixture(scope="module")
def stand() -> Iterator[Stand]:
    with pytest.MonkeyPatch.context() as monkeypatch:
        yield Stand(monkeypatch)


@pytest.fixture
def drive(stand: Stand) -> Drive:
    """On its way to the dock. Its time counts, as this machine may be slow."""
    drive = Drive(stand)
    for senders in stand.node._inputs._senders.values():
        senders._clock = lambda: drive.stamp.to_sec()
    drive.advance(0.5)
    assert drive.docks(RECOVERS)
    return drive


def info(**changes: object) -> CameraInfo:
    values = yaml.safe_load((CONFIG / "cameras" / "d455.yaml").read_text())
    message = CameraInfo(width=values["image_width"], height=values["image_height"])
    message.distortion_model = values["distortion_model"]
    message.K, message.D = values["camera_matrix"]["data"], values["distortion_coefficients"]["data"]
    message.R, message.P = values["rectification_matrix"]["data"], values["projection_matrix"]["data"]
    for name, value in changes.items():
        setattr(message, name, value)
    return message


def longer(message: CameraInfo, factor: float) -> CameraInfo:
    message = copy.deepcopy(message)
    message.K = [factor * message.K[0], *message.K[1:4], factor * message.K[4], *message.K[5:]]
    return message


def outlines(drive: Drive, *, full: bool) -> ObstacleArray:
    """A box beside the way, or nothing."""
    message = ObstacleArray()
    message.header.stamp, message.header.frame_id = drive.stamp, "odom"
    corners = [(-1.0, 2.0), (-0.5, 2.0), (-0.5, 2.5), (-1.0, 2.5)]
    message.polygons = [Polygon([Point32(x, y, 0.0) for x, y in corners])] if full else []
    return message


@pytest.mark.parametrize(("topic", "code"), [("odom", "ODOMETRY_WRONG"), ("detections", "INCONSISTENT")])
def test_a_second_sender_ends_the_docking_and_is_named(stand: Stand, drive: Drive, topic: str, code: str) -> None:
    drive.step()
    message = drive.odometry() if topic == "odom" else drive.detections()
    stand.deliver(topic, message, "/another")
    drive.advance(0.5)
    result = stand.results[-1]
    assert not stand.active and result.result_code == getattr(DockResult, code)
    assert f"2 nodes publish {topic} in turns, /another and /hostile" in result.result_text
    assert stand.sent["velocity_request"][-1].twist.linear.x == 0.0
    assert drive.docks(RECOVERS)  # it has gone


def test_two_that_tell_obstacles_in_turns_stop_the_chair(stand: Stand, drive: Drive) -> None:
    for k in range(50):
        stand.deliver("obstacles", outlines(drive, full=k % 2 == 0), f"/teller_{k % 2}")
        drive.advance(0.1)
    assert stand.active and drive._speed == (0.0, 0.0)
    for k in range(100):
        stand.deliver("obstacles", outlines(drive, full=k % 2 == 0), f"/teller_{k % 2}")
        drive.advance(0.1)
    result = stand.results[-1]
    assert result.result_code == DockResult.BLOCKED
    assert "2 nodes publish obstacles in turns, /teller_0 and /teller_1" in result.result_text


def test_another_focal_length_during_a_goal_ends_it(stand: Stand, drive: Drive) -> None:
    for _ in range(3):
        stand.arrive(INFO, info())
        drive.step()
    stand.arrive(INFO, longer(info(), 1.1))  # one may be broken
    stand.arrive(INFO, info())
    drive.step()
    assert stand.active
    for _ in range(2):
        stand.arrive(INFO, longer(info(), 1.1))
    drive.advance(0.5)
    result = stand.results[-1]
    assert not stand.active and result.result_code == DockResult.INCONSISTENT
    assert "camera_info has changed during the goal (fx 640.0 to 704.0)" in result.result_text
    stand.arrive(INFO, longer(info(), 1.1))
    assert drive.docks(RECOVERS)  # with one that stays what it is


def test_a_camera_info_that_says_nothing_is_no_other_camera(stand: Stand, drive: Drive) -> None:
    stand.arrive(INFO, info())
    for message in [info(K=[float("nan")] * 9)] * 3 + [info()]:
        stand.arrive(INFO, message)
        drive.step()
    assert stand.active


def test_backing_out_needs_no_images(stand: Stand, drive: Drive) -> None:
    stand.node._abort(ResultCode.CANCELED, "cancelled")
    drive.advance(0.5)
    stand.give("undock", UndockGoal(force=True))
    for sender in ("/another", "/hostile", "/another"):
        stand.deliver("detections", drive.detections(), sender)
    drive.advance(0.1)
    assert stand.active
    stand.node._abort(ResultCode.CANCELED, "cancelled")
