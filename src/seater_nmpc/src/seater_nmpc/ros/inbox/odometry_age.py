"""How long ago odometry arrived, and how old the one is that is being worked."""

from __future__ import annotations

import time

import rospy

LONGEST_BACKLOG = 5.0  # [s] a stamp that is farther ahead is wrong


class OdometryAge:
    """In lock-step the simulator's time counts, which may stand while others are waited for; else wall time."""

    def __init__(self, *, lock_step: bool) -> None:
        self._lock_step, self._clock = lock_step, rospy.get_time if lock_step else time.monotonic
        self._arrived, self._newest = self._clock(), rospy.Time()
        self._began = time.monotonic()  # of the work on the last one

    def arrived(self, stamp: rospy.Time) -> None:
        """In the subscriber's thread; a clock that stands is no odometry."""
        if stamp > self._newest:
            self._arrived, self._newest = self._clock(), stamp

    def begin(self) -> None:
        """The work on one."""
        self._began = time.monotonic()

    def start_anew(self) -> None:
        """Time went backward: any stamp is a new one."""
        self._newest = rospy.Time()

    def silence(self) -> float:
        """[s] since the last one arrived."""
        return self._clock() - self._arrived

    def behind(self, worked: rospy.Time) -> float:
        """How old the odometry is that is being worked [s], after a long search for a way, say. What would be asked for
        then is out of date, and the gate would refuse it by its stamp."""
        if self._lock_step:
            return 0.0
        newer = (self._newest - worked).to_sec()
        return max(newer if newer < LONGEST_BACKLOG else 0.0, time.monotonic() - self._began)
