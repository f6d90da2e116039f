"""Where the standing chair is in the dock frame: the mean of what the camera says with certainty."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.se2 import inverse, wrap_angle

Array = NDArray[np.float64]

MEMORY = 30.0  # [s] of odometry and measurements
STILL = 0.0005  # [m] of odometry within which the chair stands; ticks of an encoder are finer
TURNING = 0.02  # [rad/s] more than a gyro's bias: the chair turns
SETTLED = 0.3  # [s] after the last motion, until a castor and the camera's pole are quiet
SHORTEST, FEWEST = 2.0, 15  # [s] of standing and certain measurements in it
CERTAIN = (0.005, 0.01)  # [m], [rad] largest standard deviation of a measurement
ALONE = 0.99  # least probability of a measurement's hypothesis
OUTLIER = 4.0  # robust standard deviations
SPREAD = (0.002, 0.004)  # [m], [rad] largest standard deviation of the measurements about their mean


class TeachError(ValueError):
    """Nothing can be taught now; the message says what to do."""


@dataclass(frozen=True, eq=False)
class Measurement:
    """pose: (3,) base_link in the dock frame; spread: (3,) sd of one measurement; in so many over `duration` [s]."""

    pose: Array
    spread: Array
    count: int
    duration: float


class Standing:
    """Takes odometry and measurements as they come; `measure` at any time."""

    def __init__(self) -> None:
        self._odometry: deque[tuple[float, float, float, float]] = deque()
        self._seen: deque[tuple[float, Array]] = deque()
        self._uncertain: deque[float] = deque()

    def odometry(self, stamp: float, pose: ArrayLike) -> None:
        """Pose of base_link in odom; what is not finite or older than the last is left out."""
        x, y, heading = np.asarray(pose, dtype=float).tolist()
        if not all(map(math.isfinite, (stamp, x, y, heading))) or (self._odometry and stamp <= self._odometry[-1][0]):
            return
        self._odometry.append((stamp, x, y, heading))
        for rows in (self._odometry, self._seen):
            while rows and rows[0][0] < stamp - MEMORY:
                rows.popleft()
        while self._uncertain and self._uncertain[0] < stamp - MEMORY:
            self._uncertain.popleft()

    def dock(self, stamp: float, T_base_dock: ArrayLike, covariance: Array, weight: float) -> None:
        """The dock (x, y, heading) in base_link with covariance (3, 3); `weight`: probability of this hypothesis."""
        pose = np.asarray(T_base_dock, dtype=float)
        if not (np.all(np.isfinite(pose)) and np.all(np.isfinite(covariance)) and math.isfinite(stamp)):
            return
        sd = np.sqrt(np.clip(np.diag(covariance), 0.0, None))
        if weight < ALONE or sd[0] > CERTAIN[0] or sd[1] > CERTAIN[0] or sd[2] > CERTAIN[1]:
            self._uncertain.append(stamp)
        else:
            self._seen.append((stamp, inverse(pose)))

    def since(self) -> float:
        """[s] for which the chair has stood, by the odometry."""
        if not self._odometry:
            return 0.0
        last, begin = self._odometry[-1], self._odometry[-1][0]
        for stamp, x, y, heading in reversed(self._odometry):
            turned = abs(wrap_angle(heading - last[3]))
            if math.hypot(x - last[1], y - last[2]) > STILL or turned > STILL + TURNING * (last[0] - stamp):
                break
            begin = stamp
        return last[0] - begin

    def measure(self) -> Measurement:
        """Raises TeachError: the chair does not stand, or is not seen with certainty, or what is seen contradicts."""
        stood = self.since() - SETTLED
        if not self._odometry:
            raise TeachError("no odometry arrives")
        if stood < SHORTEST:
            raise TeachError(
                f"the chair has stood for {max(stood, 0.0):.1f} s, {SHORTEST:g} s are needed: let it stand"
            )
        end = self._odometry[-1][0]
        rows = [(stamp, pose) for stamp, pose in self._seen if end - stood <= stamp <= end]
        if len(rows) < FEWEST:
            uncertain = sum(end - stood <= stamp <= end for stamp in self._uncertain)
            raise TeachError(
                f"{len(rows)} certain measurements of the dock while standing ({uncertain} uncertain ones), {FEWEST} "
                "are needed: are the markers in view, clean and evenly lit?"
            )
        return _mean(np.array([stamp for stamp, _ in rows]), np.array([pose for _, pose in rows]))


def _mean(stamps: Array, poses: Array) -> Measurement:
    """Without outliers. Raises TeachError when the rest scatters."""
    reference = poses[len(poses) // 2]
    off = poses - reference
    off[:, 2] = [wrap_angle(float(angle)) for angle in off[:, 2]]
    middle = np.median(off, axis=0)
    scale = 1.4826 * np.median(np.abs(off - middle), axis=0) + 1e-6
    kept = np.all(np.abs(off - middle) <= OUTLIER * scale, axis=1)
    mean, spread = off[kept].mean(axis=0), off[kept].std(axis=0, ddof=1)
    x, y, heading = reference + mean
    if max(spread[0], spread[1]) > SPREAD[0] or spread[2] > SPREAD[1]:
        raise TeachError(
            f"the measurements scatter by {1000 * max(spread[:2]):.1f} mm and {math.degrees(spread[2]):.2f} deg: does "
            "somebody lean on the chair, or does a marker hang loose?"
        )
    pose = np.array([x, y, wrap_angle(float(heading))])
    return Measurement(pose, spread, int(kept.sum()), float(stamps[kept][-1] - stamps[kept][0]))
