"""Which place is taken for the dock: that of the dock in use only."""

from __future__ import annotations

import pytest

rospy = pytest.importorskip("rospy")
tf2_ros = pytest.importorskip("tf2_ros")
from geometry_msgs.msg import TransformStamped  # noqa: E402
from std_msgs.msg import Header  # noqa: E402

from seater_obstacles.ros import frames  # noqa: E402


class Transforms(tf2_ros.BufferCore):
    """TF without ROS round it."""

    def put(self, parent: str, child: str, x: float, stamp: float) -> None:
        message = TransformStamped(child_frame_id=child)
        message.header.frame_id, message.header.stamp = parent, rospy.Time.from_sec(stamp)
        message.transform.translation.x, message.transform.rotation.w = x, 1.0
        self.set_transform(message, "test")

    def lookup_transform(self, target: str, source: str, time: rospy.Time) -> TransformStamped:
        return self.lookup_transform_core(target, source, time)


@pytest.fixture
def where(monkeypatch: pytest.MonkeyPatch) -> frames.Where:
    """The chair and its sensor do not move; a dock was seen at 5 s, 2 m ahead."""
    monkeypatch.setattr(frames, "TransformBuffer", Transforms)
    monkeypatch.setattr(tf2_ros, "TransformListener", lambda buffer: None)
    found = frames.Where(frames.Frames("base_link", "odom", "dock"), lock_step=False)
    for stamp in (4.0, 9.0):
        found._tf.put("odom", "base_link", 0.0, stamp)
        found._tf.put("base_link", "laser", 0.3, stamp)
    found._tf.put("odom", "dock", 2.0, 5.0)
    return found


def dock_at(where: frames.Where, stamp: float) -> float | None:
    """How far ahead it is taken to be."""
    place = where.at(Header(frame_id="laser", stamp=rospy.Time.from_sec(stamp))).T_odom_dock
    return None if place is None else float(place[0])


def test_the_dock_is_where_it_was_seen_last(where) -> None:
    assert dock_at(where, 8.0) == 2.0


def test_the_place_of_another_dock_is_not_that_of_the_one_in_use(where) -> None:
    where.dock_since = rospy.Time.from_sec(6.0)
    assert dock_at(where, 8.0) is None  # not seen yet
    where._tf.put("odom", "dock", 3.5, 6.5)
    assert dock_at(where, 8.0) == 3.5
