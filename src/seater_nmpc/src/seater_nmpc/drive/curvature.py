"""A chair that was asked to drive straight and does not: one side weaker, a slope, castors, a wheel that slips.

What turns it is proportional to the way in good approximation, so it is a curvature [rad/m]: an estimate that follows
the difference of measured and expected turning rate (an integrator, which leaves no offset in steady driving).
"""

from __future__ import annotations

_TIME = 3.0  # [s] in which the estimate follows at speed
_SLOW = 0.05  # [m/s] below which a turning rate says little about a curvature
_MOST = 0.2  # [rad/m]
_MOST_DIFFERENCE = 0.1  # [rad/s] that counts: more is a bump


class CurvatureEstimator:
    """Feed it differences; `value` [rad/m] is what the chair turns by itself."""

    def __init__(self) -> None:
        self.value = 0.0

    def add(self, difference: float, v: float, duration: float) -> None:
        """Over `duration` [s] at the speed `v` the chair turned faster than expected with `value` by `difference`."""
        difference = min(max(difference, -_MOST_DIFFERENCE), _MOST_DIFFERENCE)
        change = difference * v / (v * v + _SLOW * _SLOW) * duration / _TIME
        self.value = min(max(self.value + change, -_MOST), _MOST)
