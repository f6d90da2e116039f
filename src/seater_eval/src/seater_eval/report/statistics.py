"""Statistics that the reports show."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from scipy.stats import beta

LEVELS = {"median": 0.5, "p95": 0.95, "p99": 0.99, "max": 1.0}


def spread(values: Iterable[float | None]) -> dict[str, float | None]:
    """Median, 95th and 99th percentile and maximum of the finite ones; None each when there are none."""
    numbers = [float(value) for value in values if value is not None and math.isfinite(value)]
    if not numbers:
        return dict.fromkeys(LEVELS)
    return dict(zip(LEVELS, np.quantile(numbers, list(LEVELS.values())).tolist(), strict=True))


def largest_share(count: int, of: int, confidence: float = 0.95) -> float:
    """Largest share that `count` of `of` does not refute: the exact one-sided binomial limit (Clopper and Pearson, "The
    use of confidence or fiducial limits", 1934). 1 when nothing was tried."""
    if count >= of:
        return 1.0
    return float(beta.ppf(confidence, count + 1, of - count))
