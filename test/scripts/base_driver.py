#!/usr/bin/env python3
"""The base driver as a node, with a simulated base behind a pseudo-terminal: it drives, stops when nobody commands, and
takes the power when motor_enable falls silent or the node is killed; it tells the charging contact. Joystick and
emergency stop as nodes, with nothing plugged in: let go, and pressed."""

import itertools
import subprocess
import sys
import time
import unittest
from collections.abc import Callable
from pathlib import Path

import rospkg
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage

from seater_base.firmware import Firmware, SimulatedBase
from seater_base.settings import BaseSettings, WheelSettings
from seater_common.params import load, read_yaml

CONFIG = Path(rospkg.RosPack().get_path("seater_config"))
SILENCE = 0.3  # [s], and as much again for a loaded machine


def wait(condition: Callable[[], bool], seconds: float = 30.0) -> bool:
    deadline = time.monotonic() + seconds
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.01)
    return condition()


class BaseDriver(unittest.TestCase):
    def start_base(self) -> None:
        values = read_yaml(CONFIG / "base.yaml")
        wheels: WheelSettings = load(BaseSettings, values, "base").wheels
        self.firmware = Firmware(wheels)
        self.base = SimulatedBase(self.firmware)
        self.addCleanup(self.base.close)
        rospy.set_param("/base/base", values)
        rospy.set_param("/base/port", self.base.path)
        rospy.set_param("/base/charging", True)
        self.contacts: list[bool] = []
        rospy.Subscriber("charging_contact", Bool, lambda m: self.contacts.append(m.data), queue_size=10)
        self.node = subprocess.Popen(["rosrun", "seater_base", "base_driver", "__name:=base"])
        self.addCleanup(self.node.wait)
        self.addCleanup(self.node.terminate)
        self.odometry: list[Odometry] = []
        self.said: list[str] = []
        self.transforms: list[TFMessage] = []
        rospy.Subscriber("odom", Odometry, self.odometry.append, queue_size=100)
        rospy.Subscriber("/tf", TFMessage, self.transforms.append, queue_size=100)
        rospy.Subscriber(
            "/diagnostics", DiagnosticArray, lambda m: self.said.extend(s.message for s in m.status), queue_size=100
        )
        self.command = rospy.Publisher("cmd_vel", Twist, queue_size=1)
        self.enable = rospy.Publisher("motor_enable", Bool, queue_size=1)

    @property
    def speed(self) -> float:
        return max(abs(speed) for speed in self.firmware.speeds)

    def drive(self) -> None:
        """From zero until it has the speed that it is told."""
        self.tell(0.2, v=0.0)
        self.tell(20.0, until=lambda: self.speed > 0.199)
        self.assertAlmostEqual(self.speed, 0.2, delta=1e-3)

    def tell(
        self,
        seconds: float,
        *,
        v: float = 0.2,
        command: bool = True,
        enable: bool = True,
        until: Callable[[], bool] = lambda: False,
    ) -> None:
        message = Twist()
        message.linear.x = v
        end = time.monotonic() + seconds
        while time.monotonic() < end and not until():
            if command:
                self.command.publish(message)
            if enable:
                self.enable.publish(Bool(True))
            time.sleep(0.02)

    def test_the_contract(self) -> None:
        self.start_base()
        self.assertTrue(wait(lambda: bool(self.odometry)), "no odometry")
        self.assertTrue(wait(lambda: self.command.get_num_connections() > 0 and self.enable.get_num_connections() > 0))
        self.drive()
        self.tell(10.0, until=lambda: "drives as it is told" in self.said)
        self.tell(2.0 * SILENCE + 0.2, command=False)
        self.assertEqual(self.speed, 0.0)
        self.assertTrue(self.firmware.power)
        self.drive()
        self.tell(2.0 * SILENCE + 0.2, enable=False)
        self.assertEqual((self.speed, self.firmware.power), (0.0, False))
        self.assertEqual(self.contacts, [False])
        self.firmware.contact = True
        self.assertTrue(wait(lambda: self.contacts == [False, True]), self.contacts)
        self.firmware.contact, self.firmware.charging = False, True  # a base that has a word about its current alone
        time.sleep(0.2)
        self.firmware.charging = False
        self.assertTrue(wait(lambda: self.contacts == [False, True, False]), self.contacts)
        self.drive()
        self.node.send_signal(9)  # SIGKILL: only the base itself is left
        self.tell(2.0 * SILENCE + 0.2)
        self.assertEqual((self.speed, self.firmware.power), (0.0, False))
        stamps = [message.header.stamp for message in self.odometry]
        self.assertTrue(all(a < b for a, b in itertools.pairwise(stamps)))
        last = self.odometry[-1]
        self.assertEqual((last.header.frame_id, last.child_frame_id), ("odom", "base_link"))
        self.assertGreater(last.pose.pose.position.x, 0.1)
        self.assertGreater(last.pose.covariance[0], 0.0)
        self.assertTrue(any(t.transforms[0].child_frame_id == "base_link" for t in self.transforms))
        self.assertIn("drives as it is told", self.said)

    def test_controls_with_nothing_plugged_in(self) -> None:
        joystick = {**read_yaml(CONFIG / "joystick.yaml"), "device": "/dev/input/no_such_joystick"}
        rospy.set_param("/joystick/joystick", joystick)
        rospy.set_param("/joystick/hold", True)
        contact = {**read_yaml(CONFIG / "emergency_stop.yaml"), "chip": "no_such_chip"}
        rospy.set_param("/emergency_stop_contact/emergency_stop", contact)
        told: dict[str, list[object]] = {"user_cmd_vel": [], "hold_to_run": [], "emergency_stop": []}
        said: dict[str, str] = {}
        for topic, kind in (("user_cmd_vel", Twist), ("hold_to_run", Bool), ("emergency_stop", Bool)):
            rospy.Subscriber(topic, kind, told[topic].append, queue_size=100)
        rospy.Subscriber(
            "/diagnostics",
            DiagnosticArray,
            lambda m: said.update((s.name, s.message) for s in m.status),
            queue_size=100,
        )
        for node, name in (("joystick", "joystick"), ("emergency_stop", "emergency_stop_contact")):
            process = subprocess.Popen(["rosrun", "seater_controls", node, f"__name:={name}"])
            self.addCleanup(process.wait)
            self.addCleanup(process.terminate)
        self.assertTrue(wait(lambda: min(map(len, told.values())) > 20 and len(said) >= 2), (told, said))
        self.assertEqual({(m.linear.x, m.angular.z) for m in told["user_cmd_vel"]}, {(0.0, 0.0)})
        self.assertEqual({m.data for m in told["hold_to_run"]}, {False})
        self.assertEqual({m.data for m in told["emergency_stop"]}, {True})
        self.assertIn("plugged in", said["joystick: joystick"])
        self.assertIn("pressed: no_such_chip", said["emergency_stop_contact: emergency stop"])


if __name__ == "__main__":
    rospy.init_node("base_driver_test")
    rostest.rosrun("seater_test", "base_driver", BaseDriver, sys.argv)
