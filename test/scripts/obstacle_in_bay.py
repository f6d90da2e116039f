#!/usr/bin/env python3
"""An obstacle leaves no way into the bay: the goal ends with FAILED_TO_STAGE, the chair stands and has touched
nothing."""

import sys

import rospy
import rostest
from seater_test.harness import DockingCase
from std_msgs.msg import UInt32

from seater_msgs.msg import DockResult


class ObstacleInBay(DockingCase):
    def test_gives_up_standing(self) -> None:
        collisions: list[int] = []
        rospy.Subscriber("collisions", UInt32, lambda message: collisions.append(message.data), queue_size=100)
        self.wait(lambda: bool(collisions), "the simulator's collisions")
        self.start()
        result = self.result()
        self.assertEqual(result.result_code, DockResult.FAILED_TO_STAGE, result.result_text)
        self.assertFalse(result.success)
        self.assert_standing()
        self.assertEqual(collisions, [0])


if __name__ == "__main__":
    rostest.rosrun("seater_test", "obstacle_in_bay", ObstacleInBay, sys.argv)
