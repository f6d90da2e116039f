#!/usr/bin/env python3
"""The docked pose is taught where the simulated chair truly stands; only once; and the check tells the difference."""

import sys
import time
import unittest
from pathlib import Path

import numpy as np
import rospkg
import rospy
import rostest
from std_srvs.srv import Trigger, TriggerResponse

from seater_common.geometry import Dock
from seater_common.params import load, read_yaml
from seater_common.se2 import inverse, transform_points, wrap_angle

PATIENCE = 60.0  # [s] wall time until the standing chair has been seen often enough


class Teach(unittest.TestCase):
    def setUp(self) -> None:
        self.output = Path(rospy.get_param("~output"))
        self.addCleanup(lambda: self.output.unlink(missing_ok=True))
        self.planned = Path(rospkg.RosPack().get_path("seater_config")) / "docks" / "default.yaml"

    def call(self, service: str) -> TriggerResponse:
        rospy.wait_for_service(service, timeout=PATIENCE)
        return rospy.ServiceProxy(service, Trigger)()

    def test_the_standing_chair_is_taught(self) -> None:
        answer, end = self.call("teach/confirm"), time.monotonic() + PATIENCE
        while not answer.success and time.monotonic() < end:  # it has to stand for a while first
            self.assertFalse(self.output.exists())
            time.sleep(0.5)
            answer = self.call("teach/confirm")
        self.assertTrue(answer.success, answer.message)
        old = load(Dock, read_yaml(self.planned), "planned")
        new = load(Dock, read_yaml(self.output), "taught")
        stands = np.array(rospy.get_param("~stands"))
        for before, after in zip(old.markers, new.markers, strict=True):
            expected = transform_points(inverse(stands), np.array([before.position[:2]]))[0]
            # The chair is 0.45 m in front of the prints: perception is right to some tenths of a millimetre.
            self.assertLess(np.linalg.norm(np.array(after.position[:2]) - expected), 0.0015)
            self.assertLess(abs(wrap_angle(after.normal_yaw - before.normal_yaw + stands[2])), 0.0015)

        again = self.call("teach/confirm")
        self.assertFalse(again.success)
        self.assertIn("it is taught", again.message)

        check = self.call("teach/check")  # by the planned file, which perception still has: 13 mm off
        self.assertFalse(check.success)
        self.assertIn("not docked", check.message)


if __name__ == "__main__":
    rospy.init_node("teach_test")
    rostest.rosrun("seater_test", "teach_docked_pose", Teach, sys.argv)
