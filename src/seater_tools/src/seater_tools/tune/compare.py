"""Before and after, on dockings that the search has not seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from seater_tools.tune.objective import Measures, Verdict, costs, judge, score

RESAMPLES, LEVEL = 4000, 0.95
_SEED = 5


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """`low`, `high`: 95 % interval of by how much the score has changed (negative: better)."""

    before: Measures
    after: Measures
    was: Verdict
    now: Verdict
    low: float
    high: float

    @property
    def better(self) -> bool:
        """Surely better, and nothing broken."""
        return self.now.allowed and self.high < 0.0


def compare(before: Measures, after: Measures, tolerance: tuple[float, float]) -> Comparison:
    """The same dockings, in the same order. The interval is that of a paired bootstrap over the dockings."""
    old, new = costs(before, before), costs(after, before)
    rng = np.random.default_rng(_SEED)
    picks = rng.integers(len(old), size=(RESAMPLES, len(old)))
    changes = [score(new[pick]) - score(old[pick]) for pick in picks]
    low, high = np.quantile(changes, [0.5 * (1.0 - LEVEL), 0.5 * (1.0 + LEVEL)])
    was, now = judge(before, before, tolerance), judge(after, before, tolerance)
    return Comparison(before=before, after=after, was=was, now=now, low=float(low), high=float(high))
