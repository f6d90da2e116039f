"""One extended Kalman filter of the dock in odom, for one assumption about how much the wheels slip.

The state is the dock and the errors of the odometry (drift.py). The dock stands still; what moves it in odom is the
drift of the odometry, so nearly everything counts metres and radians, not seconds. What calibration leaves is the same
in every image: it does not average out, so it is no part of the filter's noise but of the gate and of the covariance
that is handed out. A measurement passes the gate or it is not used; nothing is smoothed before that.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import takewhile

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import wrap_angle
from seater_nmpc.observe.drift import SIZE, Drift
from seater_nmpc.observe.innovation import Innovation, likeliest
from seater_nmpc.observe.measurement import Measurement, difference
from seater_nmpc.observe.odometry import Instant
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
    fused: bool
    log_likelihood: float


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
            innovation, _ = likeliest([measurement], mean[:3], predicted[:3, :3], self._calibration, math.inf)
            likelihoods.append(innovation.log_likelihood)
            self._update(chair, measurement, mean, predicted)
        return float(np.mean(likelihoods)) if likelihoods else 0.0

    def adopt(self, other: DockFilter) -> None:
        """Go on from where the other one is."""
        self.states = deque(other.states)

    def covers(self, stamp: float) -> bool:
        """Whether a measurement at `stamp` is not older than everything that is kept."""
        return bool(self.states) and self.states[0].instant.stamp <= stamp

    def take(self, chair: Instant, offered: list[Measurement]) -> Look:
        """Fuse the likeliest of the poses that an image leaves open, if it passes the gate. `covers` must hold."""
        later = list(takewhile(lambda state: state.instant.stamp > chair.stamp, reversed(self.states)))[::-1]
        before = self.states[len(self.states) - len(later) - 1]
        mean, predicted = self.predict(before, chair)
        gate = self._parameters.gate
        innovation, best = likeliest(offered, mean[:3], predicted[:3, :3], self._calibration, gate)
        if innovation.nis > gate:
            return Look(innovation, False, _LOG_OUTLIER)
        for _ in later:
            self.states.pop()
        self._update(chair, best, mean, predicted)
        for state in later:
            self._update(state.instant, state.measurement, *self.predict(self.states[-1], state.instant))
        oldest = chair.stamp - self._parameters.buffer_duration
        while len(self.states) > _KEPT and self.states[0].instant.stamp < oldest:
            self.states.popleft()
        return Look(innovation, True, max(_LOG_OUTLIER, innovation.log_likelihood))

    def predict(self, last: State, now: Instant) -> tuple[Array, Array]:
        """Mean (7,) and covariance (7, 7) at `now`."""
        F, Q = self._drift.transition(last.mean, last.instant, now)
        mean = F @ last.mean
        mean[2] = wrap_angle(float(mean[2]))
        return mean, F @ last.covariance @ F.T + Q

    def _update(self, chair: Instant, measurement: Measurement, mean: Array, P: Array) -> None:
        """`mean` and `P`: as predicted for `chair`, from the last state."""
        gain = np.linalg.solve(P[:3, :3] + measurement.covariance, P[:3, :]).T
        mean = mean + gain @ difference(measurement.pose, mean[:3])
        mean[2] = wrap_angle(float(mean[2]))
        keep = _I.copy()
        keep[:, :3] -= gain
        covariance = keep @ P @ keep.T + gain @ measurement.covariance @ gain.T  # Joseph's form stays symmetric
        self.states.append(State(chair, mean, covariance, measurement))
