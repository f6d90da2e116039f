"""The node round the contacts: emergency_stop out."""

from __future__ import annotations

import rospy
from std_msgs.msg import Bool

from seater_common.params import load
from seater_controls.contact.watch import Watch
from seater_controls.ros.diagnostics import ERROR, OK, WARN, Entry
from seater_controls.settings import ContactSettings


class EmergencyStopNode:
    """Private parameter: ~emergency_stop (config/emergency_stop.yaml). Its pace is that of the clock on the wall."""

    def __init__(self) -> None:
        """Raises ParameterError, naming the key."""
        values = rospy.get_param("~emergency_stop", None)
        settings = load(ContactSettings, values, rospy.resolve_name("~emergency_stop"))
        self._publisher = rospy.Publisher("emergency_stop", Bool, queue_size=1, tcp_nodelay=True)
        self._watch = Watch(settings, self._tell)
        self._diagnostics = Entry("emergency stop", settings.chip, self._state)

    def run(self) -> None:
        """Until ROS shuts down, or its thread has failed."""
        self._watch.start()
        try:
            while not rospy.is_shutdown() and self._watch.alive:
                self._diagnostics.update()
                rospy.rostime.wallsleep(0.1)
        finally:
            self._watch.stop()

    def _tell(self, pressed: bool) -> None:
        try:
            self._publisher.publish(pressed)
        except rospy.ROSException:  # it is closed already: silence is pressed
            return

    def _state(self) -> tuple[int, str]:
        why = self._watch.why
        return (OK, "released") if not why else (WARN if why.endswith("open") else ERROR, f"pressed: {why}")
