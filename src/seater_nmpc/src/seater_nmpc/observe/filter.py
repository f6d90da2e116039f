"""One extended Kalman filter of the dock in odom, for one assumption about how much the wheels slip.

The state is the dock and the errors of the odometry (drift.py). The dock stands still; what moves it in odom is the
drift of the odometry, so nearly everything counts metres and radians, not seconds. What calibration leaves is the same
in every image: it does not average out, so it is no part of the filter's noise but of the gate and of the covariance
that is handed out. A measurement passes the gate or it is not used; nothing is smoothed before that.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import takewhile

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import wrap_angle
from seater_nmpc.observe.innovation import Innovation, likeliest
from seater_nmpc.observe.measurement import Measurement, difference
from seater_nmpc.observe.odometry.drift import SIZE, Drift, transitions
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import ObserverParameters

Array = NDArray[np.float64]
Series = Iterable[tuple[Instant, Measurement]]

_KEPT = 20  # states at least, however slow the camera: verification averages some of them
# Log density of an image that shows the dock where it is not: one in thirty, anywhere within a metre and a radian.
_LOG_OUTLIER = math.log(0.03)
_I = np.eye(SIZE)


@dataclass(frozen=True)
class State:
    """The filter just after a measurement, and the measurement (to be applied again after a late one)."""

    instant: Instant
    mean: Array  # (7,)
    covariance: Array  # (7, 7)
    measurement: Measurement


@dataclass(frozen=True)
class Look:
    """What one image means to a filter."""

    innovation: Innovation
    measurement: Measurement  # of the poses that the image leaves open the likeliest
    fused: bool
    log_likelihood: float

    @property
    def support(self) -> float:
        """Log likelihood of where the filter expects the dock over that of where the image shows it; at most 0."""
        log_det = float(np.linalg.slogdet(self.measurement.covariance)[1])
        return -0.5 * (self.innovation.nis + self.innovation.log_det - log_det)


class DockFilter:
    """Begin it with a series of measurements; then `take` those of each image."""

    def __init__(self, parameters: ObserverParameters, calibration: Array, slip: float) -> None:
        """`calibration`: covariance (3, 3) common to all images, added for the gate. `slip`: see drift.py."""
        self._parameters, self._calibration, self._drift = parameters, calibration, Drift(parameters, slip)
        self.states: deque[State] = deque()

    def begin(self, series: Series) -> float:
        """From the first measurement and what is known of such odometry; the others are fused one by one.

        Returns the mean log likelihood of those others (0 where there are none).
        """
        entries = iter(series)
        chair, first = next(entries)
        covariance = np.zeros((SIZE, SIZE))
        errors, covariance[3:, 3:] = self._drift.initial_errors()
        covariance[:3, :3] = first.covariance
        self.states = deque([State(chair, np.concatenate([first.pose, errors]), covariance, first)])
        likelihoods = []
        for chair, measurement in entries:
            mean, predicted = self.predict(self.states[-1], chair)
            expected = mean[None, :3], predicted[None, :3, :3]
            [(innovation, _)] = likeliest([measurement], *expected, self._calibration, math.inf)
            likelihoods.append(innovation.log_likelihood)
            _update([self], chair, [measurement], mean[None], predicted[None])
        return float(np.mean(likelihoods)) if likelihoods else 0.0

    def adopt(self, other: DockFilter) -> None:
        """Go on from where the other one is."""
        self.states = deque(other.states)

    def covers(self, stamp: float) -> bool:
        """Whether a measurement at `stamp` is not older than everything that is kept."""
        return bool(self.states) and self.states[0].instant.stamp <= stamp

    def take(self, chair: Instant, offered: list[Measurement]) -> Look:
        """Fuse the likeliest of the poses that an image leaves open, if it passes the gate. `covers` must hold."""
        return take_together([self], chair, offered)[0]

    def predict(self, last: State, now: Instant) -> tuple[Array, Array]:
        """Mean (7,) and covariance (7, 7) at `now`."""
        means, covariances = _predicted([self], [last], now)
        return means[0], covariances[0]

    def _later(self, stamp: float) -> list[State]:
        """The states after `stamp`, the oldest first."""
        return list(takewhile(lambda state: state.instant.stamp > stamp, reversed(self.states)))[::-1]

    def _drop_after(self, stamp: float) -> None:
        while self.states[-1].instant.stamp > stamp:
            self.states.pop()

    def _drop_old(self, newest: float) -> None:
        oldest = newest - self._parameters.buffer_duration
        while len(self.states) > _KEPT and self.states[0].instant.stamp < oldest:
            self.states.popleft()


def take_together(filters: Sequence[DockFilter], chair: Instant, offered: list[Measurement]) -> list[Look]:
    """`DockFilter.take` of each; what filters that fused the same images last have in common is computed once, and the
    rest for all of them in one array, to the same bits."""
    laters = [each._later(chair.stamp) for each in filters]
    befores = [each.states[-1 - len(later)] for each, later in zip(filters, laters, strict=True)]
    groups: dict[tuple[int, ...], list[int]] = {}  # by the instants that they are at, were at and will be at
    for index, (before, later) in enumerate(zip(befores, laters, strict=True)):
        groups.setdefault((id(before.instant), *(id(state.instant) for state in later)), []).append(index)
    looks: dict[int, Look] = {}
    for group in groups.values():
        those = [filters[i] for i in group]
        means, covariances = _predicted(those, [befores[i] for i in group], chair)
        gate = those[0]._parameters.gate  # and what else they do not differ in
        best = likeliest(offered, means[:, :3], covariances[:, :3, :3], those[0]._calibration, gate)
        passed = [k for k, (innovation, _) in enumerate(best) if not innovation.nis > gate]
        if passed:
            fusing = [those[k] for k in passed]
            for each in fusing:
                each._drop_after(chair.stamp)
            _update(fusing, chair, [best[k][1] for k in passed], means[passed], covariances[passed])
            for again in zip(*(laters[group[k]] for k in passed), strict=True):
                expected = _predicted(fusing, [each.states[-1] for each in fusing], again[0].instant)
                _update(fusing, again[0].instant, [state.measurement for state in again], *expected)
            for each in fusing:
                each._drop_old(chair.stamp)
        for k, index in enumerate(group):
            (innovation, measurement), fused = best[k], k in passed
            likelihood = max(_LOG_OUTLIER, innovation.log_likelihood) if fused else _LOG_OUTLIER
            looks[index] = Look(innovation, measurement, fused, likelihood)
    return [looks[index] for index in range(len(filters))]


def _predicted(filters: Sequence[DockFilter], lasts: Sequence[State], now: Instant) -> tuple[Array, Array]:
    """Means (k, 7) and covariances (k, 7, 7) at `now`, of k filters whose last states are of one instant."""
    means = np.array([last.mean for last in lasts])
    F, Q = transitions([each._drift for each in filters], means, lasts[0].instant, now)
    means = (F @ means[:, :, None])[:, :, 0]
    for mean in means:
        mean[2] = wrap_angle(float(mean[2]))
    return means, F @ np.array([last.covariance for last in lasts]) @ F.transpose(0, 2, 1) + Q


def _update(
    filters: Sequence[DockFilter], chair: Instant, measurements: list[Measurement], means: Array, P: Array
) -> None:
    """New states of k filters; `means` (k, 7) and `P` (k, 7, 7): as predicted for `chair`, from the last states."""
    noise = np.array([measurement.covariance for measurement in measurements])
    gain = np.linalg.solve(P[:, :3, :3] + noise, P[:, :3, :]).transpose(0, 2, 1)
    off = np.array([difference(one.pose, mean[:3]) for one, mean in zip(measurements, means, strict=True)])
    means = means + (gain @ off[:, :, None])[:, :, 0]
    keep = np.zeros_like(P)
    keep[:] = _I
    keep[:, :, :3] -= gain
    # Joseph's form stays symmetric.
    covariances = keep @ P @ keep.transpose(0, 2, 1) + gain @ noise @ gain.transpose(0, 2, 1)
    for each, mean, covariance, measurement in zip(filters, means, covariances, measurements, strict=True):
        mean[2] = wrap_angle(float(mean[2]))
        each.states.append(State(chair, mean, covariance, measurement))
