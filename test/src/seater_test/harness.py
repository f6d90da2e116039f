"""A docking in the simulation under test: follows it, remembers what everyone said.

The launch file starts the simulation paused; `DockingCase.start` sends the goal and lets time run, so a test always
sees the same run. All waiting is in wall time with generous limits; what is asserted is in simulated time.
"""

from __future__ import annotations

import math
import unittest
from collections.abc import Callable
from typing import Any

import numpy as np
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from seater_common.geometry import Chair, Dock, polygon_distance
from seater_common.params import load
from seater_eval.docking.recording import heading_of
from seater_eval.ros.dock_client import DockClient, wait_until
from seater_msgs.msg import DockResult

LARGEST_DISTANCE = 0.010  # [m]
LARGEST_HEADING = math.radians(1.0)
PATIENCE = 200.0  # [s] wall time; a loaded machine may take long


class DockingCase(unittest.TestCase):
    """One test class per launch file; the nodes are those of sim.launch."""

    simulator = "/sim"  # the node that knows how chair and dock really are

    def setUp(self) -> None:
        self.client = DockClient(lambda: not rospy.is_shutdown())
        self.client.connect(timeout=120.0)
        self.dock = load(Dock, rospy.get_param(f"{self.simulator}/dock"), f"{self.simulator}/dock")
        self.chair = load(Chair, rospy.get_param(f"{self.simulator}/chair"), f"{self.simulator}/chair")
        self.truth: list[list[float]] = []  # time, x, y, heading, v, omega in the true dock frame
        self.commands: list[tuple[float, float, float]] = []  # time, v, omega to the motors
        rospy.Subscriber("ground_truth", Odometry, self._on_truth, queue_size=1000)
        rospy.Subscriber("cmd_vel", Twist, self._on_command, queue_size=1000)
        self.wait(lambda: bool(self.truth) or rospy.get_time() > 0, "the simulator")

    def wait(self, condition: Callable[[], bool], what: str, timeout: float = PATIENCE) -> None:
        wait_until(condition, what, lambda: not rospy.is_shutdown(), timeout)

    def start(self) -> None:
        self.client.start(timeout=120.0)

    def result(self) -> DockResult:
        """Waits for the end of the docking, and a second of simulated time more."""
        self.wait(self.client.done, "the dock action's result")
        self.let_pass(1.0)
        result = self.client.result()
        self.assertIsNotNone(result)
        return result

    def let_pass(self, duration: float) -> None:
        """Simulated time [s]."""
        end = rospy.get_time() + duration
        self.wait(lambda: rospy.get_time() >= end, f"{duration} s of simulated time")

    def assert_standing(self) -> None:
        """The last command is zero and the chair does not move."""
        self.assertTrue(self.commands, "nothing was ever sent to the motors")
        _, v, omega = self.commands[-1]
        self.assertEqual((v, omega), (0.0, 0.0), "the last command is not zero")
        self.assertLess(abs(self.truth[-1][4]), 1e-3)
        self.assertLess(abs(self.truth[-1][5]), 1e-3)

    def assert_commands_within_limits(self) -> None:
        limits = self.chair.limits
        commands = np.array(self.commands)
        self.assertTrue(np.all(np.isfinite(commands)))
        self.assertLessEqual(np.max(commands[:, 1]), limits.v_max + 1e-9)
        self.assertGreaterEqual(np.min(commands[:, 1]), -limits.v_reverse_max - 1e-9)
        self.assertLessEqual(np.max(np.abs(commands[:, 2])), limits.omega_max + 1e-9)

    def final_error(self) -> tuple[float, float]:
        """True distance [m] and heading error [rad]."""
        x, y, heading = self.dock.docking_error(self.truth[-1][1:4])
        return math.hypot(x, y), abs(heading)

    def assert_docked_beside(self, outline: np.ndarray, retries: int, collisions: list[int]) -> None:
        """Truly within 10 mm and 1 deg, and nothing was touched on the way, least of all the `outline` (n, 2) [m]."""
        distance, heading = self.final_error()
        nearest = min(self.distance(row[1:4], outline) for row in self.truth)
        text = "true final error %.2f mm, %.3f deg, nearest to the obstacle %.3f m, %d retries"
        rospy.loginfo(text, 1e3 * distance, math.degrees(heading), nearest, retries)
        self.assertLessEqual(distance, LARGEST_DISTANCE)
        self.assertLessEqual(heading, LARGEST_HEADING)
        self.assertGreater(nearest, 0.0, "the chair touched the obstacle")
        self.assertEqual(collisions, [0])

    def distance(self, pose: list[float] | np.ndarray, outline: np.ndarray) -> float:
        """Between the chair there and an outline [m]; negative: it is touched."""
        return polygon_distance(self.chair.corners_at(pose), outline)

    def _on_truth(self, message: Odometry) -> None:
        pose, twist = message.pose.pose, message.twist.twist
        heading = heading_of(pose.orientation)
        stamp = message.header.stamp.to_sec()
        self.truth.append([stamp, pose.position.x, pose.position.y, heading, twist.linear.x, twist.angular.z])

    def _on_command(self, message: Twist) -> None:
        self.commands.append((rospy.get_time(), message.linear.x, message.angular.z))


def travelled(truth: list[list[float]], since: float) -> Any:
    """Driven way [m] after a time, cumulative: arrays of time and way."""
    driven = np.array([row for row in truth if row[0] >= since])
    steps = np.linalg.norm(np.diff(driven[:, 1:3], axis=0), axis=1)
    return driven[:, 0], np.concatenate([[0.0], np.cumsum(steps)])
