#!/usr/bin/env python3
"""Emergency stop and joystick end the docking with codes of their own; the chair moves again with a new goal only."""

import sys
from collections.abc import Callable

import rospy
import rostest
from geometry_msgs.msg import Twist
from seater_test.harness import DockingCase
from seater_test.stalls import Stalls
from std_msgs.msg import Bool

from seater_msgs.msg import DockResult, GateState


class Stops(DockingCase):
    simulator = "/plant"

    def setUp(self) -> None:
        super().setUp()
        self.emergency_stop = rospy.Publisher("emergency_stop", Bool, queue_size=1)
        self.joystick = rospy.Publisher("user_cmd_vel", Twist, queue_size=1)
        self.gate = GateState()
        self.stalls = Stalls()
        rospy.Subscriber("ground_truth", rospy.AnyMsg, self.stalls.heard)
        rospy.Subscriber("gate_state", GateState, lambda message: setattr(self, "gate", message))
        for publisher in (self.emergency_stop, self.joystick):
            self.wait(lambda p=publisher: p.get_num_connections() > 0, "the gate to listen")

    def test_stops_by_a_person(self) -> None:
        self.press(True)
        self.client.send()
        result = self.result()
        self.assertEqual(
            (result.result_code, result.result_text), (DockResult.EMERGENCY_STOP, "the emergency stop is pressed")
        )
        self.press(False)
        self.stays()

        driving = (lambda: self.press(True), lambda: self.press(False))
        self.ends_with(DockResult.EMERGENCY_STOP, "the emergency stop was pressed", *driving)
        driving = (lambda: self.deflect(-0.1), lambda: self.deflect(0.0))
        self.ends_with(DockResult.STOPPED_BY_USER, "the joystick was moved", *driving)
        self.assertTrue(self.stalls.undisturbed(self.drives, bool), "the goal has ended")

    def press(self, pressed: bool) -> None:
        """Again and again, as a driver does: others that listen may be connected before the gate."""

        def noticed() -> bool:
            self.emergency_stop.publish(pressed)
            return self.gate.emergency_stop is pressed

        self.wait(noticed, "the gate to notice")

    def deflect(self, speed: float) -> None:
        message = Twist()
        message.linear.x = speed
        self.joystick.publish(message)

    def drives(self) -> bool:
        """Whether a new goal makes the chair drive."""
        self.client.send()
        self.wait(lambda: self.truth[-1][4] > 0.1 or self.client.done(), "the chair to drive")
        return not self.client.done()

    def ends_with(self, code: int, text: str, stop: Callable[[], None], release: Callable[[], None]) -> None:
        """A stop while the chair drives ends the docking so, and it stays ended when the stop is over."""

        def docking() -> tuple[int, str]:
            if self.drives():
                stop()
            result = self.result()
            release()
            self.stays()
            return result.result_code, result.result_text

        self.assertEqual(self.stalls.undisturbed(docking, lambda result: result == (code, text)), (code, text))

    def stays(self) -> None:
        self.let_pass(1.0)
        self.assert_standing()
        where = self.truth[-1][1:4]
        self.let_pass(1.0)
        self.assertEqual(where, self.truth[-1][1:4])
        self.assert_standing()


if __name__ == "__main__":
    rostest.rosrun("seater_test", "stops", Stops, sys.argv)
