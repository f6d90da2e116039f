"""The node round the driver: cmd_vel and motor_enable in, odom and its transform out."""

from __future__ import annotations

import time

import diagnostic_updater
import numpy as np
import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from seater_base.deflection.inverse import Deflections
from seater_base.deflection.table import DeflectionTable
from seater_base.driver import Driver
from seater_base.odometry import Driven
from seater_base.protocol import Flags
from seater_base.ros.messages import odometry_message, transform_message
from seater_base.settings import BaseSettings
from seater_common.params import ParameterError, load


class BaseNode:
    """Private parameters: ~base (config/base.yaml), ~port (in place of the file's), ~odom_frame, ~base_frame,
    ~emergency_stop (bool: publish the base's own button), ~charging (bool: publish its contact), ~deflection
    (config/deflection.yaml: it is told voltages of a joystick).

    Commands, time-outs and the port need no ROS master.
    """

    def __init__(self) -> None:
        """Raises ParameterError, naming the key."""
        if rospy.get_param("/use_sim_time", False):
            raise ParameterError(
                "/use_sim_time is true: motors obey no simulated time (rosparam set use_sim_time false)"
            )
        values = rospy.get_param("~base", None)
        if rospy.has_param("~port") and isinstance(values, dict):
            values = {**values, "port": rospy.get_param("~port")}
        settings = load(BaseSettings, values, rospy.resolve_name("~base"))
        self._frames = rospy.get_param("~odom_frame", "odom"), rospy.get_param("~base_frame", "base_link")
        self._stamp = rospy.Time()
        self._odometry = rospy.Publisher("odom", Odometry, queue_size=10, tcp_nodelay=True)
        self._tf = tf2_ros.TransformBroadcaster()
        button = bool(rospy.get_param("~emergency_stop", False))
        self._button = rospy.Publisher("emergency_stop", Bool, queue_size=1, tcp_nodelay=True) if button else None
        charging = bool(rospy.get_param("~charging", False))
        self._contact = rospy.Publisher("charging_contact", Bool, queue_size=10, latch=True) if charging else None
        self._closed: bool | None = None  # as it was told last
        self._driver = Driver(settings, self._on_driven, self._on_failure, self._on_flags, _deflections())
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID(settings.port)
        self._updater.add("base", self._write)
        self._timer = rospy.Timer(rospy.Duration(1.0), lambda _: self._updater.update())
        rospy.on_shutdown(self._driver.stop)
        self._driver.start()
        rospy.Subscriber("cmd_vel", Twist, self._on_command, queue_size=1, tcp_nodelay=True)
        rospy.Subscriber("motor_enable", Bool, lambda m: self._driver.power(m.data), queue_size=1, tcp_nodelay=True)

    def _on_command(self, message: Twist) -> None:
        sender = str(message._connection_header["callerid"])
        self._driver.velocity(message.linear.x, message.angular.z, sender)

    def _on_flags(self, flags: Flags) -> None:
        if self._button is not None:
            self._button.publish(bool(flags & Flags.EMERGENCY_STOP))
        # A charger whose current flows has contact, whatever measures it.
        closed = bool(flags & (Flags.CONTACT | Flags.CHARGING))
        if self._contact is not None and self._driver.tells_charging and closed != self._closed:
            self._closed = closed
            self._contact.publish(closed)

    def _on_driven(self, driven: Driven) -> None:
        stamp = rospy.Time.from_sec(max(0.0, driven.time + rospy.Time.now().to_sec() - time.monotonic()))
        if stamp <= self._stamp:  # the host's clock was set back
            return
        self._stamp = stamp
        self._odometry.publish(odometry_message(stamp, self._frames, driven))
        self._tf.sendTransform(transform_message(stamp, self._frames, driven.pose))

    def _on_failure(self, error: Exception) -> None:
        """The node is started anew: better than half of it."""
        if not rospy.is_shutdown():
            rospy.logfatal("base driver: %s: %s", type(error).__name__, error)
            rospy.signal_shutdown("a thread of the driver has failed")

    def _write(self, status: diagnostic_updater.DiagnosticStatusWrapper) -> diagnostic_updater.DiagnosticStatusWrapper:
        driver, request = self._driver, self._driver.request
        if driver.trouble:
            status.summary(DiagnosticStatus.ERROR, driver.trouble)
        elif driver.flags & Flags.FAULT:
            status.summary(DiagnosticStatus.ERROR, "the base reports a fault of its motors")
        elif self._contact is not None and driver.identity is not None and not driver.tells_charging:
            status.summary(DiagnosticStatus.WARN, "the base speaks protocol 1: it tells nothing about the contact")
        elif driver.flags & Flags.EMERGENCY_STOP:
            status.summary(DiagnosticStatus.WARN, "the emergency stop of the base is pressed")
        else:
            status.summary(DiagnosticStatus.OK, request.why or "drives as it is told")
        status.add("base", "not known" if driver.identity is None else driver.identity.name)
        status.add("power", str(bool(driver.flags & Flags.POWER)))
        status.add("contact, charging", f"{bool(driver.flags & Flags.CONTACT)}, {bool(driver.flags & Flags.CHARGING)}")
        status.add("asked for [m/s], [rad/s]", f"{request.v:.3f}, {request.omega:.3f}")
        status.add("lines that could not be read", str(driver.damaged))
        status.add("readings that leap", str(driver.odometry.leaps))
        status.add("drift against the base's clock [ppm]", f"{1e6 * driver.odometry.clock.drift:.1f}")
        status.add("pose in odom", np.array2string(driver.odometry.pose, precision=3))
        return status


def _deflections() -> Deflections | None:
    """Raises ParameterError."""
    if not rospy.has_param("~deflection"):
        return None
    return Deflections(load(DeflectionTable, rospy.get_param("~deflection"), rospy.resolve_name("~deflection")))
