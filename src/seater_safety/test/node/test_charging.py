"""With charging_inhibit the gate's node listens to the charging contact, and to what a goal says of itself."""

from __future__ import annotations

import subprocess

import rospy
from driver import Driver, start_gate, wait_until
from std_msgs.msg import Bool

from seater_msgs.msg import GateState
from seater_msgs.srv import GateArm


def test_while_charging_only_undocking_gets_the_consent(driver: Driver, own_gate: subprocess.Popen[str]) -> None:
    driver.stop(own_gate)
    gate = start_gate(charging_inhibit=1)
    driver.connect()
    contact = rospy.Publisher("charging_contact", Bool, queue_size=1, latch=True)
    contact.publish(True)
    wait_until(lambda: driver.state.state == GateState.CHARGING, "the contact to be heard")
    refusal = driver.arm()
    assert not refusal.granted and refusal.state == GateState.CHARGING and "undock first" in refusal.reason
    driver.deflect(0.2)
    wait_until(lambda: driver.state.user_age >= 0.0, "the joystick to be heard")
    assert driver.speed == 0.0
    assert not rospy.ServiceProxy("gate_arm", GateArm)(undock=True).granted, "the joystick is deflected"
    driver.deflect(0.0)
    wait_until(lambda: rospy.ServiceProxy("gate_arm", GateArm)(undock=True).granted, "the consent", 3.0)
    driver.velocity = (-0.1, 0.0)
    wait_until(lambda: driver.speed < -0.09, "the chair to back out")
    contact.publish(False)
    driver.velocity = None
    driver.stop(gate)
    contact.unregister()
