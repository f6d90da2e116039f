"""Tells the safety gate where the chair has to be slow, so that the limits of the bay and of backing out are hard."""

from __future__ import annotations

import rospy
from numpy.typing import ArrayLike

from seater_common.geometry import Chair, Dock
from seater_common.se2 import relative
from seater_msgs.msg import SpeedLimit
from seater_nmpc.control.limits import in_bay

PERIOD = 0.5  # [s] of message time between two messages; the gate forgets after two seconds


class SpeedZone:
    """Publishes `speed_limit` while the place of the dock is known, or the chair backs out."""

    def __init__(self, chair: Chair, dock: Dock, back_out_speed: float) -> None:
        """`chair`: as the core drives it. `back_out_speed` [m/s]: largest speed while it backs out."""
        self._back_out_speed = back_out_speed
        self.use(chair, dock)
        self._publisher = rospy.Publisher("speed_limit", SpeedLimit, queue_size=10, latch=True)
        self._backed_out = False  # in the last cycle
        self._last: tuple[float, float] | None = None  # time [s] and limit [m/s] of the last message

    def use(self, chair: Chair, dock: Dock) -> None:
        """Another dock is looked for from now on."""
        self._chair, self._bay = chair, dock.bay

    def update(self, stamp: rospy.Time, dock: ArrayLike | None, base: ArrayLike, *, backs_out: bool) -> None:
        """Once per control cycle; `dock` (None: not known) and `base`: (x, y, heading) in odom [m, rad]."""
        backed_out, self._backed_out = self._backed_out, backs_out
        if dock is None and not backs_out and not backed_out:  # the end of backing out is told all the same
            return
        v_max, reason = self._limit(dock, base, backs_out)
        now = stamp.to_sec()
        if self._last is not None and v_max == self._last[1] and 0.0 <= now - self._last[0] < PERIOD:
            return
        self._last = (now, v_max)
        message = SpeedLimit(v_max=v_max, reason=reason)
        message.header.stamp = stamp
        self._publisher.publish(message)

    def _limit(self, dock: ArrayLike | None, base: ArrayLike, backs_out: bool) -> tuple[float, str]:
        """Speed [m/s], and why."""
        limits = self._chair.limits
        reasons = [(max(limits.v_max, limits.v_reverse_max), "outside the bay")]
        if dock is not None and in_bay(self._chair, self._bay, relative(dock, base)):
            reasons.append((limits.v_bay_max, "in the bay"))
        if backs_out:
            reasons.append((self._back_out_speed, "backs out"))
        return min(reasons)
