"""The state observer: the dock's pose in odom, from marker measurements at image time and buffered odometry.

Images are fused by banks of filters (branches.py, bank.py, filter.py); before the first estimate, and when no filter
can believe what the images say though they agree among themselves, acquisition.py decides.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import CameraMount
from seater_common.se2 import compose
from seater_nmpc.observe.acquisition import Acquisition, Agreement, Series
from seater_nmpc.observe.bank import SLIPS, FilterBank
from seater_nmpc.observe.branches import Branches
from seater_nmpc.observe.filter import State
from seater_nmpc.observe.images import Images
from seater_nmpc.observe.innovation import Fusion, Outcome
from seater_nmpc.observe.measurement import Hypothesis, Measurement, apart, combine, mirrors, sd_of_place
from seater_nmpc.observe.odometry.buffer import OdometryBuffer
from seater_nmpc.observe.odometry.drift import Drift
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.observe.offers import Offers
from seater_nmpc.parameters import ObserverParameters

Array = NDArray[np.float64]

_MOST_WAITING = 20  # images that may wait for the odometry of their time
_CERTAIN = 3.0  # standard deviations
_OPEN = 1.5  # [m] of the markers: nearer, perspective tells their two poses apart


@dataclass(frozen=True, kw_only=True)
class DockEstimate:
    """The dock in odom at one time."""

    pose: Array  # (3,)
    covariance: Array  # (3, 3)
    age: float  # since the image behind it was taken [s]
    blind_distance: float  # driven since then [m]
    drift: Array  # (4,) errors of the odometry e_s [-], e_t [-], e_d [rad/m], b [rad/s], see drift.py
    slip: float  # that the filter reckons with, see drift.py


class DockObserver:
    """Where the dock is, how old and how certain the answer is."""

    def __init__(
        self, mount: CameraMount, parameters: ObserverParameters | None = None, *, standing: bool = True
    ) -> None:
        """`standing`: the first estimate is made only while the chair stands."""
        self.parameters = parameters or ObserverParameters()
        self._offers = Offers(mount, self.parameters)
        self._standing, self._moving_allowed, self._bounded = standing, False, False
        self._front: Array | None = None  # see bound_reacquisition
        p = self.parameters
        self.images = Images(p.buffer_duration)
        self._calibration = np.diag([p.calibration_position**2, p.calibration_position**2, p.calibration_heading**2])
        self.odometry = OdometryBuffer(self.parameters.buffer_duration, self.parameters.max_extrapolation)
        self._slipping = Drift(p, max(SLIPS))
        self.refused_odometry = 0
        self.reset()

    def reset(self, prior: ArrayLike | None = None, prior_radius: float = 1.0) -> None:
        """Forget the dock. `prior`: rough pose in odom; only measurements within `prior_radius` [m] of it acquire."""
        self._prior = None if prior is None else np.asarray(prior, dtype=float)
        self._prior_radius = prior_radius
        self._branches = Branches(self.parameters, self._calibration)
        self._estimated: tuple[State, Instant, DockEstimate] | None = None  # the last one, and what it was made from
        self._waiting: deque[tuple[float, list[Hypothesis]]] = deque(maxlen=_MOST_WAITING)
        p = self.parameters
        acquire = (p.gate, p.acquire_odds, self._calibration, self._wander)
        self._candidates = Acquisition(p.acquire_count, *acquire)
        self._rejected = Acquisition(p.reacquire_count, *acquire)
        self.elsewhere: tuple[float, float] | None = None  # [m, rad] so far off images agree on another place
        self.images.restart()

    def forget(self) -> None:
        """Forget the odometry and the images, too: time, or the dock, is another one."""
        self.odometry.clear()
        self.images.shown.clear()
        self.reset()

    def acquire_moving(self, moving: bool) -> None:
        """Whether the first estimate may be made while the chair moves; else as constructed."""
        self._moving_allowed = moving

    def bound_reacquisition(self, bounded: bool, front: ArrayLike | None = None) -> None:
        """Whether a dock that images show elsewhere has to be near where it was: while a goal relies on it.

        `front`: (x, y, direction) of its markers' middle in the dock's frame. Where the other place is the mirror image
        of the first one, seen from afar, the first was the wrong one of the two that few markers leave open: it is
        acquired anew.
        """
        self._bounded, self.elsewhere = bounded, None
        self._front = None if front is None else np.asarray(front, dtype=float)

    @property
    def _bank(self) -> FilterBank:
        return self._branches.dock

    @property
    def prior(self) -> Array | None:
        """The rough pose in odom that `reset` was given."""
        return self._prior

    def add_odometry(self, odometry: Odometry) -> bool:
        """Take an odometry message; false when it is refused (not finite, not newer)."""
        taken = self.odometry.add(odometry)
        self.refused_odometry += not taken
        while taken and self._waiting and self._waiting[0][0] <= odometry.stamp:
            self.images.no_longer_waiting()
            self.add_detections(*self._waiting.popleft())
        return taken

    def add_detections(self, stamp: float, hypotheses: list[Hypothesis]) -> Fusion:
        """Take what one image, taken at `stamp`, says about the dock."""
        slip = self._bank.slip
        fusion = self._take(stamp, hypotheses)
        if fusion.outcome.accepted:
            self.elsewhere = None
        self.images.note(stamp, fusion, as_expected=self._bank.slip == slip)
        return fusion

    def estimate(self, stamp: float | None = None) -> DockEstimate | None:
        """The dock at `stamp` (default: that of the newest odometry); None before it was found or without odometry."""
        now, last = self.odometry.newest if stamp is None else self.odometry.at(stamp), self._bank.last
        if last is None or now is None:
            return None
        known, slip = self._estimated, self._bank.slip
        if known is None or known[0] is not last or known[1] is not now or known[2].slip != slip:
            mean, covariance = self._bank.chosen.predict(last, now)
            estimate = DockEstimate(
                pose=mean[:3],
                covariance=covariance[:3, :3] + self._calibration,
                age=max(0.0, now.stamp - last.instant.stamp),
                blind_distance=max(0.0, now.driven - last.instant.driven),
                drift=mean[3:],
                slip=slip,
            )
            self._estimated = known = last, now, estimate
        return known[2]

    @property
    def slip(self) -> float | None:
        """That the filter reckons with, see drift.py; None before the dock was found."""
        return None if self._bank.last is None else self._bank.slip

    def true_speeds(self, v: float, omega: float) -> tuple[float, float]:
        """(v [m/s], omega [rad/s]) of the chair, from those that the odometry reports; the same where nothing is known
        of its errors. These stay as the last image left them, so that no estimate has to be made for it."""
        last = self._bank.last
        if last is None:
            return v, omega
        e_s, e_t, e_d, b = last.mean[3:].tolist()
        v = v / (1.0 + e_s)
        return v, (omega - b - e_d * v) / (1.0 + e_t)

    def measurements_since(self, stamp: float) -> list[tuple[Instant, Measurement]]:
        """What was used of images taken at or after `stamp`: the chair then, and the dock in odom."""
        states = self._bank.chosen.states
        return [(state.instant, state.measurement) for state in states if state.instant.stamp >= stamp]

    def _take(self, stamp: float, hypotheses: list[Hypothesis]) -> Fusion:
        if not hypotheses:
            return Fusion(outcome=Outcome.EMPTY)
        if self._is_ahead(stamp):
            self._waiting.append((stamp, hypotheses))
            return Fusion(outcome=Outcome.WAITING)
        chair = self.odometry.at(stamp)
        if chair is None:
            return Fusion(outcome=Outcome.NO_ODOMETRY)
        offered = self._offers.look(chair, hypotheses)
        if isinstance(offered, Outcome):
            return Fusion(outcome=offered)
        self.images.show(chair, offered)
        if self._bank.last is None:
            return Fusion(outcome=self._acquire(chair, offered))
        return self._fuse(chair, offered)

    def _is_ahead(self, stamp: float) -> bool:
        """Whether the odometry of that time is still to come, if it comes as regularly as before."""
        newest, period = self.odometry.newest, self.odometry.period
        if newest is None or not stamp - newest.stamp > self.parameters.max_extrapolation:
            return False
        return stamp <= newest.stamp + 2.0 * period

    def _acquire(self, chair: Instant, offered: list[Measurement]) -> Outcome:
        if self._prior is not None:
            offered = [m for m in offered if math.dist(m.pose[:2], self._prior[:2]) <= self._prior_radius]
        moving = self._is_moving(chair)
        must_stand = self._standing and not self._moving_allowed
        if not offered or (must_stand and moving):
            if must_stand and moving:
                self._candidates.clear()
            return Outcome.ACQUIRING
        agreed = self._candidates.offer(chair, offered)
        if agreed is None:
            return Outcome.ACQUIRING
        self._begin(agreed)
        return Outcome.ACQUIRED

    def _is_moving(self, chair: Instant) -> bool:
        p = self.parameters
        return abs(chair.v) > p.acquire_speed or abs(chair.omega) > p.acquire_speed + 2.0 * p.gyro_bias_sd

    def _begin(self, agreed: Agreement) -> None:
        self._branches.begin(agreed.series, agreed.other, agreed.odds)
        self._candidates.clear()
        self._rejected.clear()

    def _fuse(self, chair: Instant, offered: list[Measurement]) -> Fusion:
        if not self._bank.covers(chair.stamp):
            return Fusion(outcome=Outcome.STALE)
        settled = self._bounded and self._is_near(chair, self._bank.chosen.states[-1].mean[:3])
        fusion = self._branches.take(chair, offered, settled=settled)
        if fusion.outcome.accepted:
            self._rejected.clear()
            return fusion
        if self._standing and not self._moving_allowed and self._is_moving(chair):
            self._rejected.clear()  # what agrees while it drives may be a fault of what it drives by
            return fusion
        agreed = self._rejected.offer(chair, offered)
        if agreed is None:
            return fusion
        too_far = self._too_far(chair, agreed.series)
        if too_far is not None and self._was_mirrored(chair, agreed.series):
            self._begin(agreed)
            return Fusion(outcome=Outcome.ACQUIRED, innovation=fusion.innovation, measurement=agreed.series[-1][1])
        self.elsewhere = too_far if self._bounded else None
        if self.elsewhere is not None:
            return Fusion(outcome=Outcome.ELSEWHERE, innovation=fusion.innovation)
        self._begin(agreed)
        return Fusion(outcome=Outcome.REACQUIRED, innovation=fusion.innovation, measurement=agreed.series[-1][1])

    def _was_mirrored(self, chair: Instant, series: Series) -> bool:
        """Whether the dock was known by the mirror image of what these images show."""
        known = self.estimate(chair.stamp)
        if known is None or self._front is None:
            return False
        shown = combine([measurement for _, measurement in series]).pose
        return not self._is_near(chair, shown) and mirrors(chair.pose, self._front, known.pose, shown)

    def _is_near(self, chair: Instant, dock: Array) -> bool:
        """Whether the markers of a dock (3,) in odom are."""
        return self._front is not None and math.dist(chair.pose[:2], compose(dock, self._front)[:2]) < _OPEN

    def _too_far(self, chair: Instant, series: Series) -> tuple[float, float] | None:
        """How far [m, rad] the dock has moved in a way that no drift within the bounds explains, nor what was doubtful
        when it was last seen; None: near enough."""
        known, last, p = self.estimate(chair.stamp), self._bank.last, self.parameters
        assert known is not None and last is not None  # only a known dock is acquired again
        shown = combine([measurement for _, measurement in series])
        way, turn = apart(chair.pose, known.pose, shown.pose)
        doubt = last.covariance[:3, :3] + shown.covariance
        sd_way = sd_of_place(doubt, math.dist(chair.pose[:2], shown.pose[:2]))
        sd_turn = math.sqrt(float(doubt[2, 2]))
        near = way <= p.reacquire_distance + _CERTAIN * sd_way and abs(turn) <= p.reacquire_turn + _CERTAIN * sd_turn
        return None if near else (way, turn)

    def _wander(self, dock: Array, before: Instant, now: Instant) -> Array:
        """Covariance (3, 3) of how far the odometry of a slipping chair may have moved the dock between two images."""
        p, first = self.parameters, before if before.stamp <= now.stamp else now
        F, Q = self._slipping.transition(dock, first, now if first is before else before)
        spread = np.diag(
            [0.0, 0.0, 0.0, p.scale_sd**2, p.heading_scale_sd**2, p.heading_drift_sd**2, p.gyro_bias_sd**2]
        )
        return np.asarray((F @ spread @ F.T + Q)[:3, :3])
