#!/usr/bin/env python3
"""Docks from the start of the launch file; the TRUE final error is small, nothing was touched, the chair stands."""

import math
import sys
import time
from pathlib import Path

import rospy
import rostest
import yaml
from seater_test.harness import DockingCase

from seater_common.geometry import clearance
from seater_msgs.msg import DockResult
from seater_nmpc.control.limits import in_bay

LARGEST_DISTANCE = 0.010  # [m]
LARGEST_HEADING = math.radians(1.0)


class DockOutOfPixels(DockingCase):
    def test_docks(self) -> None:
        self.start()
        result = self.result()
        self.assertEqual(result.result_code, DockResult.SUCCESS, result.result_text)
        self.assertTrue(result.success and result.contact)
        distance, heading = self.final_error()
        rospy.loginfo("true final error %.2f mm, %.3f deg", 1e3 * distance, math.degrees(heading))
        self.assertLessEqual(distance, LARGEST_DISTANCE)
        self.assertLessEqual(heading, LARGEST_HEADING)
        self.assert_standing()
        self.assert_commands_within_limits()
        smallest = min(clearance(self.chair, self.dock.bay, row[1:4]) for row in self.truth)
        self.assertGreater(smallest, 0.0, "the chair touched a wall")
        self.assert_slow_inside_the_bay()
        if rospy.has_param("~memory"):
            self.assert_remembered(Path(rospy.get_param("~memory")))

    def assert_remembered(self, path: Path) -> None:
        """What the docking has shown of the installation is written once its result is out."""
        end = time.monotonic() + 10.0
        while not path.exists() and time.monotonic() < end:
            time.sleep(0.05)
        docks = yaml.safe_load(path.read_text())
        path.unlink()
        self.assertEqual([dock["dockings"] for dock in docks.values()], [1])

    def assert_slow_inside_the_bay(self) -> None:
        inside = [row for row in self.truth if in_bay(self.chair, self.dock.bay, row[1:4])]
        self.assertTrue(inside, "the chair never reached the bay")
        # 0.01 m/s for the lag between the command and the motors.
        self.assertLessEqual(max(abs(row[4]) for row in inside), self.chair.limits.v_bay_max + 0.01)


if __name__ == "__main__":
    rostest.rosrun("seater_test", "dock_out_of_pixels", DockOutOfPixels, sys.argv)
