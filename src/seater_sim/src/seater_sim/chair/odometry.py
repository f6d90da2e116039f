"""Odometry of the ideal chair: the true motion with scale errors, drift and noise, and a covariance computed from them.

Per message, true way s and turn t become

    s' = (1 + e_s) s + n_s,   t' = (1 + e_t) t + e_d s + n_t,

e_s, e_t, e_d drawn once per seed (wheel diameter, track width, unequal wheels), n_s and n_t white: variances
distance_noise^2 |s| and heading_noise^2 |s| + turn_noise^2 |t|. A standing chair has no odometry error growth. The
covariance is the first-order propagation of the error of (x, y, heading) jointly with e_s, e_t, e_d, so what a constant
scale error does to a long way is in it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import arc_step
from seater_sim.chair.covariance import OdometryCovariance, noise_variances
from seater_sim.chair.interface import OdometrySample
from seater_sim.settings import NANOSECONDS, OdometrySettings

Array = NDArray[np.float64]


class Odometry:
    """Integrates measured motion from `settings.origin` on. Same seed, same errors."""

    def __init__(self, settings: OdometrySettings, seed: int) -> None:
        self._settings = settings
        self._rng = np.random.default_rng([seed, 1])
        sd = np.array([settings.scale_sd, settings.heading_scale_sd, settings.heading_drift_sd])
        self.scale, self.heading_scale, self.heading_drift = (sd * self._rng.standard_normal(3)).tolist()
        self._pose: Array = settings.origin.as_array()
        self._covariance = OdometryCovariance(settings)

    def update(self, way: float, turn: float, duration_ns: int, time_ns: int) -> OdometrySample:
        """The message after a true motion of `way` [m] and `turn` [rad] within `duration_ns`."""
        s = self._settings
        variance_way, variance_turn = noise_variances(s, way, turn)
        noise = self._rng.standard_normal(2)
        measured_way = way * (1.0 + self.scale) + math.sqrt(variance_way) * float(noise[0])
        measured_turn = turn * (1.0 + self.heading_scale) + way * self.heading_drift
        measured_turn += math.sqrt(variance_turn) * float(noise[1])
        self._covariance.propagate(self._pose[2], measured_way, measured_turn, variance_way, variance_turn)
        self._pose = arc_step(self._pose, measured_way, measured_turn, 1.0)
        duration = duration_ns / NANOSECONDS
        v, omega = measured_way / duration, measured_turn / duration
        return OdometrySample(
            time_ns,
            self._pose.copy(),
            v,
            omega,
            self._covariance.of_pose(),
            self._covariance.of_twist(v, omega, variance_way / duration**2, variance_turn / duration**2),
        )
