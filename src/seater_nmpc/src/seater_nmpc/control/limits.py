"""The last look at a command before it leaves: speed, acceleration, and the bay's speed limit."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from seater_common.geometry import Bay, Chair

# [m/s, rad/s] by which a measured speed may differ from the commanded one beside what lag explains.
_SPEED_MISMATCH = 0.05


def in_bay(chair: Chair, bay: Bay, T_dock_base: ArrayLike) -> bool:
    """Whether the footprint reaches past the line on which the side walls begin."""
    return bool(np.max(chair.corners_at(T_dock_base)[:, 0]) > bay.entrance_x)


def largest_speeds(chair: Chair, slow: bool) -> tuple[float, float]:
    """(forward, backward) [m/s], both positive. `slow`: the bay's limit holds."""
    limits = chair.limits
    most = limits.v_bay_max if slow else math.inf
    return min(limits.v_max, most), min(limits.v_reverse_max, most)


def clamp(
    chair: Chair, v: float, omega: float, before: tuple[float, float], period: float, slow: bool
) -> tuple[float, float]:
    """Speeds within the limits and reachable from `before` within `period` [s]; zero speed asked for when not finite.

    `slow`: the bay's limit holds. Where it and the acceleration limit exclude each other, the acceleration limit wins:
    the chair brakes as hard as it may. The chair's own limits of speed hold even where `before` (a measured speed, say)
    is beyond them.
    """
    limits = chair.limits
    v, omega = (value if math.isfinite(value) else 0.0 for value in (v, omega))
    forward, backward = largest_speeds(chair, slow)
    v = min(max(v, -backward), forward)
    omega = min(max(omega, -limits.omega_max), limits.omega_max)
    v = min(max(v, before[0] - limits.a_max * period), before[0] + limits.a_max * period)
    omega = min(max(omega, before[1] - limits.alpha_max * period), before[1] + limits.alpha_max * period)
    v = min(max(v, -limits.v_reverse_max), limits.v_max)
    return v, min(max(omega, -limits.omega_max), limits.omega_max)


def within_reach(
    chair: Chair, sent: tuple[float, float] | None, measured: tuple[float, float], window: float
) -> tuple[float, float]:
    """The speeds `sent`, or what is nearest to them of all that the chair, measured so, can have within `window` [s].

    None sent: those measured.
    """
    if sent is None:
        return measured
    reach = [rate * window + _SPEED_MISMATCH for rate in (chair.limits.a_max, chair.limits.alpha_max)]
    v, omega = (min(max(s, m - r), m + r) for s, m, r in zip(sent, measured, reach, strict=True))
    return v, omega
