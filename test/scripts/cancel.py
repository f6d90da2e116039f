#!/usr/bin/env python3
"""The goal is cancelled while the chair drives: it stands, and stays standing. Then live parameters, by Debian's client
of dynamic_reconfigure: between two goals, and in the middle of one. Then by commands as a person types them."""

import subprocess
import sys
from subprocess import DEVNULL, PIPE
from typing import Any

import rospy
import rostest
from dynamic_reconfigure.client import Client
from seater_test.harness import DockingCase

from seater_msgs.msg import DockActionResult, DockResult


class Cancel(DockingCase):
    def test_cancel_ends_in_zero_velocity(self) -> None:
        self.start()
        self.wait(lambda: bool(self.truth) and self.truth[-1][4] > 0.1, "the chair to drive")
        self.client.cancel()
        result = self.result()
        self.assertEqual(result.result_code, DockResult.CANCELED, result.result_text)
        self.let_pass(1.0)
        self.assert_standing()
        where = self.truth[-1][1:4]
        self.let_pass(1.0)
        self.assertEqual(where, self.truth[-1][1:4])

    def test_live_parameters(self) -> None:
        client = Client("/docking/live", timeout=60.0)
        held = client.get_configuration()  # the client's own lags behind its answers

        def ask(**changes: Any) -> str:
            """The answer; empty when they were made, and nothing has changed otherwise."""
            after = client.update_configuration(changes)
            for name, value in changes.items():
                self.assertEqual(after[name], held[name] if after["answer"] else value)
            held.update(after)
            return str(after["answer"])

        self.assertEqual(ask(hold_position=0.002, weight_speed=0.2), "")
        self.assertIn("hold_position", ask(hold_position=0.05, weight_speed=0.3))  # the dock's tolerance is 0.01
        self.start()
        self.wait(lambda: bool(self.commands) and self.commands[-1][1] > 0.2, "the chair to drive")
        self.assertIn("between two goals only", ask(hold_position=0.003))
        self.assertEqual(ask(v_max=0.1), "")
        self.assertIn("only be lowered", ask(v_max=0.5))
        self.let_pass(3.0)
        slow = [v for t, v, _ in self.commands if t > self.commands[-1][0] - 1.0]
        self.assertLess(max(slow), 0.11)
        self.assertGreater(max(slow), 0.05, "it goes on")
        self.client.cancel()
        self.assertEqual(self.result().result_code, DockResult.CANCELED)
        self.assertEqual(ask(v_max=0.6), "")
        self.assert_standing()

    def test_typed_by_a_person(self) -> None:
        """Debian's rostopic and dynparam are all that is needed; the last one in the alphabet, when the
        simulation runs."""
        results: list[DockActionResult] = []
        rospy.Subscriber("dock/result", DockActionResult, results.append)
        self.assertIn("v_max", typed("rosrun", "dynamic_reconfigure", "dynparam", "get", "docking/live"))
        told = subprocess.Popen(
            ["rostopic", "echo", "-n", "1", "/dock/result/result/result_text"], stdout=PIPE, text=True
        )
        self.addCleanup(told.kill)
        self.publish("dock/goal", "seater_msgs/DockActionGoal", "{goal: {use_dock_id: true}}")
        self.wait(lambda: bool(self.truth) and self.truth[-1][4] > 0.05, "the chair to drive")
        self.publish("dock/cancel", "actionlib_msgs/GoalID", "{}")
        self.wait(lambda: bool(results), "the result")
        self.assertEqual(results[-1].result.result_code, DockResult.CANCELED)
        self.assertIn(results[-1].result.result_text, told.communicate(timeout=60.0)[0])
        self.let_pass(1.0)
        self.assert_standing()

    def publish(self, topic: str, kind: str, message: str) -> None:
        """`rostopic pub -1`, which stays for three seconds; nobody waits for its end."""
        process = subprocess.Popen(["rostopic", "pub", "-1", topic, kind, message], stdout=DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)


def typed(*words: str) -> str:
    """What a command prints."""
    return subprocess.run(words, capture_output=True, text=True, timeout=60.0, check=True).stdout


if __name__ == "__main__":
    rostest.rosrun("seater_test", "cancel", Cancel, sys.argv)
