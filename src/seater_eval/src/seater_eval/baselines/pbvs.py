"""Classic position-based visual servoing of a unicycle in polar coordinates (Siegwart and Nourbakhsh, Introduction to
Autonomous Mobile Robots, section 3.6.2; after Astolfi 1999):

    v = k_rho rho,   omega = k_alpha alpha + k_beta beta

with alpha the direction of the target seen from the chair, beta the heading of the line of sight seen from the target.
Locally exponentially stable for k_rho > 0, k_beta < 0, k_alpha > k_rho; for k_alpha + 5/3 k_beta - 2/pi k_rho > 0 alpha
stays within +-pi/2, so that the chair never turns its back on the target. When the target begins behind the chair, it
drives backward all the way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from numpy.typing import ArrayLike

from seater_common.geometry import Limits
from seater_eval.baselines.polar import polar, within_limits


@dataclass(frozen=True)
class PbvsGains:
    """The textbook's gains. Raises ValueError when they do not make a stable loop."""

    k_rho: float = 0.6  # [1/s]
    k_alpha: float = 1.6  # [1/s]
    k_beta: float = -0.5  # [1/s]
    stop_distance: float = 0.001  # [m]

    def __post_init__(self) -> None:
        if not (self.k_rho > 0.0 and self.k_beta < 0.0 and self.k_alpha > self.k_rho):
            raise ValueError("k_rho > 0, k_beta < 0 and k_alpha > k_rho are needed for stability")
        if not self.k_alpha + 5.0 / 3.0 * self.k_beta - 2.0 / math.pi * self.k_rho > 0.0:
            raise ValueError("k_alpha + 5/3 k_beta - 2/pi k_rho > 0 is needed, or the chair turns its back on the dock")


class Pbvs:
    """Remembers only whether this approach goes forward or backward."""

    name = "pbvs"

    def __init__(self, limits: Limits, gains: PbvsGains | None = None, period: float = 0.05) -> None:
        self._limits, self._gains, self.period = limits, gains or PbvsGains(), period
        self.reset()

    def reset(self) -> None:
        """The next pose decides the direction."""
        self._backward: bool | None = None

    def command(self, T_dock_base: ArrayLike, velocity: tuple[float, float]) -> tuple[float, float]:
        """See PoseController."""
        if self._backward is None:
            self._backward = abs(polar(T_dock_base).vehicle) > 0.5 * math.pi
        g, at = self._gains, polar(T_dock_base, self._backward)
        if at.distance <= g.stop_distance:
            return 0.0, 0.0
        alpha, beta = -at.vehicle, at.target
        v, omega = g.k_rho * at.distance, g.k_alpha * alpha + g.k_beta * beta
        return within_limits(-v if self._backward else v, omega, self._limits)
