"""What became of one image: how far its dock pose was from the expected one, and whether it was used."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.observe.measurement import Measurement, difference

Array = NDArray[np.float64]


class Outcome(IntEnum):
    """What became of the detections of one image; the numbers of seater_msgs/DockInnovation."""

    FUSED = 0  # passed the gate
    ACQUIRED = 1  # the first estimate was made from it and earlier ones
    REACQUIRED = 2  # outside the gate, but it and those before it agreed: they replaced the estimate
    ACQUIRING = 3  # kept, until enough of them agree on a first estimate
    GATE = 4  # outside the gate
    FLIP = 5  # no dock that stands on a floor: tilted, or too high or low
    INVALID = 6  # not finite, or a covariance that is none
    STALE = 7  # older than everything that is kept
    NO_ODOMETRY = 8  # none for the time of the image
    EMPTY = 9  # no dock in the image
    WAITING = 10  # kept, until the odometry of its time arrives
    FROZEN = 11  # the same poses as in the last image though the wheels have turned
    UNCERTAIN = 12  # its own covariance is too large to see by
    ELSEWHERE = 13  # agrees with earlier ones on a dock too far from where it was to go on with

    @property
    def accepted(self) -> bool:
        """Whether the estimate is made of it, too."""
        return self in (Outcome.FUSED, Outcome.ACQUIRED, Outcome.REACQUIRED)

    @property
    def text(self) -> str:
        """In words."""
        return self.name.lower().replace("_", " ")


@dataclass(frozen=True, kw_only=True)
class Innovation:
    """Measured minus expected pose of the dock in odom."""

    value: Array  # (3,) x [m], y [m], heading [rad], wrapped
    covariance: Array  # S, (3, 3): of the expectation, the measurement and what calibration leaves
    nis: float  # normalised innovation squared: value' S^-1 value
    gate: float  # NIS up to which it is fused
    log_det: float  # ln det S

    @property
    def gate_ratio(self) -> float:
        """NIS / gate; above 1: rejected."""
        return self.nis / self.gate

    @property
    def log_likelihood(self) -> float:
        """Log of the normal density of the value."""
        return -0.5 * (self.nis + self.log_det + 3.0 * math.log(2.0 * math.pi))

    @property
    def sd(self) -> Array:
        """Standard deviations of the value, (3,) [m, m, rad]."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True, kw_only=True)
class Fusion:
    """What the observer made of one image."""

    outcome: Outcome
    innovation: Innovation | None = None  # of the likeliest hypothesis, once there is an estimate to compare with
    measurement: Measurement | None = None  # of the poses that the image leaves open the one that this is about


def likeliest(
    offered: list[Measurement], poses: Array, covariances: Array, common: Array, gate: float
) -> list[tuple[Innovation, Measurement]]:
    """For each of k filters: of the poses that one image leaves open the one with the smallest
    NIS + ln det S - 2 ln(weight).

    `poses` (k, 3) and `covariances` (k, 3, 3) are of the expected pose; S is the latter, plus the measurement's own,
    plus `common`.
    """
    found: list[tuple[float, Innovation, Measurement] | None] = [None] * len(poses)
    for measurement in offered:
        S = covariances + measurement.covariance + common
        values = np.array([difference(measurement.pose, pose) for pose in poses])
        nis = (values[:, None, :] @ np.linalg.solve(S, values)[:, :, None])[:, 0, 0]
        log_det = np.linalg.slogdet(S)[1]
        favour = 2.0 * math.log(measurement.weight)
        for i, known in enumerate(found):
            score = float(nis[i]) + float(log_det[i]) - favour
            if known is None or score < known[0]:
                innovation = Innovation(
                    value=values[i], covariance=S[i], nis=float(nis[i]), gate=gate, log_det=float(log_det[i])
                )
                found[i] = score, innovation, measurement
    return [(entry[1], entry[2]) for entry in found if entry is not None]
