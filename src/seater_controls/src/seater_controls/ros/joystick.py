"""The node round the joystick: user_cmd_vel and, where it is asked for, hold_to_run out."""

from __future__ import annotations

import time

import rospy
from geometry_msgs.msg import Twist
from std_msgs.msg import Bool

from seater_common.params import load
from seater_controls.joystick.reader import Reader
from seater_controls.joystick.stick import Wish
from seater_controls.ros.diagnostics import ERROR, OK, Entry
from seater_controls.settings import JoystickSettings

_ZEROS = 3  # messages at the end


class JoystickNode:
    """Private parameters: ~joystick (config/joystick.yaml), ~hold (bool: publish hold_to_run). Its pace is that of the
    clock on the wall."""

    def __init__(self) -> None:
        """Raises ParameterError, naming the key."""
        settings = load(JoystickSettings, rospy.get_param("~joystick", None), rospy.resolve_name("~joystick"))
        self._period = 1.0 / settings.rate
        self._velocity = rospy.Publisher("user_cmd_vel", Twist, queue_size=1, tcp_nodelay=True)
        hold = bool(rospy.get_param("~hold", False))
        self._hold = rospy.Publisher("hold_to_run", Bool, queue_size=1, tcp_nodelay=True) if hold else None
        self._reader = Reader(settings)
        self._diagnostics = Entry("joystick", settings.device or "joystick", self._state)

    def run(self) -> None:
        """Until ROS shuts down, or its thread has ended: neutral then."""
        self._reader.start()
        try:
            while not rospy.is_shutdown() and self._reader.alive:
                self._tell(self._reader.wish())
                self._diagnostics.update()
                time.sleep(self._period)
        finally:
            for _ in range(_ZEROS):
                self._tell(Wish(0.0, 0.0, False, "the node ends"))
            self._reader.stop()

    def _tell(self, wish: Wish) -> None:
        message = Twist()
        message.linear.x, message.angular.z = wish.v, wish.omega
        try:
            self._velocity.publish(message)
            if self._hold is not None:
                self._hold.publish(wish.hold)
        except rospy.ROSException:  # the publishers are closed already: silence is let go
            return

    def _state(self) -> tuple[int, str]:
        wish = self._reader.wish()
        return (OK if self._reader.name else ERROR), wish.why or f"{self._reader.name} drives"
