"""The dock, and the other place where it may be as long as the images leave two open.

A single marker, far away or seen from ahead, looks nearly the same in two poses. While the chair stands, its images say
the same again and again; once it moves, only one of the two stays where it is. So both are followed, each by filters of
its own (bank.py), and the one that stays is the dock. How likely either is in a single image counts no more then: what
made it so (lens, light, print) is the same in the next.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.observe.acquisition import Series
from seater_nmpc.observe.bank import FilterBank
from seater_nmpc.observe.innovation import Fusion, Outcome
from seater_nmpc.observe.measurement import Measurement, between, distance
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import ObserverParameters

Array = NDArray[np.float64]

# All in log odds of the other place.
_MOST = 2.0  # that one image may say: a wrong one is not the end of either
_ANOTHER = 4.0  # from which it is the dock
_GIVEN_UP = -9.0  # from which it is followed no longer
_TWO = 4.0  # squared Mahalanobis distance, from which on two poses of an image are two places
_FADING = 0.97  # of the odds so far at the next image
_MOVED = (0.01, 0.01)  # [m], [rad] from image to image that counts: those of a chair that stands err alike


class Branches:
    """`begin` it with what the first images agree on; then `take` the measurements of each image."""

    def __init__(self, parameters: ObserverParameters, calibration: Array) -> None:
        """`calibration`: covariance (3, 3) common to all images."""
        self._parameters, self._calibration = parameters, calibration
        self.dock = FilterBank(parameters, calibration)
        self.other: FilterBank | None = None
        self._odds = 0.0
        self._counted: Instant | None = None

    def begin(self, series: Series, other: Series | None = None, odds: float = 0.0) -> None:
        """Forget the dock, and begin anew from these; `odds` of the other one, as a logarithm."""
        self.dock.begin(series)
        self.other, self._counted = None, series[-1][0]
        if other is not None:
            self.other = FilterBank(self._parameters, self._calibration)
            self._odds = float(np.clip(odds, -_MOST, _MOST))
            self.other.begin(other)

    def take(self, chair: Instant, offered: list[Measurement], *, settled: bool) -> Fusion:
        """As `FilterBank.take`; ACQUIRED: the other place is the dock from now on. `settled`: it must not change."""
        fusion = self.dock.take(chair, offered)
        if self.other is None or not self.other.covers(chair.stamp):
            return fusion
        its_own = self._of_the_other(offered)
        says, its_look = -_MOST, None
        if its_own:
            its_look = self.other.take(chair, its_own)
            says = float(np.clip(self.other.support - self.dock.support, -_MOST, _MOST))
        if self._moved(chair):
            self._counted = chair
            self._odds = _FADING * self._odds + says
        if self._odds < _GIVEN_UP:
            self.other = None
        elif self._odds > _ANOTHER and its_look is not None and its_look.outcome is Outcome.FUSED and not settled:
            self.dock, self.other, self._odds = self.other, self.dock, -self._odds
            return replace(its_look, outcome=Outcome.ACQUIRED, innovation=fusion.innovation)
        return fusion

    def _of_the_other(self, offered: list[Measurement]) -> list[Measurement]:
        """What an image shows of the other place: what shows the dock must not draw it there. Where odometry drifts,
        both are off alike, so of two poses the one that is not the dock's is the other's. Which is whose is decided of
        both at once: the wrong one moves as the chair does, and may come to lie farther from where it was than the
        right one does."""
        assert self.other is not None
        from_dock = [self._off(measurement, self.dock) for measurement in offered]
        from_other = [self._off(measurement, self.other) for measurement in offered]
        if len(offered) == 1:
            return offered if from_other[0] < from_dock[0] else []
        pairs = permutations(range(len(offered)), 2)
        of_the_dock = offered[min(pairs, key=lambda pair: from_dock[pair[0]] + from_other[pair[1]])[0]]
        return [m for m in offered if between(m, of_the_dock) > _TWO]

    def _off(self, measurement: Measurement, bank: FilterBank) -> float:
        assert bank.last is not None  # both have begun
        return distance(measurement.pose, bank.last.mean[:3], measurement.covariance + self._calibration)

    def _moved(self, chair: Instant) -> bool:
        last = self._counted
        assert last is not None  # both have begun
        if chair.stamp <= last.stamp:
            return False
        return chair.driven - last.driven >= _MOVED[0] or chair.turned - last.turned >= _MOVED[1]
