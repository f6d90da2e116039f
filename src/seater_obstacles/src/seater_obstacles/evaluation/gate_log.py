"""The safety gate of a run, and how often it held the chair for something in the way."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import seater_safety

Array = NDArray[np.float64]

_WORDS = "something is in the way"  # of the gate's reason


class GateLog:
    """Passes on, and counts."""

    def __init__(self, gate: Any) -> None:
        """`gate`: seater_safety.VelocityGate."""
        self._gate = gate
        self._stops, self._stopped, self._slow, self._last = 0, False, 0.0, 0.0

    def arm(self, now: float) -> bool:
        """Whether the consent is given."""
        return bool(self._gate.arm(now) == "")

    def request(self, now: float, v: float, omega: float) -> None:
        """Of the docking [m/s, rad/s]."""
        self._gate.request(now, v, omega)

    def obstacles(self, now: float, measured: float, points: Array) -> None:
        """Points (n, 2) [m] in base_link at the time `measured`."""
        self._gate.obstacles(now, measured, [tuple(point) for point in points.tolist()])

    def output(self, now: float) -> tuple[float, float]:
        """For the motors [m/s, rad/s]."""
        v, omega = self._gate.output(now)
        stopped = self._gate.state == seater_safety.GateState.OBSTACLE
        self._stops += stopped and not self._stopped
        if self._last and _WORDS in self._gate.reason(now):
            self._slow += now - self._last
        self._stopped, self._last = stopped, now
        return float(v), float(omega)

    @property
    def holds(self) -> bool:
        """Whether the chair is stopped for something in the way, as gate_state says."""
        return self._stopped

    def values(self) -> dict[str, Any]:
        """Stops, and time for which the chair was slowed down or stopped."""
        return {"gate_stops": self._stops, "gate_limited_s": self._slow}
