"""Wheel odometry: the true motion with scale errors, drift and noise, and a covariance that is computed from them.

Per message, true way s and turn t become

    s' = (1 + e_s) s + n_s,   t' = (1 + e_t) t + e_d s + n_t,

e_s, e_t, e_d drawn once per seed (wheel diameter, track width, unequal wheels), n_s and n_t white: variances
distance_noise^2 |s| and heading_noise^2 |s| + turn_noise^2 |t|. A standing chair has no odometry error growth. The
covariance is the first-order propagation of the error of (x, y, heading) jointly with e_s, e_t, e_d, so what a constant
scale error does to a long way is in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import arc_step
from seater_sim.settings import NANOSECONDS, OdometrySettings

Array = NDArray[np.float64]

# Keeps covariances regular where the model has no error at all (standing at the origin): (0.01 mm)^2 and the like.
VARIANCE_FLOOR = 1e-10


@dataclass(frozen=True)
class OdometrySample:
    """One message. Pose of base_link in odom, twist in base_link."""

    time_ns: int
    pose: Array  # (x [m], y [m], heading [rad])
    v: float  # [m/s]
    omega: float  # [rad/s]
    pose_covariance: Array  # (3, 3) over (x, y, heading), error since the start
    twist_covariance: Array  # (2, 2) over (v, omega)


class Odometry:
    """Integrates measured motion from `settings.origin` on. Same seed, same errors."""

    def __init__(self, settings: OdometrySettings, seed: int) -> None:
        self._settings = settings
        self._rng = np.random.default_rng([seed, 1])
        sd = np.array([settings.scale_sd, settings.heading_scale_sd, settings.heading_drift_sd])
        self.scale, self.heading_scale, self.heading_drift = (sd * self._rng.standard_normal(3)).tolist()
        self._pose: Array = settings.origin.as_array()
        self._P = np.diag(np.concatenate([np.zeros(3), sd**2]))

    def update(self, way: float, turn: float, duration_ns: int, time_ns: int) -> OdometrySample:
        """The message after a true motion of `way` [m] and `turn` [rad] within `duration_ns`."""
        s = self._settings
        variance_way = s.distance_noise**2 * abs(way)
        variance_turn = s.heading_noise**2 * abs(way) + s.turn_noise**2 * abs(turn)
        noise = self._rng.standard_normal(2)
        measured_way = way * (1.0 + self.scale) + math.sqrt(variance_way) * float(noise[0])
        measured_turn = turn * (1.0 + self.heading_scale) + way * self.heading_drift
        measured_turn += math.sqrt(variance_turn) * float(noise[1])
        self._propagate(measured_way, measured_turn, variance_way, variance_turn)
        self._pose = arc_step(self._pose, measured_way, measured_turn, 1.0)
        duration = duration_ns / NANOSECONDS
        v, omega = measured_way / duration, measured_turn / duration
        return OdometrySample(
            time_ns,
            self._pose.copy(),
            v,
            omega,
            self._P[:3, :3] + VARIANCE_FLOOR * np.eye(3),
            self._twist_covariance(v, omega, variance_way / duration**2, variance_turn / duration**2),
        )

    def _propagate(self, way: float, turn: float, variance_way: float, variance_turn: float) -> None:
        """P <- F P F' + G Q G' with the measured motion as linearisation point (what a real driver knows)."""
        direction = self._pose[2] + 0.5 * turn
        along = np.array([math.cos(direction), math.sin(direction), 0.0])
        across = np.array([-way * math.sin(direction), way * math.cos(direction), 0.0])
        heading = np.array([0.0, 0.0, 1.0])
        of_turn = 0.5 * across + heading
        F = np.eye(6)
        F[:3, 2] += across
        F[:3, 3] = way * along
        F[:3, 4] = turn * of_turn
        F[:3, 5] = way * of_turn
        self._P = F @ self._P @ F.T
        self._P[:3, :3] += variance_way * np.outer(along, along) + variance_turn * np.outer(of_turn, of_turn)

    def _twist_covariance(self, v: float, omega: float, variance_v: float, variance_omega: float) -> Array:
        s = self._settings
        variance_v += (s.scale_sd * v) ** 2
        variance_omega += (s.heading_scale_sd * omega) ** 2 + (s.heading_drift_sd * v) ** 2
        return np.diag([variance_v + VARIANCE_FLOOR, variance_omega + VARIANCE_FLOOR])
