"""The first measurements of a dock: which of the poses that each image leaves open belong together."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.observe.measurement import Measurement, combine, distance
from seater_nmpc.observe.odometry import Instant

Array = NDArray[np.float64]
Series = list[tuple[Instant, Measurement]]

_PATIENCE = 4  # times the images that are needed, after which the likelier pose is taken though the odds are open


class Acquisition:
    """Collects images until enough of them agree on one pose of the dock.

    An image of a single marker may leave two poses open, and both may agree among themselves from image to image while
    the chair stands. So the weights of all images are multiplied, and a pose has to be likelier than every other one
    that agrees by `odds`.
    """

    def __init__(self, count: int, gate: float, odds: float, common: Array) -> None:
        """`count`: images that have to agree; `gate`: squared Mahalanobis distance from their mean up to which they do;
        `common`: covariance (3, 3) that is added to every measurement's for the gate."""
        self._count, self._gate, self._odds, self._common = count, gate, math.log(odds), common
        self._images: deque[tuple[Instant, list[Measurement]]] = deque(maxlen=_PATIENCE * count)

    def clear(self) -> None:
        """Forget all images."""
        self._images.clear()

    def offer(self, chair: Instant, offered: list[Measurement]) -> Series | None:
        """Take the poses in odom that an image leaves open; the images in the order of their times once they agree."""
        self._images.append((chair, offered))
        while len(self._images) >= self._count:
            agreeing = sorted(self._agreeing(offered), key=lambda scored: scored[0], reverse=True)
            if agreeing:
                clear = len(agreeing) == 1 or agreeing[0][0] - agreeing[1][0] >= self._odds
                if clear or len(self._images) == self._images.maxlen:
                    return sorted(agreeing[0][1], key=lambda entry: entry[0].stamp)
                return None
            if len(self._images) == self._count:
                return None
            self._images.popleft()  # perhaps it is the oldest one that does not fit
        return None

    def _agreeing(self, candidates: list[Measurement]) -> list[tuple[float, Series]]:
        """For each pose of the newest image the nearest ones in the others, where these agree; with log weights."""
        result = []
        for candidate in candidates:
            series = [
                (chair, min(poses, key=lambda m: distance(m.pose, candidate.pose, m.covariance + candidate.covariance)))
                for chair, poses in list(self._images)[:-1]
            ]
            series.append((self._images[-1][0], candidate))
            mean = combine([measurement for _, measurement in series])
            if all(distance(m.pose, mean.pose, m.covariance + self._common) <= self._gate for _, m in series):
                result.append((sum(math.log(m.weight) for _, m in series), series))
        return result
