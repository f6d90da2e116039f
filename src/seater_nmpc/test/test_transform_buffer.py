"""Stamps that tf2's binding cannot represent are refused; without the check they end the process."""

import pytest

rospy = pytest.importorskip("rospy")
tf2_ros = pytest.importorskip("tf2_ros")

from seater_nmpc.ros import conversions  # noqa: E402
from seater_nmpc.ros.transforms import TransformBuffer  # noqa: E402

PROPER = rospy.Time(1000)
ABSURD = [rospy.Time(2**31 - 1, 999999999), rospy.Time(2**31), rospy.Time(2**32 - 1, 999999999)]


@pytest.fixture
def buffer(monkeypatch: pytest.MonkeyPatch) -> TransformBuffer:
    monkeypatch.setattr(rospy, "logwarn_throttle", lambda *_: None)
    found = TransformBuffer(debug=False)
    found.set_transform(conversions.transform(PROPER, "odom", "laser", (1.0, 2.0, 0.0)), "test")
    return found


@pytest.mark.parametrize("stamp", ABSURD)
def test_a_question_at_an_absurd_time_is_refused(buffer: TransformBuffer, stamp: rospy.Time) -> None:
    with pytest.raises(tf2_ros.TransformException, match="cannot represent"):
        buffer.lookup_transform("odom", "laser", stamp)
    assert buffer.lookup_transform("odom", "laser", PROPER).transform.translation.y == 2.0


@pytest.mark.parametrize("stamp", ABSURD)
def test_a_transform_of_an_absurd_time_is_dropped(buffer: TransformBuffer, stamp: rospy.Time) -> None:
    buffer.set_transform(conversions.transform(stamp, "odom", "laser", (5.0, 5.0, 0.0)), "test")
    assert buffer.lookup_transform("odom", "laser", rospy.Time()).transform.translation.y == 2.0
    buffer.set_transform_static(conversions.transform(stamp, "laser", "lens", (0.5, 0.0, 0.0)), "test")
    assert buffer.lookup_transform("odom", "lens", PROPER).transform.translation.x == 1.5
