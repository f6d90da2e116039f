"""Has something changed? A CUSUM of sequential normal scores, free of assumptions on how a value is distributed.

Each new value's rank r among the n so far, ties shared, makes the score z = Phi^-1((r - 1/2) / n). While nothing
changes, ranks are independent and uniform whatever the distribution of the values (Barndorff-Nielsen 1963), so z is
about standard normal and nothing about the chair has to be known; see Conover, Tercero-Gomez, Cordero-Franco, "The
sequential normal scores transformation", Sequential Analysis 36 (2017). Page's two-sided CUSUM of the scores,

    C+ = max(0, C+ + z - k),   C- = max(0, C- - z - k),

says drift when one of them exceeds h (Page 1954). k = 0.5 is best for shifts of one standard deviation. A serial
correlation (a slow change of light over a day) raises the rate of false warnings.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

K = 0.5
# Simulated: of 2800 series of 200 values without a change (normal, Student's t with 2 degrees of freedom, log-normal,
# 0 or 1) 0.25 % warn at any time; 13 are watched. A shift of 2 standard deviations after 50 values is noticed after 9
# more (median), after 20 values after 18, one of 1 after 48.
H = 10.0
FEWEST = 10  # values before the first score: a rank among fewer says nothing


@dataclass(frozen=True)
class Drift:
    """`begin`: index of the value with which the change began; `before`, `after`: medians up to it and from it on."""

    begin: int
    noticed: int  # index of the value at which it was noticed
    before: float
    after: float


def find_drift(values: Sequence[float] | np.ndarray) -> Drift | None:
    """Of the last change that was noticed; values that are not finite are left out, indices are of all values."""
    series = np.asarray(values, dtype=float)
    finite = np.flatnonzero(np.isfinite(series))
    known = series[finite]
    high = low = 0.0
    begins = [0, 0]
    for n, z in enumerate(normal_scores(known)):
        for side, signed in enumerate((z, -z)):
            before = (high, low)[side]
            now = max(0.0, before + signed - K)
            if before == 0.0:
                begins[side] = n
            high, low = (now, low) if side == 0 else (high, now)
            if now > H:
                begin = begins[side]
                return Drift(
                    int(finite[begin]), int(finite[n]), float(np.median(known[:begin])), float(np.median(known[begin:]))
                )
    return None


def normal_scores(values: np.ndarray) -> list[float]:
    """One for each value; 0 for the first FEWEST."""
    normal, scores = NormalDist(), []
    for n, value in enumerate(values):
        if n < FEWEST or not math.isfinite(value):
            scores.append(0.0)
            continue
        below, same = int(np.sum(values[:n] < value)), int(np.sum(values[:n] == value))
        scores.append(normal.inv_cdf((below + 0.5 * same + 0.5) / (n + 1)))
    return scores
