"""How the drift of wheel odometry moves a standing dock in odom, with what is known about it.

The odometry measures way and turn as s' = (1 + e_s) s + n_s, t' = (1 + e_t) t + e_d s + n_t (seater_sim's odometry has
the same model): constant errors e = (e_s, e_t, e_d) that are estimated, and white noise of variances
distance_noise^2 |s| and heading_noise^2 |s| + turn_noise^2 |t|. The true chair lags by e_s ds' along its direction and
by e_t dt' + e_d ds' in its turn, so to first order the dock, seen from the chair where it is, moves in odom by the
first and swings round it by the second:

    dD = c (e_s ds' + n_s) + w (e_t dt' + e_d ds' + n_t),   w = (y - D_y, D_x - x, 1) = A (1, x, y)'.

Summed up over a way (odometry.Travel) that is exact in first order however long the way is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.observe.odometry import Instant
from seater_nmpc.parameters import ObserverParameters

Array = NDArray[np.float64]


def scale_covariance(p: ObserverParameters) -> Array:
    """(3, 3) of (e_s [-], e_t [-], e_d [rad/m]) before anything was measured."""
    return np.diag([p.scale_sd**2, p.heading_scale_sd**2, p.heading_drift_sd**2])


def transition(dock: Array, last: Instant, now: Instant, p: ObserverParameters) -> tuple[Array, Array]:
    """F and Q, (6, 6), from `last` to `now` of the state (dock in odom: x, y [m], heading [rad]; e_s, e_t, e_d)."""
    A = np.array([[-dock[1], 0.0, 1.0], [dock[0], -1.0, 0.0], [1.0, 0.0, 0.0]])
    travel = now.travel.plus(last.travel, -1.0)
    F, Q = np.eye(6), np.zeros((6, 6))
    F[:2, 3] = now.pose[:2] - last.pose[:2]
    F[:3, 4] = A @ travel.turn
    F[:3, 5] = A @ travel.way
    Q[:2, :2] = p.distance_noise**2 * travel.along
    Q[:3, :3] += A @ (p.heading_noise**2 * travel.by_way + p.turn_noise**2 * travel.by_turn) @ A.T
    if now.stamp < last.stamp:
        Q = -Q  # backward in time the sums are negative; uncertainty grows all the same
    return F, Q
