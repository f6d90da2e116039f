"""Several filters that differ only in how much slip they assume; the one that explains the images best is the answer.

Multiple model adaptive estimation (Magill 1965), with evidence that fades: a chair whose tyres roll keeps the sharp
covariance of the first filter, one that slips gets the answer of a filter that reckons with it, and an image that only
a slipping chair could have taken is not thrown away. A single wrong image does not choose: two in a row must.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.observe.filter import DockFilter, Look, State, take_together
from seater_nmpc.observe.innovation import Fusion, Outcome
from seater_nmpc.observe.measurement import Measurement
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import ObserverParameters

Array = NDArray[np.float64]

# What the filters assume, see drift.py. The last: a wheel that spins on a wet spot turns the chair by 1 rad/m at once.
SLIPS = (0.0, 0.15, 0.4, 1.0, 4.0)
_FADING = 0.8  # weight of the evidence so far at the next image
_LEAD = 2.0  # in log likelihood, by which another filter has to be ahead to be chosen
_PERSISTENCE = 2  # images in a row in which it has to be
_HOPELESS = 30.0  # so far behind, a filter goes on from the chosen one's state


class FilterBank:
    """`begin` it with a series of measurements that agree; then `take` those of each image."""

    def __init__(self, parameters: ObserverParameters, calibration: Array) -> None:
        """`calibration`: covariance (3, 3) common to all images."""
        self._filters = [DockFilter(parameters, calibration, slip) for slip in SLIPS]
        self._evidence = np.zeros(len(SLIPS))
        self._chosen, self._persisted = 0, 0
        self._answer: Look | None = None  # of the chosen filter to the newest image

    @property
    def chosen(self) -> DockFilter:
        """The filter whose estimate counts."""
        return self._filters[self._chosen]

    @property
    def slip(self) -> float:
        """What it assumes, see drift.py."""
        return SLIPS[self._chosen]

    @property
    def support(self) -> float:
        """Of the newest image for it, see filter.Look."""
        return 0.0 if self._answer is None else self._answer.support

    @property
    def last(self) -> State | None:
        """The chosen filter just after the newest measurement that it used."""
        return self.chosen.states[-1] if self.chosen.states else None

    def begin(self, series: list[tuple[Instant, Measurement]]) -> None:
        """Forget the dock, and begin anew from these."""
        means = np.array([single.begin(series) for single in self._filters])
        self._evidence = (means - means.max()) * min(len(series) - 1, 1.0 / (1.0 - _FADING))
        ahead = np.flatnonzero(self._evidence >= self._evidence[0] + _LEAD)
        self._chosen = int(np.argmax(self._evidence)) if len(ahead) else 0
        self._persisted = 0

    def covers(self, stamp: float) -> bool:
        """Whether a measurement at `stamp` is not older than everything that is kept."""
        return self.chosen.covers(stamp)

    def take(self, chair: Instant, offered: list[Measurement]) -> Fusion:
        """Let every filter look at the image. FUSED: the chosen one uses it; GATE: it does not."""
        covering = [i for i, single in enumerate(self._filters) if single.covers(chair.stamp)]
        looks: list[Look | None] = [None] * len(SLIPS)
        for i, look in zip(covering, take_together([self._filters[i] for i in covering], chair, offered), strict=True):
            looks[i] = look
        before = self._chosen
        self._weigh(looks)
        answer = looks[self._chosen] or looks[before]
        assert answer is not None  # the chosen filter covers the stamp
        self._answer = answer
        outcome = Outcome.FUSED if answer.fused else Outcome.GATE
        return Fusion(outcome=outcome, innovation=answer.innovation, measurement=answer.measurement)

    def _weigh(self, looks: list[Look | None]) -> None:
        worst = min(look.log_likelihood for look in looks if look is not None)
        likelihood = np.array([worst if look is None else look.log_likelihood for look in looks])
        self._evidence = _FADING * self._evidence + likelihood
        best = int(np.argmax(self._evidence))
        ahead = self._evidence[best] >= self._evidence[self._chosen] + _LEAD
        if ahead and likelihood[best] > likelihood[self._chosen]:
            self._persisted += 1
        else:
            self._persisted = 0
        if self._persisted >= _PERSISTENCE:
            self._chosen, self._persisted = best, 0
        for i, single in enumerate(self._filters):
            if self._evidence[i] < self._evidence[self._chosen] - _HOPELESS:
                single.adopt(self.chosen)
                self._evidence[i] = self._evidence[self._chosen] - 0.5 * _HOPELESS
