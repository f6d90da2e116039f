#!/usr/bin/env python3
"""Docks round an obstacle that nobody told and behind somebody who walks across: both were seen, neither touched."""

import sys

import numpy as np
import rospy
import rostest
from seater_test.harness import DockingCase
from std_msgs.msg import UInt32

from seater_msgs.msg import DockResult, ObstacleArray, ObstaclePoints


class ObstacleSeen(DockingCase):
    def test_docks_round_what_it_sees(self) -> None:
        collisions: list[int] = []
        points: list[ObstaclePoints] = []
        outlines: list[ObstacleArray] = []
        rospy.Subscriber("collisions", UInt32, lambda message: collisions.append(message.data), queue_size=100)
        rospy.Subscriber("obstacle_points", ObstaclePoints, points.append, queue_size=1000)
        rospy.Subscriber("obstacles", ObstacleArray, outlines.append, queue_size=1000)
        self.wait(lambda: bool(collisions), "the simulator's collisions")
        (obstacle,) = rospy.get_param("/sim/obstacles")
        outline = np.array(obstacle["outline"]).reshape(-1, 2)
        self.start()
        result = self.result()
        self.assertEqual(result.result_code, DockResult.SUCCESS, result.result_text)
        self.assert_docked_beside(outline, result.num_retries, collisions)
        self.assertFalse([message.blocked for message in points if message.blocked])
        self.assertTrue(all(message.header.frame_id == "odom" for message in outlines))
        inside = [(x, y) for x, y in zip(points[-1].x, points[-1].y, strict=True) if abs(y) < 0.55 and -0.3 < x < 0.95]
        self.assertFalse(inside, "the docked chair takes the dock for an obstacle")
        self.assert_standing()
        self.assert_commands_within_limits()


if __name__ == "__main__":
    rostest.rosrun("seater_test", "obstacle_seen", ObstacleSeen, sys.argv)
