"""Has something become more frequent? Fisher's exact test of the newest dockings against all before them.

Given how many of all n flags are set, the number among the newest WINDOW is hypergeometric if nothing has changed; its
upper tail is the p-value. It is taken after every docking, so the bar is far below 5 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import hypergeom

WINDOW = 20  # dockings
FEWEST = 20  # before them
# Simulated (test_history.py): of histories of 200 dockings at 2 to 15 %, at most 2 % warn at any time. From 5 % to
# 70 % it warns after 10 dockings (median).
P = 5e-4


@dataclass(frozen=True)
class Rise:
    """Shares of dockings before the window and in it; `noticed`: index of the docking at which the bar was passed."""

    noticed: int
    before: float
    now: float


def find_rise(flags: Sequence[bool] | np.ndarray) -> Rise | None:
    """The first one, if any."""
    series = np.asarray(flags, dtype=int)
    for end in range(FEWEST + WINDOW, len(series) + 1):
        before, window = series[: end - WINDOW], series[end - WINDOW : end]
        total = int(before.sum() + window.sum())
        if total and hypergeom.sf(int(window.sum()) - 1, end, total, WINDOW) < P:
            return Rise(end - 1, float(before.mean()), float(window.mean()))
    return None
