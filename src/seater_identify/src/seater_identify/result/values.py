"""One identified value, with how certain it is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum


class Quality(Enum):
    """What an estimate is good for."""

    GOOD = "good"  # at least as certain as docking asks for
    FAIR = "fair"  # usable, at up to three times that
    BOUND = "bound"  # the value is a lower bound: the truth lies at or beyond it
    REFUSED = "refused"  # not excited: no value


@dataclass(frozen=True)
class Estimate:
    """Value and standard deviation; NaN when refused, and then `text` says which drive would excite it."""

    name: str
    unit: str
    value: float = math.nan
    sd: float = math.nan
    quality: Quality = Quality.REFUSED
    text: str = ""

    @property
    def usable(self) -> bool:
        """Whether there is a value (a bound is none)."""
        return self.quality in (Quality.GOOD, Quality.FAIR)

    def interval(self) -> tuple[float, float]:
        """95 %."""
        return self.value - 1.96 * self.sd, self.value + 1.96 * self.sd


# name: (unit, standard deviation that is good). Issue 11's bars are two of them.
KINDS: dict[str, tuple[str, float]] = {
    "delay": ("s", 0.0075),
    "lag_v": ("s", 0.015),
    "lag_omega": ("s", 0.015),
    "gain_v": ("", 0.01),
    "gain_omega": ("", 0.015),
    "deadband_v": ("m/s", 0.002),
    "deadband_omega": ("rad/s", 0.005),
    "ramp_v": ("m/s^2", 0.05),
    "ramp_omega": ("rad/s^2", 0.1),
    "odometry_scale": ("", 0.005),
    "odometry_heading_scale": ("", 0.013),
    "odometry_heading_drift": ("rad/m", 0.007),
}


def judged(name: str, value: float, sd: float, remedy: str) -> Estimate:
    """Good, fair or refused by the standard deviation; `remedy`: what to drive for a better one."""
    unit, good = KINDS[name]
    if not (math.isfinite(value) and math.isfinite(sd)) or sd > 3.0 * good:
        return Estimate(name, unit, text=f"not excited: {remedy}")
    return Estimate(name, unit, value, sd, Quality.GOOD if sd <= good else Quality.FAIR)


def refused(name: str, why: str) -> Estimate:
    """Nothing is said."""
    return Estimate(name, KINDS[name][0], text=why)


def bound(name: str, value: float, why: str) -> Estimate:
    """The truth is at least `value`."""
    return Estimate(name, KINDS[name][0], value, math.nan, Quality.BOUND, why)
