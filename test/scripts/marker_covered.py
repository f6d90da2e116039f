#!/usr/bin/env python3
"""The markers are covered on the way: the chair goes on by odometry for the blind distance, then stands and says so."""

import sys

import numpy as np
import rospy
import rostest
from seater_test.harness import DockingCase, travelled

from seater_msgs.msg import DockInnovation, DockResult, MarkerDetectionArray

LONGEST_STOP = 0.5  # [s] from the end of the blind distance to a zero command


class MarkerCovered(DockingCase):
    def setUp(self) -> None:
        self.last_seen = 0.0
        self.innovations: list[DockInnovation] = []
        super().setUp()
        rospy.Subscriber("innovations", DockInnovation, self.innovations.append, queue_size=1000)
        rospy.Subscriber("detections", MarkerDetectionArray, self.on_detections, queue_size=1000)

    def on_detections(self, message: MarkerDetectionArray) -> None:
        if message.dock:
            self.last_seen = message.header.stamp.to_sec()

    def test_stops_after_the_blind_distance(self) -> None:
        blind_distance = float(rospy.get_param("/docking/controller/sequence/max_blind_distance"))
        self.start()
        result = self.result()
        self.assertEqual(result.result_code, DockResult.MARKER_LOST, result.result_text)
        self.assertFalse(result.success)
        self.let_pass(1.0)  # the motors take their time to brake from full speed
        self.assert_standing()

        fused = [message for message in self.innovations if message.outcome == DockInnovation.FUSED]
        self.assertGreater(len(fused), 10, "the observer does not say what it made of the images")
        self.assertTrue(all(m.accepted and 0.0 <= m.gate_ratio <= 1.0 and m.sd_x > 0.0 for m in fused))
        stamps = [m.header.stamp.to_nsec() for m in self.innovations]
        self.assertEqual(len(stamps), len(set(stamps)), "an image was reported twice")
        self.assertLessEqual(max(m.header.stamp.to_sec() for m in self.innovations), self.last_seen)

        time, way = travelled(self.truth, self.last_seen)
        self.assertGreater(way[-1], 0.5 * blind_distance, "it did not go on by odometry at all")
        exceeded = time[int(np.argmax(way >= blind_distance))] if way[-1] >= blind_distance else time[-1]
        moving = [t for t, v, omega in self.commands if v != 0.0 or omega != 0.0]
        self.assertLessEqual(max(moving) - exceeded, LONGEST_STOP)


if __name__ == "__main__":
    rostest.rosrun("seater_test", "marker_covered", MarkerCovered, sys.argv)
