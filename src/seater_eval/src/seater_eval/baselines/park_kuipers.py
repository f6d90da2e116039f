"""The smooth feedback law of Park and Kuipers, "A Smooth Control Law for Graceful Motion of Differential Wheeled Mobile
Robots in 2D Environment", ICRA 2011: what opennav_docking and Nav2's graceful controller drive with.

With r, theta, delta from `polar` (eq. 8, 14 and 15 of the paper):

    kappa = -1/r [k2 (delta - atan(-k1 theta)) + (1 + k1 / (1 + (k1 theta)^2)) sin delta]
    v = v_max / (1 + beta |kappa|^lambda),   omega = kappa v

The law steers along a slow manifold and says nothing about stopping: like its users it drives slower near the target,
here along the curve from which the chair can just brake (v^2 <= 2 a r), and it stops inside `stop_distance`, where the
line of sight loses its meaning.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from numpy.typing import ArrayLike

from seater_common.geometry import Limits
from seater_eval.baselines.polar import polar, within_limits


@dataclass(frozen=True)
class ParkKuipersGains:
    """Gains as opennav_docking ships them (k_phi, k_delta, beta, lambda)."""

    k1: float = 3.0  # how fast the heading follows against the distance
    k2: float = 2.0  # how fast the heading goes to its manifold
    beta: float = 0.4  # how much curvature costs speed [m^lambda]
    exponent: float = 2.0  # lambda
    braking: float = 0.5  # fraction of a_max with which the speed falls towards the target
    stop_distance: float = 0.001  # [m]


class ParkKuipers:
    """Forward driving only, as in the paper."""

    name = "park_kuipers"

    def __init__(self, limits: Limits, gains: ParkKuipersGains | None = None, period: float = 0.05) -> None:
        self._limits, self._gains, self.period = limits, gains or ParkKuipersGains(), period

    def reset(self) -> None:
        """Nothing is remembered."""

    def command(self, T_dock_base: ArrayLike, velocity: tuple[float, float]) -> tuple[float, float]:
        """See PoseController."""
        g, at = self._gains, polar(T_dock_base)
        if at.distance <= g.stop_distance:
            return 0.0, 0.0
        kappa = self._curvature(at.distance, at.target, at.vehicle)
        v = self._limits.v_max / (1.0 + g.beta * abs(kappa) ** g.exponent)
        v = min(v, math.sqrt(2.0 * g.braking * self._limits.a_max * at.distance))
        # Whatever brakes, a step must not be longer than the way that is left.
        v = min(v, at.distance / (2.0 * self.period))
        return within_limits(v, kappa * v, self._limits)

    def _curvature(self, r: float, theta: float, delta: float) -> float:
        g = self._gains
        manifold = delta - math.atan(-g.k1 * theta)
        return -(g.k2 * manifold + (1.0 + g.k1 / (1.0 + (g.k1 * theta) ** 2)) * math.sin(delta)) / r
