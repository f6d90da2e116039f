"""The covariance that odometry claims: first-order propagation of the errors in its settings.

The state is the error of (x, y, heading) jointly with the constant errors e_s, e_t, e_d of odometry.py, so what a
constant scale error does to a long way is in it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_sim.settings import OdometrySettings

Array = NDArray[np.float64]

# Keeps covariances regular where the model has no error at all (standing at the origin): (0.01 mm)^2 and the like.
VARIANCE_FLOOR = 1e-10
FLOOR, IDENTITY = VARIANCE_FLOOR * np.eye(3), np.eye(6)


def noise_variances(settings: OdometrySettings, way: float, turn: float) -> tuple[float, float]:
    """Variances of the white errors of a way [m] and a turn [rad]."""
    variance_way = settings.distance_noise**2 * abs(way)
    variance_turn = settings.heading_noise**2 * abs(way) + settings.turn_noise**2 * abs(turn)
    return variance_way, variance_turn


class OdometryCovariance:
    """Covariances of pose and twist; (3, 3) over (x, y, heading) since the start, and (2, 2) over (v, omega)."""

    def __init__(self, settings: OdometrySettings) -> None:
        self._settings = settings
        sd = np.array([settings.scale_sd, settings.heading_scale_sd, settings.heading_drift_sd])
        self._P = np.diag(np.concatenate([np.zeros(3), sd**2]))

    def propagate(self, heading: float, way: float, turn: float, variance_way: float, variance_turn: float) -> None:
        """P <- F P F' + G Q G' with the measured motion as linearisation point (what a real driver knows); `heading`:
        before it."""
        direction = heading + 0.5 * turn
        along = np.array([math.cos(direction), math.sin(direction), 0.0])
        across = np.array([-way * math.sin(direction), way * math.cos(direction), 0.0])
        of_turn = 0.5 * across + np.array([0.0, 0.0, 1.0])
        F = IDENTITY.copy()
        F[:3, 2] += across
        F[:3, 3] = way * along
        F[:3, 4] = turn * of_turn
        F[:3, 5] = way * of_turn
        self._P = F @ self._P @ F.T
        # A product by broadcasting, like np.outer, which takes several times as long for three numbers.
        self._P[:3, :3] += variance_way * (along[:, None] * along) + variance_turn * (of_turn[:, None] * of_turn)

    def of_pose(self) -> Array:
        """(3, 3), regular."""
        return self._P[:3, :3] + FLOOR

    def of_twist(self, v: float, omega: float, variance_v: float, variance_omega: float) -> Array:
        """(2, 2), regular; the variances are those of the white errors."""
        s = self._settings
        variance_v += (s.scale_sd * v) ** 2
        variance_omega += (s.heading_scale_sd * omega) ** 2 + (s.heading_drift_sd * v) ** 2
        return np.array([[variance_v + VARIANCE_FLOOR, 0.0], [0.0, variance_omega + VARIANCE_FLOOR]])
