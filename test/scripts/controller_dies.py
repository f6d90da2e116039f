#!/usr/bin/env python3
"""The docking node is killed while the chair drives: the safety gate brings the chair to a stand."""

import os
import signal
import sys
from xmlrpc.client import ServerProxy

import rosgraph
import rosnode
import rostest
from seater_test.harness import DockingCase


class ControllerDies(DockingCase):
    def test_the_gate_stops_the_chair(self) -> None:
        self.start()
        self.wait(lambda: bool(self.truth) and self.truth[-1][4] > 0.1, "the chair to drive")
        uri = rosnode.get_api_uri(rosgraph.Master("/test"), "/docking")
        process = int(ServerProxy(uri).getPid("/test")[2])
        os.kill(process, signal.SIGKILL)
        self.wait(lambda: self.commands[-1][1:] == (0.0, 0.0), "a zero command")
        self.let_pass(1.5)
        self.assert_standing()


if __name__ == "__main__":
    rostest.rosrun("seater_test", "controller_dies", ControllerDies, sys.argv)
