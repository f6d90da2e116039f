"""The first measurements of a dock: which of the poses that each image leaves open belong together."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.observe.measurement import Measurement, combine, distance
from seater_nmpc.observe.odometry.instant import Instant

Array = NDArray[np.float64]
Series = list[tuple[Instant, Measurement]]
Drift = Callable[[Array, Instant, Instant], Array]

_PATIENCE = 4  # times the images that are needed, after which the likelier pose is taken though the odds are open
_AGREEING = 0.6  # fraction of the images from the first agreeing one on that have to agree
_WRONG = math.log(0.05)  # of the odds that an image does not show the dock where it is


@dataclass(frozen=True)
class Agreement:
    """What the first images agree on, each series in the order of their times."""

    series: Series
    other: Series | None = None  # the second likeliest pose on which they agree as well
    odds: float = 0.0  # its log odds against the first


class Acquisition:
    """Collects images until enough of them agree on one pose of the dock.

    An image of a single marker may leave two poses open, and both may agree among themselves from image to image while
    the chair stands. So the weights of all images are multiplied, and a pose has to be likelier than every other one
    that agrees by `odds`, be it in fewer images. A wrong image now and then does not matter, as long as most of them
    agree; against a pose that it does not show it counts as much as wrong images are rare.
    """

    def __init__(self, count: int, gate: float, odds: float, common: Array, drift: Drift) -> None:
        """`count`: images that have to agree; `gate`: squared Mahalanobis distance from their mean up to which they do;
        `common`: covariance (3, 3) that is added to every measurement's for the gate; `drift(dock, before, now)`: the
        covariance (3, 3) of how far odometry may have moved the dock (3,) in odom between two instants."""
        self._count, self._gate, self._odds, self._common = count, gate, math.log(odds), common
        self._drift = drift
        self._images: deque[tuple[Instant, list[Measurement]]] = deque(maxlen=_PATIENCE * count)

    def clear(self) -> None:
        """Forget all images."""
        self._images.clear()

    def offer(self, chair: Instant, offered: list[Measurement]) -> Agreement | None:
        """Take the poses in odom that an image leaves open; what the images agree on, once they do."""
        self._images.append((chair, offered))
        if len(self._images) < self._count:
            return None
        agreeing = sorted(self._agreeing(chair, offered), key=lambda scored: scored[0], reverse=True)
        enough = [(weight, series) for weight, series in agreeing if len(series) >= self._count]
        if not enough:
            return None
        weight, series = enough[0]
        others = [scored for scored in agreeing if scored[1] is not series]
        if not others:
            return Agreement(series)
        odds = others[0][0] - weight
        if odds <= -self._odds or len(self._images) == self._images.maxlen:
            return Agreement(series, others[0][1], odds)
        return None

    def _agreeing(self, now: Instant, candidates: list[Measurement]) -> list[tuple[float, Series]]:
        """For each pose of the newest image the ones in the others that agree with it; with log weights."""
        found, before = [], list(self._images)[:-1]
        for candidate in candidates:
            nearest = [self._nearest(chair, poses, now, candidate) for chair, poses in before]
            series = self._around_their_mean([entry for entry in nearest if entry is not None], (now, candidate))
            if series:
                found.append(series)
        longest = max((self._span(series) for series in found), default=0)
        return [
            (sum(math.log(m.weight) for _, m in series) + (longest - len(series)) * _WRONG, series)
            for series in found
            if len(series) >= _AGREEING * longest
        ]

    def _around_their_mean(self, others: Series, newest: tuple[Instant, Measurement]) -> Series:
        """Less those farthest from the mean, until all agree with their own; empty: the newest does not."""
        series = [*others, newest]
        while len(series) > 1:
            mean = combine([measurement for _, measurement in series])
            oldest = min((chair for chair, _ in series), key=lambda chair: chair.stamp)
            far = [self._far(oldest, m, newest[0], mean.pose, m.covariance) for _, m in series]
            worst = int(np.argmax(far))
            if far[worst] <= self._gate:
                return sorted(series, key=lambda entry: entry[0].stamp)
            if worst == len(series) - 1:
                break
            del series[worst]
        return []

    def _nearest(
        self, chair: Instant, poses: list[Measurement], now: Instant, candidate: Measurement
    ) -> tuple[Instant, Measurement] | None:
        """Of the poses that an image leaves open the one that is nearest to the candidate, if they agree."""
        scored = [(self._far(chair, m, now, candidate.pose, m.covariance + candidate.covariance), m) for m in poses]
        best = min(scored, key=lambda entry: entry[0])
        return (chair, best[1]) if best[0] <= self._gate else None

    def _far(self, chair: Instant, measurement: Measurement, now: Instant, pose: Array, covariance: Array) -> float:
        return distance(measurement.pose, pose, covariance + self._common + self._drift(pose, chair, now))

    def _span(self, series: Series) -> int:
        """Images from the first one that agrees to the newest."""
        agreeing = {id(chair) for chair, _ in series}
        first = next((i for i, (chair, _) in enumerate(self._images) if id(chair) in agreeing), len(self._images))
        return len(self._images) - first
