#!/usr/bin/env python3
"""Docks round an obstacle beside the straight way; the TRUE final error is small, nothing was touched, the chair
stands."""

import sys

import numpy as np
import rospy
import rostest
from seater_test.harness import DockingCase
from std_msgs.msg import UInt32

from seater_msgs.msg import DockResult


class ObstacleAvoided(DockingCase):
    def test_docks_round_the_obstacle(self) -> None:
        collisions: list[int] = []
        rospy.Subscriber("collisions", UInt32, lambda message: collisions.append(message.data), queue_size=100)
        self.wait(lambda: bool(collisions), "the simulator's collisions")
        (obstacle,) = rospy.get_param("/sim/simulator/obstacles")
        outline = np.array(obstacle["outline"]).reshape(-1, 2)
        self.start()
        start = np.array(self.truth[-1][1:4])
        straight = [
            start + fraction * ([self.dock.predock_x, 0.0, 0.0] - start) for fraction in np.linspace(0.0, 1.0, 50)
        ]
        self.assertLess(min(self.distance(pose, outline) for pose in straight), 0.0, "the straight way is free already")
        result = self.result()
        self.assertEqual(result.result_code, DockResult.SUCCESS, result.result_text)
        self.assert_docked_beside(outline, result.num_retries, collisions)
        self.assert_standing()
        self.assert_commands_within_limits()


if __name__ == "__main__":
    rostest.rosrun("seater_test", "obstacle_avoided", ObstacleAvoided, sys.argv)
