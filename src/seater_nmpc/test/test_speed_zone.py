"""The docking node tells the gate where to be slow: at once when it changes, and again and again."""

import rospy
from conftest import Sent

from seater_common.geometry import Chair, Dock
from seater_nmpc.ros.speed_zone import SpeedZone

FAR, IN_BAY, DOCK = (0.0, 0.0, 0.0), (1.9, 0.0, 0.0), (2.0, 0.0, 0.0)  # in odom


def test_it_tells_changes_at_once_and_repeats_itself(sent: Sent) -> None:
    chair = Chair()
    zone = SpeedZone(chair, Dock(), 0.1)
    for time in (10.0, 10.05, 10.5):
        zone.update(rospy.Time(time), DOCK, FAR, backs_out=False)
    assert [(m.header.stamp.to_sec(), m.v_max) for m in sent] == [(10.0, 0.6), (10.5, 0.6)]
    zone.update(rospy.Time(10.55), DOCK, IN_BAY, backs_out=False)
    assert (sent[-1].header.stamp.to_sec(), sent[-1].v_max) == (10.55, chair.limits.v_bay_max)
    zone.update(rospy.Time(3.0), DOCK, IN_BAY, backs_out=False)  # time went backward
    assert len(sent) == 4


def test_backing_out_is_slow_wherever_the_dock_is(sent: Sent) -> None:
    zone = SpeedZone(Chair(), Dock(), 0.1)
    zone.update(rospy.Time(10.0), None, FAR, backs_out=False)
    assert not sent
    for time, dock, backs_out in ((10.0, None, True), (10.05, DOCK, True), (10.1, None, False), (11.0, None, False)):
        zone.update(rospy.Time(time), dock, FAR, backs_out=backs_out)
    assert [(m.v_max, m.reason) for m in sent] == [(0.1, "backs out"), (0.6, "outside the bay")]
