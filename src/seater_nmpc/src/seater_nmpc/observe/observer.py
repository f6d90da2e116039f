"""The state observer: the dock's pose in odom, from marker measurements at image time and buffered odometry.

An extended Kalman filter of six states: the dock, and the constant errors of the odometry (drift.py). The dock stands
still; what moves it in odom is the drift of the odometry, so everything counts metres and radians, not seconds. What
calibration leaves is the same in every image: it does not average out, so it is no part of the filter's noise but of
the gate and of the covariance that is handed out. A measurement passes the gate or it is not used; nothing is smoothed
before that.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import CameraMount
from seater_common.se2 import wrap_angle
from seater_nmpc.observe.acquisition import Acquisition, Series
from seater_nmpc.observe.drift import scale_covariance, transition
from seater_nmpc.observe.innovation import Fusion, Innovation, Outcome, likeliest
from seater_nmpc.observe.measurement import Hypothesis, Measurement, Planar, difference, in_frame, project
from seater_nmpc.observe.odometry import Instant, Odometry, OdometryBuffer
from seater_nmpc.parameters import ObserverParameters

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class DockEstimate:
    """The dock in odom at one time."""

    pose: Array  # (3,)
    covariance: Array  # (3, 3)
    age: float  # since the image behind it was taken [s]
    blind_distance: float  # driven since then [m]


@dataclass(frozen=True)
class _State:
    """The filter just after a measurement, and the measurement (to be applied again after a late one)."""

    instant: Instant
    mean: Array  # (6,)
    covariance: Array  # (6, 6)
    measurement: Measurement


class DockObserver:
    """Where the dock is, how old and how certain the answer is."""

    def __init__(
        self, mount: CameraMount, parameters: ObserverParameters | None = None, *, standing: bool = True
    ) -> None:
        """`standing`: the first estimate is made only while the chair stands."""
        self._T_base_optical = mount.T_base_optical()
        self.parameters = parameters or ObserverParameters()
        self._standing = standing
        p = self.parameters
        self._calibration = np.diag([p.calibration_position**2, p.calibration_position**2, p.calibration_heading**2])
        self.odometry = OdometryBuffer(self.parameters.buffer_duration, self.parameters.max_extrapolation)
        self.counts: Counter[Outcome] = Counter()
        self.refused_odometry = 0
        self.reset()

    def reset(self, prior: ArrayLike | None = None, prior_radius: float = 1.0) -> None:
        """Forget the dock. `prior`: rough pose in odom; only measurements within `prior_radius` [m] of it acquire."""
        self._prior = None if prior is None else np.asarray(prior, dtype=float)
        self._prior_radius = prior_radius
        self._states: deque[_State] = deque()
        p = self.parameters
        self._candidates = Acquisition(p.acquire_count, p.gate, p.acquire_odds, self._calibration)
        self._rejected = Acquisition(p.reacquire_count, p.gate, p.acquire_odds, self._calibration)

    def add_odometry(self, odometry: Odometry) -> bool:
        """Take an odometry message; false when it is refused (not finite, not newer)."""
        taken = self.odometry.add(odometry)
        self.refused_odometry += not taken
        return taken

    def add_detections(self, stamp: float, hypotheses: list[Hypothesis]) -> Fusion:
        """Take what one image, taken at `stamp`, says about the dock."""
        fusion = self._take(stamp, hypotheses)
        self.counts[fusion.outcome] += 1
        return fusion

    def estimate(self, stamp: float | None = None) -> DockEstimate | None:
        """The dock at `stamp` (default: that of the newest odometry); None before it was found or without odometry."""
        now = self.odometry.newest if stamp is None else self.odometry.at(stamp)
        if not self._states or now is None:
            return None
        last = self._states[-1]
        mean, covariance = self._predict(last, now)
        blind = max(0.0, now.driven - last.instant.driven)
        age = max(0.0, now.stamp - last.instant.stamp)
        return DockEstimate(
            pose=mean[:3], covariance=covariance[:3, :3] + self._calibration, age=age, blind_distance=blind
        )

    def measurements_since(self, stamp: float) -> list[Measurement]:
        """Measurements of the dock in odom that were used, of images taken at or after `stamp`."""
        return [state.measurement for state in self._states if state.instant.stamp >= stamp]

    def _take(self, stamp: float, hypotheses: list[Hypothesis]) -> Fusion:
        if not hypotheses:
            return Fusion(outcome=Outcome.EMPTY)
        chair = self.odometry.at(stamp)
        if chair is None:
            return Fusion(outcome=Outcome.NO_ODOMETRY)
        planar = [p for p in (project(self._T_base_optical, hypothesis) for hypothesis in hypotheses) if p is not None]
        offered = [in_frame(chair.pose, p.measurement) for p in planar if self._on_the_floor(p)]
        if not offered:
            return Fusion(outcome=Outcome.FLIP if planar else Outcome.INVALID)
        if not self._states:
            return Fusion(outcome=self._acquire(chair, offered))
        return self._fuse(chair, offered)

    def _on_the_floor(self, planar: Planar) -> bool:
        return planar.tilt <= self.parameters.max_tilt and abs(planar.height) <= self.parameters.max_height

    def _acquire(self, chair: Instant, offered: list[Measurement]) -> Outcome:
        if self._prior is not None:
            offered = [m for m in offered if math.dist(m.pose[:2], self._prior[:2]) <= self._prior_radius]
        moving = max(abs(chair.v), abs(chair.omega)) > self.parameters.acquire_speed
        if not offered or (self._standing and moving):
            self._candidates.clear()
            return Outcome.ACQUIRING
        series = self._candidates.offer(chair, offered)
        if series is None:
            return Outcome.ACQUIRING
        self._begin(series)
        return Outcome.ACQUIRED

    def _begin(self, series: Series) -> None:
        """From the first measurement and what is known of such odometry; the others are fused one by one."""
        chair, first = series[0]
        covariance = np.zeros((6, 6))
        covariance[:3, :3], covariance[3:, 3:] = first.covariance, scale_covariance(self.parameters)
        self._states.clear()
        self._states.append(_State(chair, np.concatenate([first.pose, np.zeros(3)]), covariance, first))
        for chair, measurement in series[1:]:
            self._update(chair, measurement)
        self._candidates.clear()
        self._rejected.clear()

    def _fuse(self, chair: Instant, offered: list[Measurement]) -> Fusion:
        later = [state for state in self._states if state.instant.stamp > chair.stamp]
        if len(later) == len(self._states):
            return Fusion(outcome=Outcome.STALE)
        before = self._states[len(self._states) - len(later) - 1]
        mean, predicted = self._predict(before, chair)
        gate = self.parameters.gate
        innovation, best = likeliest(offered, mean[:3], predicted[:3, :3], self._calibration, gate)
        if innovation.nis > gate:
            return self._reject(chair, offered, innovation)
        self._rejected.clear()
        for _ in later:
            self._states.pop()
        self._update(chair, best)
        for state in later:
            self._update(state.instant, state.measurement)
        while len(self._states) > 1 and self._states[0].instant.stamp < chair.stamp - self.parameters.buffer_duration:
            self._states.popleft()
        return Fusion(outcome=Outcome.FUSED, innovation=innovation)

    def _predict(self, last: _State, now: Instant) -> tuple[Array, Array]:
        F, Q = transition(last.mean[:3], last.instant, now, self.parameters)
        mean = F @ last.mean
        mean[2] = wrap_angle(float(mean[2]))
        return mean, F @ last.covariance @ F.T + Q

    def _update(self, chair: Instant, measurement: Measurement) -> None:
        mean, P = self._predict(self._states[-1], chair)
        gain = np.linalg.solve(P[:3, :3] + measurement.covariance, P[:3, :]).T
        mean += gain @ difference(measurement.pose, mean[:3])
        mean[2] = wrap_angle(float(mean[2]))
        keep = np.eye(6)
        keep[:, :3] -= gain
        covariance = keep @ P @ keep.T + gain @ measurement.covariance @ gain.T  # Joseph's form stays symmetric
        self._states.append(_State(chair, mean, covariance, measurement))

    def _reject(self, chair: Instant, offered: list[Measurement], innovation: Innovation) -> Fusion:
        series = self._rejected.offer(chair, offered)
        if series is None:
            return Fusion(outcome=Outcome.GATE, innovation=innovation)
        self._begin(series)
        return Fusion(outcome=Outcome.REACQUIRED, innovation=innovation)
