"""More of a turning command than is wanted, against what holds a driving chair on another arc.

Castors that stick hold a chair on the arc on which they stand, until the motors have built up the force that turns
them. A plain command waits for that; one that is larger by what is missing brings it about sooner. What the learned
response explains is not counteracted (axis_response.py: the difference is the least of all delays and lags that fit).
"""

from __future__ import annotations

import math

_GAIN = 1.5  # times what is missing
_IGNORED = 0.03  # [rad/s] that castors and uneven floors do to any chair
_TIME = 0.2  # [s] in which it follows
_MOST = 0.25  # [rad/s]


class Counteraction:
    """Feed it differences; `value` [rad/s] is to be added to the wanted turning rate."""

    def __init__(self) -> None:
        self.value = 0.0

    def add(self, difference: float, duration: float) -> None:
        """Over `duration` [s] the chair turned faster than expected by `difference` [rad/s]."""
        missing = -math.copysign(max(0.0, abs(difference) - _IGNORED), difference)
        asked = min(max(_GAIN * missing, -_MOST), _MOST)
        self.value += (asked - self.value) * min(1.0, duration / _TIME)

    def end(self) -> None:
        """The chair does not drive."""
        self.value = 0.0
