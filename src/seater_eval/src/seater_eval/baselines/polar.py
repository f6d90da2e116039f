"""The chair seen from the docking pose in polar coordinates, for the feedback laws."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from seater_common.geometry import Limits
from seater_common.se2 import wrap_angle


@dataclass(frozen=True)
class Polar:
    """Line of sight from base_link to the docking pose: distance, and the two headings measured from it.

    In Park and Kuipers' letters r, theta (heading of the target) and delta (heading of the vehicle); in those of
    Siegwart and Nourbakhsh rho, alpha = -delta and beta = theta.
    """

    distance: float  # [m]
    target: float  # heading of the docking pose against the line of sight [rad]
    vehicle: float  # heading of the vehicle against the line of sight [rad]


def polar(T_dock_base: ArrayLike, backward: bool = False) -> Polar:
    """For the pose (x, y, heading) in the dock's frame; `backward`: for a chair that drives with its back ahead."""
    x, y, heading = (float(value) for value in np.asarray(T_dock_base, dtype=float))
    sight = math.atan2(-y, -x)
    turned = math.pi if backward else 0.0
    return Polar(math.hypot(x, y), wrap_angle(turned - sight), wrap_angle(heading + turned - sight))


def within_limits(v: float, omega: float, limits: Limits) -> tuple[float, float]:
    """Speeds scaled down together, so that the curvature stays, until both are within the limits."""
    forward = limits.v_max if v >= 0.0 else limits.v_reverse_max
    excess = max(abs(v) / forward if forward > 0.0 else math.inf * abs(v), abs(omega) / limits.omega_max, 1.0)
    return (0.0, omega / excess) if not math.isfinite(excess) else (v / excess, omega / excess)
