"""How a drive felt: accelerations, jerk, changes of direction, from the true speeds.

Accelerations are those of base_link, the middle of the driven axle. Differences are taken over WINDOW, which removes
what a person cannot feel as a change of acceleration (whole-body motion counts from 0.5 Hz on in ISO 2631-1; a window
of 0.1 s halves the amplitude at about 6 Hz) and keeps a single simulation step from deciding the peak.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WINDOW = 0.1  # [s]
MOVES_V, MOVES_OMEGA = 0.01, 0.02  # [m/s], [rad/s] from which on a direction counts


def comfort(time: Array, v: Array, omega: Array) -> dict[str, float]:
    """Peaks and root mean squares while driving, reversals and sign changes; `time` [s] is evenly spaced, all (n,)."""
    span = max(1, round(WINDOW / float(time[1] - time[0]))) if len(time) > 1 else 1
    width = span * float(time[1] - time[0]) if len(time) > 1 else WINDOW
    acceleration, turning = _difference(v, span) / width, _difference(omega, span) / width
    found = {
        "acceleration": acceleration,
        "jerk": _difference(acceleration, span) / width,
        "angular_acceleration": turning,
        "angular_jerk": _difference(turning, span) / width,
        "lateral_acceleration": v * omega,
    }
    moving = max(1, int(np.sum((np.abs(v) > MOVES_V) | (np.abs(omega) > MOVES_OMEGA))))
    values: dict[str, float] = {}
    for name, series in found.items():
        values[f"{name}_peak"] = float(np.max(np.abs(series), initial=0.0))
        values[f"{name}_rms"] = math.sqrt(float(np.sum(series**2)) / moving)
    values["reversals"] = float(sign_changes(v, MOVES_V))
    values["turning_sign_changes"] = float(sign_changes(omega, MOVES_OMEGA))
    return values


def _difference(series: Array, span: int) -> Array:
    """Over `span` samples; (n - span,), empty when there are too few."""
    return series[span:] - series[:-span] if len(series) > span else np.zeros(0)


def sign_changes(series: Array, threshold: float) -> int:
    """How often the direction changes, values within +-threshold left out."""
    signs = np.sign(series[np.abs(series) > threshold])
    return int(np.sum(signs[1:] != signs[:-1]))
