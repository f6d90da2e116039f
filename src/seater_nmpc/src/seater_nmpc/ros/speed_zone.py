"""Tells the safety gate where the chair has to be slow, so that the bay's limit holds for the joystick too."""

from __future__ import annotations

import rospy
from numpy.typing import ArrayLike

from seater_common.geometry import Chair, Dock
from seater_common.se2 import relative
from seater_msgs.msg import SpeedLimit
from seater_nmpc.control.limits import in_bay

PERIOD = 0.5  # [s] of message time between two messages; the gate forgets after two seconds


class SpeedZone:
    """Publishes `speed_limit` while the place of the dock is known."""

    def __init__(self, chair: Chair, dock: Dock) -> None:
        """`chair`: as the core drives it."""
        self._chair, self._bay = chair, dock.bay
        self._publisher = rospy.Publisher("speed_limit", SpeedLimit, queue_size=10, latch=True)
        self._last: tuple[float, bool] | None = None  # time [s] of the last message, and whether it said slow

    def update(self, stamp: rospy.Time, dock: ArrayLike, base: ArrayLike) -> None:
        """Once per control cycle in which both are known; `dock` and `base`: (x, y, heading) in odom [m, rad]."""
        now, slow = stamp.to_sec(), in_bay(self._chair, self._bay, relative(dock, base))
        if self._last is not None and slow == self._last[1] and 0.0 <= now - self._last[0] < PERIOD:
            return
        self._last = (now, slow)
        limits = self._chair.limits
        message = SpeedLimit()
        message.header.stamp = stamp
        message.v_max = limits.v_bay_max if slow else max(limits.v_max, limits.v_reverse_max)
        message.reason = "in the bay" if slow else "outside the bay"
        self._publisher.publish(message)
