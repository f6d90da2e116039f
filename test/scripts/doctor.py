#!/usr/bin/env python3
"""`seater doctor --move` on a running system: nothing moves without a yes; a camera that sits elsewhere is named."""

import json
import subprocess
import sys
import unittest

import numpy as np
import rospy
import rostest
from nav_msgs.msg import Odometry
from seater_test.stalls import Stalls

FORWARD = 0.12  # [m] of the drive, which takes 20 s


def doctor(answer: str, *words: str) -> tuple[int, dict[str, dict[str, str]]]:
    """Exit status and checks by name, as a person types it."""
    command = ["rosrun", "seater_tools", "doctor", "--json", "--seconds", "2", *words]
    done = subprocess.run(command, input=answer, capture_output=True, text=True, timeout=90.0)
    if not done.stdout:
        raise AssertionError(done.stderr)
    return done.returncode, {check["name"]: check for check in json.loads(done.stdout)["checks"]}


class Doctor(unittest.TestCase):
    def setUp(self) -> None:
        self.poses: list[tuple[float, float]] = []
        self.stalls = Stalls()
        rospy.Subscriber("odom", Odometry, self._on_odometry)
        rospy.wait_for_message("detections", rospy.AnyMsg, timeout=60.0)
        rospy.wait_for_message("gate_state", rospy.AnyMsg, timeout=60.0)

    def _on_odometry(self, message: Odometry) -> None:
        self.stalls.heard()
        place = message.pose.pose.position
        self.poses.append((place.x, place.y))

    def farthest(self) -> float:
        """[m] from where the chair began its last drive."""
        rows = np.array(self.poses)
        return float(np.linalg.norm(rows - rows[0], axis=1).max())

    def test_asks_first_and_names_the_mount(self) -> None:
        _, standing = doctor("no\n", "--move")
        self.assertLess(self.farthest(), 0.002)
        self.assertEqual(standing["camera mount"]["result"], "not judged")
        # A busy test machine is told to be busy.
        self.assertLessEqual({n for n, c in standing.items() if c["result"] == "wrong"}, {"processor"}, standing)

        status, moved = self.stalls.undisturbed(self.drive, lambda said: said[1]["command path"]["result"] == "ok")
        self.assertGreater(self.farthest(), 0.8 * FORWARD)
        self.assertLess(np.linalg.norm(np.subtract(self.poses[-1], self.poses[0])), 0.06)
        self.assertEqual(status, 1)
        self.assertEqual(moved["command path"]["result"], "ok", moved)
        self.assertEqual(moved["camera mount"]["result"], "wrong", moved)
        self.assertIn("x of chair.yaml", moved["camera mount"]["what"])

    def drive(self) -> tuple[int, dict[str, dict[str, str]]]:
        self.poses.clear()
        return doctor("yes\n", "--move", "--way", str(FORWARD), "--turn", "15")


if __name__ == "__main__":
    rospy.init_node("doctor_tester")
    rostest.rosrun("seater_test", "doctor_move", Doctor, sys.argv)
