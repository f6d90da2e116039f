"""The last phase of docking: standing, averaged fresh measurements, tolerance, charging contact."""

from __future__ import annotations

from enum import Enum

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Dock, Tolerance
from seater_common.se2 import compose, inverse, relative
from seater_nmpc.observe.measurement import difference, in_frame
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.sequence.rest.correction import Fresh, standing_measurement

Array = NDArray[np.float64]

_SHIFTED = np.array([0.004, 0.004, 0.007])  # [m, m, rad] between earlier and later images: not one place any more
_SURELY = 6.0  # and so many standard deviations, as the images scatter: what is told of them may be wrong
_LEAST = 1e-4  # [m, rad] that they scatter at least
_AS_LONG = 1.6  # times what the images take that are wanted, if all are good


class Verdict(Enum):
    """What verification says."""

    PENDING = "pending"
    MOVED = "the chair was moved while it was measured"
    DOCKED = "docked"
    OUTSIDE = "outside the tolerance"
    UNSEEN = "too few fresh measurements"
    NO_CONTACT = "the charging contact does not close"


def within(error: Array, tolerance: Tolerance) -> bool:
    """Whether the pose error (x, y, heading) of base_link in the dock's frame is within the tolerance."""
    return float(np.hypot(error[0], error[1])) <= tolerance.position and abs(float(error[2])) <= tolerance.heading


def moved(fresh: Fresh) -> bool:
    """Whether earlier and later images show the standing chair at two places: somebody moved it, unseen by its wheels.

    Student's t of the two means, for each place where the series may be cut.
    """
    shown = [in_frame(inverse(instant.pose), measurement).pose for instant, measurement in fresh]
    places = np.array([difference(pose, shown[0]) for pose in shown])
    n = len(places)
    for k in range(2, n - 1):
        before, after = places[:k], places[k:]
        shift = np.abs(after.mean(axis=0) - before.mean(axis=0))
        squares = k * before.var(axis=0) + (n - k) * after.var(axis=0)
        sd = np.sqrt((squares / (n - 2) + _LEAST**2) * (1.0 / k + 1.0 / (n - k)))
        if bool(np.any((shift > _SHIFTED) & (shift > _SURELY * sd))):
            return True
    return False


class Verification:
    """One verification, begun when the chair stands. If contact is required, it waits, nudges once, waits again."""

    def __init__(self, dock: Dock, parameters: SequenceParameters, require_contact: bool, now: float) -> None:
        self._dock, self._parameters, self._require_contact = dock, parameters, require_contact
        self._start = now
        self._T_odom_dock: Array | None = None
        self._wait_since = now
        self._nudge_from: Instant | None = None
        self._nudged = False
        self.covariance: Array | None = None  # (3, 3) of the dock in base_link, by the images' own noise
        self.error: Array | None = None  # (x, y, heading) of base_link in the dock's frame, once measured

    @property
    def nudged(self) -> bool:
        """Whether the chair was asked to move, for the contact."""
        return self._nudge_from is not None or self._nudged

    def update(self, now: float, chair: Instant, observer: DockObserver, contact: bool | None) -> tuple[float, Verdict]:
        """Speed to ask for [m/s], and the verdict. Speed is zero with every verdict but PENDING."""
        if self._T_odom_dock is None:
            fresh = observer.measurements_since(self._start)
            if len(fresh) < self._parameters.verify_measurements:
                wanted = self._parameters.verify_measurements
                patience = max(self._parameters.timeouts.verify, _AS_LONG * wanted * observer.images.period)
                late = now - self._start > patience
                return 0.0, Verdict.UNSEEN if late else Verdict.PENDING
            if moved(fresh):
                return 0.0, Verdict.MOVED
            standing = standing_measurement(fresh)
            self.covariance = standing.covariance
            self._T_odom_dock, self._wait_since = compose(chair.pose, standing.pose), now
        self.error = relative(self._T_odom_dock, chair.pose)
        if self._nudge_from is None and not self._nudged and not within(self.error, self._dock.tolerance):
            return 0.0, Verdict.OUTSIDE
        if not self._require_contact:
            return 0.0, Verdict.DOCKED
        if contact:
            docked = within(self.error, self._dock.contact_tolerance)
            return 0.0, Verdict.DOCKED if docked else Verdict.OUTSIDE
        return self._seek_contact(now, chair)

    def _seek_contact(self, now: float, chair: Instant) -> tuple[float, Verdict]:
        p = self._parameters
        if self._nudge_from is not None:
            longest = 2.0 * p.nudge_distance / p.nudge_speed
            if chair.driven - self._nudge_from.driven < p.nudge_distance and now - self._wait_since < longest:
                return p.nudge_speed, Verdict.PENDING
            self._nudge_from, self._nudged, self._wait_since = None, True, now
        if now - self._wait_since <= p.contact_wait:
            return 0.0, Verdict.PENDING
        if self._nudged:
            return 0.0, Verdict.NO_CONTACT
        self._nudge_from, self._wait_since = chair, now
        return p.nudge_speed, Verdict.PENDING
