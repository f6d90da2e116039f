#!/usr/bin/env python3
"""The goal is cancelled while the chair drives: it stands, and stays standing."""

import sys

import rostest
from seater_test.harness import DockingCase

from seater_msgs.msg import DockResult


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


if __name__ == "__main__":
    rostest.rosrun("seater_test", "cancel", Cancel, sys.argv)
