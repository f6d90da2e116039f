"""The last phase of docking: standing, averaged fresh measurements, tolerance, charging contact."""

from __future__ import annotations

from enum import Enum

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Dock, Tolerance
from seater_common.se2 import compose, relative
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry import Instant
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.sequence.correction import standing_measurement

Array = NDArray[np.float64]

_AS_LONG = 1.6  # times what the images take that are wanted, if all are good


class Verdict(Enum):
    """What verification says."""

    PENDING = "pending"
    DOCKED = "docked"
    OUTSIDE = "outside the tolerance"
    UNSEEN = "too few fresh measurements"
    NO_CONTACT = "the charging contact does not close"


def within(error: Array, tolerance: Tolerance) -> bool:
    """Whether the pose error (x, y, heading) of base_link in the dock's frame is within the tolerance."""
    return float(np.hypot(error[0], error[1])) <= tolerance.position and abs(float(error[2])) <= tolerance.heading


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
                patience = max(self._parameters.timeouts.verify, _AS_LONG * wanted * observer.image_period)
                late = now - self._start > patience
                return 0.0, Verdict.UNSEEN if late else Verdict.PENDING
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
