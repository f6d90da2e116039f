"""How the drift of odometry moves a standing dock in odom, with what is known about it.

The odometry measures way and turn as s' = (1 + e_s) s + n_s, t' = (1 + e_t) t + e_d s + b T + n_t, where T is the time
(seater_sim's kinematic odometry has the same model without b): errors e = (e_s, e_t, e_d) of wheels and track, the bias
b of a gyro, and white noise of variances distance_noise^2 |s| and heading_noise^2 |s| + turn_noise^2 |t|. The true
chair lags by e_s ds' along its direction and by e_t dt' + e_d ds' + b dT in its turn, so to first order the dock, seen
from the chair where it is, moves in odom by the first and swings round it by the second:

    dD = c (e_s ds' + n_s) + w (e_t dt' + e_d ds' + b dT + n_t),   w = (y - D_y, D_x - x, 1) = A (1, x, y)'.

Summed up over a way (travel.py) that is exact in first order however long the way is. No chair goes quite where
its wheels point (castors push it sideways, the axle is not where it is thought to be): across the way there is noise of
variance side_noise^2 |s|, too, of which the odometry says nothing.

On a floor that is wet here and dry there, e changes on the way and the noise is many times larger. How much so is the
`slip`, from 0 (tyres that roll, as the parameters say) to 1 (the parameters slip_*): the noise grows by
slip^2 slip_noise^2, and e walks at random by slip * slip_walk in each square root of a metre (or radian). A slip beyond
1 is a single wheel that spins: it turns the chair as such a slip says, but takes no more of its way than one of 1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import ObserverParameters

Array = NDArray[np.float64]

SIZE = 7  # of the state: dock in odom x, y [m], heading [rad]; e_s [-], e_t [-], e_d [rad/m], b [rad/s]


_I = np.eye(SIZE)


class Drift:
    """The model for one assumption about the slip."""

    def __init__(self, parameters: ObserverParameters, slip: float, *, both: bool = False) -> None:
        """`both`: beyond 1, too, the slip is that of both wheels."""
        p, turning = parameters, slip * slip
        self.slip, self._rolling = slip, slip if both else min(slip, 1.0)
        along = self._rolling**2
        self._p = p
        # Along and aside; of the turn by way and by turn; walks of e_s and e_t, and of e_d.
        self._variances = np.array(
            [
                p.distance_noise**2 + along * p.slip_distance_noise**2,
                p.side_noise**2 + along * p.slip_side_noise**2,
                p.heading_noise**2 + turning * p.slip_heading_noise**2,
                p.turn_noise**2 + along * p.slip_turn_noise**2,
                along * p.slip_walk**2,
                turning * p.slip_walk_turn**2,
            ]
        )

    def initial_errors(self) -> tuple[Array, Array]:
        """Mean (4,) and covariance (4, 4) of (e_s, e_t, e_d, b) before anything was measured."""
        p = self._p
        mean = np.array([p.odometry_scale, p.odometry_heading_scale, p.odometry_heading_drift, 0.0])
        sd = np.array([p.scale_sd, p.heading_scale_sd, p.heading_drift_sd, 0.0])
        slipping = self._rolling * np.array([p.slip_walk, p.slip_walk, p.slip_walk_turn, p.gyro_bias_sd])
        return mean, np.diag(sd**2 + slipping**2)

    def transition(self, dock: Array, last: Instant, now: Instant) -> tuple[Array, Array]:
        """F and Q, (7, 7), of the state from `last` to `now`; `dock` (3,): its place at `last`."""
        F, Q = transitions([self], dock[None], last, now)
        return F[0], Q[0]


def transitions(models: Sequence[Drift], docks: Array, last: Instant, now: Instant) -> tuple[Array, Array]:
    """F and Q, (k, 7, 7), of each of k models, as `Drift.transition`; `docks` (k, 3). What does not depend on the model
    is computed once."""
    variances = np.array([model._variances for model in models])  # (k, 6)
    along, aside, by_way, by_turn, walk, walk_turn = variances.T[:, :, None, None]
    A = np.zeros((len(models), 3, 3))
    A[:, 0, 0], A[:, 1, 0], A[:, 0, 2], A[:, 1, 1], A[:, 2, 0] = -docks[:, 1], docks[:, 0], 1.0, -1.0, 1.0
    travel = now.travel.plus(last.travel, -1.0)
    F, Q = np.zeros((2, len(models), SIZE, SIZE))
    F[:] = _I
    F[:, :2, 3] = now.pose[:2] - last.pose[:2]
    F[:, :3, 4:] = A @ travel.rows.T
    Q[:, :2, :2] = along * travel.along + aside * (_I[:2, :2] * travel.driven - travel.along)
    Q[:, :3, :3] += A @ (by_way * travel.by_way + by_turn * travel.by_turn) @ A.transpose(0, 2, 1)
    way, turn = travel.driven, travel.turned
    Q[:, 3, 3], Q[:, 4, 4], Q[:, 5, 5] = (walk * way)[:, 0, 0], (walk * turn)[:, 0, 0], (walk_turn * way)[:, 0, 0]
    if now.stamp < last.stamp:
        Q = -Q  # backward in time the sums are negative; uncertainty grows all the same
    return F, Q
