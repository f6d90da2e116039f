"""Whether the speeds in odometry messages are those of their poses. Where they are not, the poses count.

Some drivers leave the twist empty, some give it with a bias at rest. Speeds from poses lag by half of a window and are
as coarse as the encoders, so they are used only where the twist contradicts them for a while.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import relative
from seater_nmpc.observe.odometry.message import Odometry

Array = NDArray[np.float64]

_WINDOW = 0.12  # [s] over which speeds are taken from poses (at slow odometry: two messages)
_TOLERANCE = (0.012, 0.012)  # [m/s, rad/s] difference that noise and coarse encoders explain
_RELATIVE = 0.3  # the same as a fraction of the speed: while it changes, the poses lag
_MOVING = 3.0  # times the tolerance: slower than that, agreement proves nothing
_DISTRUST, _TRUST = 0.4, 2.0  # [s] of contradiction after which the poses count; of agreement until the twist does


class TwistCheck:
    """Feed it each message that is finite and newer than the last one."""

    def __init__(self) -> None:
        self._messages: deque[Odometry] = deque()
        self._wrong = [False, False]
        self._since: list[float | None] = [None, None]  # since when twist and poses say otherwise than `_wrong`

    def speeds(self, message: Odometry) -> tuple[float, float]:
        """(v [m/s], omega [rad/s]) to be used for this message."""
        reported = (message.v, message.omega)
        driven = self._driven(message)
        if driven is None:
            return reported
        for i in range(2):
            self._judge(i, message.stamp, reported[i], driven[i])
        v, omega = (d if wrong else r for r, d, wrong in zip(reported, driven, self._wrong, strict=True))
        return v, omega

    def _driven(self, message: Odometry) -> tuple[float, float] | None:
        """Mean speeds from the poses of the window."""
        messages = self._messages
        messages.append(message)
        while len(messages) > 2 and messages[1].stamp <= message.stamp - _WINDOW:
            messages.popleft()
        duration = message.stamp - messages[0].stamp
        if duration <= 0.0:
            return None
        x, _, turn = relative(messages[0].pose, message.pose)
        return float(x) / duration, float(turn) / duration

    def _judge(self, i: int, stamp: float, reported: float, driven: float) -> None:
        contradicts = abs(reported - driven) > _TOLERANCE[i] + _RELATIVE * max(abs(reported), abs(driven))
        if contradicts == self._wrong[i]:
            self._since[i] = None
            return
        if not contradicts and abs(driven) < _MOVING * _TOLERANCE[i]:
            return  # an empty twist is right while the chair stands
        since = self._since[i]
        if since is None:
            self._since[i] = stamp
        elif stamp - since >= (_TRUST if self._wrong[i] else _DISTRUST):
            self._wrong[i], self._since[i] = not self._wrong[i], None
