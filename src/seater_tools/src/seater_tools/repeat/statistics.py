"""How well dockings repeat themselves, by their estimated final errors.

Position as in ISO 9283: accuracy AP is the distance of the mean from the dock; repeatability RP = mean + 3 sd of the
distances l_i from the mean, here in the plane. Both hold what images say: an error of print, mount or teaching that is
in all dockings is in none of these numbers, and the images' own noise is in all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import wrap_angle
from seater_tools.repeat.session import Docked


@dataclass(frozen=True, kw_only=True)
class Spread:
    """Of one number over the dockings."""

    mean: float
    sd: float  # NaN of one docking
    worst: float  # the farthest from 0

    @classmethod
    def of(cls, values: NDArray[np.float64]) -> Spread:
        """(n,), n > 0."""
        sd = float(np.std(values, ddof=1)) if len(values) > 1 else float("nan")
        return cls(mean=float(np.mean(values)), sd=sd, worst=float(values[np.argmax(np.abs(values))]))


@dataclass(frozen=True, kw_only=True)
class Repeatability:
    """Of those that docked and were measured; None where there are none."""

    dockings: int
    docked: int
    measured: int
    retried: int
    x: Spread | None  # [m]
    y: Spread | None  # [m]
    heading: Spread | None  # [rad]
    distance: Spread | None  # [m] from the dock
    duration: Spread | None  # [s]
    accuracy: float  # AP [m]
    repeatability: float  # RP [m]; NaN below two dockings
    stated_sd: float  # [m] mean of the standard deviations that the chair itself states


def repeatability(dockings: Sequence[Docked]) -> Repeatability:
    """Of a session."""
    good = [d for d in dockings if d.measured]
    x, y = np.array([d.x for d in good]), np.array([d.y for d in good])
    heading = np.array([wrap_angle(d.heading) for d in good])
    many = len(good) > 1
    middle = (float(np.mean(x)), float(np.mean(y))) if good else (np.nan, np.nan)
    away = np.hypot(x - middle[0], y - middle[1])
    return Repeatability(
        dockings=len(dockings),
        docked=sum(d.success for d in dockings),
        measured=len(good),
        retried=sum(d.retries > 0 for d in dockings),
        x=Spread.of(x) if good else None,
        y=Spread.of(y) if good else None,
        heading=Spread.of(heading) if good else None,
        distance=Spread.of(np.hypot(x, y)) if good else None,
        duration=Spread.of(np.array([d.duration for d in good])) if good else None,
        accuracy=float(np.hypot(*middle)),
        repeatability=float(np.mean(away) + 3.0 * np.std(away, ddof=1)) if many else float("nan"),
        stated_sd=float(np.mean([d.position_sd for d in good])) if good else float("nan"),
    )
