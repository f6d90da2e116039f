"""Whether what a filter makes of the installation stays what it was, as an installation does.

Mount and lens are constants, so what the filter gains from one image to a later one takes its covariance from P to
P' < P and its values by a change of covariance P - P' (the innovations of an optimal filter are independent). A change
that is many times as large shows that the filter's assumption has ended: a chair that came from a dry floor onto a wet
one seemed to have its camera 76 mm aside within half a metre, after 50 images and a turn by 55 deg that showed 3 mm.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.plausibility.installation.filters import Found

Array = NDArray[np.float64]

_IMAGES, _EVERY = 12, 3  # entries that are kept; one for each so many images
# Chi-square with 4 degrees of freedom, 99.5 %: nine chairs with nothing wrong had 13.6 at most, the wet floor 16.9.
_BEYOND_CHANCE = 15.0


class Steadiness:
    """Of each filter: `add` what they have found with each image that is used."""

    def __init__(self) -> None:
        self._before: deque[list[Found]] = deque(maxlen=_IMAGES)
        self._used = 0

    def add(self, found: list[Found]) -> None:
        """By each filter, values (4,) and covariance (4, 4)."""
        if self._used % _EVERY == 0:
            self._before.append(found)
        self._used += 1

    def unlikely(self, best: int, now: Found, noise: Array) -> list[Found] | None:
        """What all filters had found before the change to `now` of the best one (an index), if that is one beyond
        chance; `noise` (4,): standard deviations of what every change may have beside."""
        changes = [_distance(found[best], now, noise) for found in self._before]
        if not changes or max(changes) <= _BEYOND_CHANCE:
            return None
        return self._before[int(np.argmax(changes))]


def _distance(before: Found, now: Found, noise: Array) -> float:
    """Squared Mahalanobis distance of a change, 4 degrees of freedom."""
    shift = now[0] - before[0]
    return float(shift @ np.linalg.solve(before[1] - now[1] + np.diag(noise**2), shift))
