#!/usr/bin/env python3
"""Emergency stop and joystick end the docking with codes of their own; the chair moves again with a new goal only."""

import sys

import rospy
import rostest
from geometry_msgs.msg import Twist
from seater_test.harness import DockingCase
from std_msgs.msg import Bool

from seater_msgs.msg import DockResult, GateState


class Stops(DockingCase):
    simulator = "/plant"

    def setUp(self) -> None:
        super().setUp()
        self.emergency_stop = rospy.Publisher("emergency_stop", Bool, queue_size=1)
        self.joystick = rospy.Publisher("user_cmd_vel", Twist, queue_size=1)
        self.gate = GateState()
        rospy.Subscriber("gate_state", GateState, lambda message: setattr(self, "gate", message))
        for publisher in (self.emergency_stop, self.joystick):
            self.wait(lambda p=publisher: p.get_num_connections() > 0, "the gate to listen")

    def test_stops_by_a_person(self) -> None:
        self.press(True)
        self.client.send()
        self.ends_with(DockResult.EMERGENCY_STOP, "the emergency stop is pressed")
        self.press(False)
        self.stays()

        self.drive()
        self.press(True)
        self.ends_with(DockResult.EMERGENCY_STOP, "the emergency stop was pressed")
        self.press(False)
        self.stays()

        self.drive()
        self.deflect(-0.1)
        self.ends_with(DockResult.STOPPED_BY_USER, "the joystick was moved")
        self.deflect(0.0)
        self.stays()

        self.drive()

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

    def drive(self) -> None:
        self.client.send()
        self.wait(lambda: self.truth[-1][4] > 0.1 or self.client.done(), "the chair to drive")
        self.assertFalse(self.client.done(), "the goal has ended")

    def ends_with(self, code: int, text: str) -> None:
        result = self.result()
        self.assertEqual((result.result_code, result.result_text), (code, text))

    def stays(self) -> None:
        self.let_pass(1.0)
        self.assert_standing()
        where = self.truth[-1][1:4]
        self.let_pass(1.0)
        self.assertEqual(where, self.truth[-1][1:4])
        self.assert_standing()


if __name__ == "__main__":
    rostest.rosrun("seater_test", "stops", Stops, sys.argv)
