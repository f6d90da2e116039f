"""What a standing chair makes of a short push, with what is not known about it: weighted hypotheses.

Each hypothesis has a threshold, up to which a command does nothing, and a resistance, by which the speed is smaller
than what the motors, behind their lag, would give (castors that point the wrong way, carpet, friction): a short push
may not overcome it though a long one does. Both are known from driving at best in part: a deadband that was never met,
castors that only a turn on the spot has to swing round. How far a push got tells them apart.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.drive.axis import AxisDrive

Array = NDArray[np.float64]

_THRESHOLDS = (np.arange(0.0, 0.055, 0.01), np.arange(0.0, 0.13, 0.02))  # [m/s], [rad/s]
_RESISTANCES = (np.arange(0.0, 0.05, 0.004), np.arange(0.0, 0.21, 0.02))
_TYPICAL = (0.006, 0.06)  # mean resistance beyond the known one, where there is any
_NONE = (0.7, 0.4)  # prior probability of no resistance beyond the known one
_LESS = 0.5  # of less than the known one
_KNOWN = 0.6  # and of the threshold that the drive has
_LAGS = 4.0  # for so many times the lag the motors run on
_NOISE = (0.0015, 0.003)  # [m, rad] of where the chair was seen before and after
_SHARE = 0.25  # of the way, by which it differs from push to push
_DOUBT = 0.01  # weight of what else may have happened, per push
_TOO_FAR = 3.0  # weight
_FORGOTTEN = 0.3  # of what was learned, when the castors have turned since


class MoveResponse:
    """Of one axis (`turning` or straight) in one direction."""

    def __init__(self, turning: bool, drive: AxisDrive, lag: float) -> None:
        """Before anything was tried, by what `drive` is known to do. `lag`: of the motors [s]."""
        i = int(turning)
        thresholds = np.union1d(_THRESHOLDS[i], drive.deadband)
        known = drive.deadband if drive.offset else 0.0
        resistances = np.union1d(_RESISTANCES[i], known)
        self._noise = _NOISE[i]
        self._gain = drive.gain
        self._lag = lag
        self._thresholds, self._resistances = thresholds, resistances
        by_threshold = np.where(thresholds == drive.deadband, _KNOWN, (1.0 - _KNOWN) / (len(thresholds) - 1))
        more = np.where(resistances > known, np.exp((known - resistances) / _TYPICAL[i]), 0.0)
        by_resistance = (1.0 - _NONE[i]) * more / more.sum()
        by_resistance[resistances == known] = _NONE[i]
        less = resistances < known
        if less.any():
            by_resistance = (1.0 - _LESS) * by_resistance + _LESS * less / less.sum()
        self._prior = np.outer(by_threshold, by_resistance)
        self._weights = self._prior

    @property
    def resistance(self) -> float:
        """Mean [m/s or rad/s]."""
        return float(self._weights.sum(axis=0) @ self._resistances)

    def ways(self, pushes: Array, period: float) -> Array:
        """How far each hypothesis gets (m, thresholds, resistances) with each of these `pushes` (m, k): commands, all
        positive, of `period` [s] each, with zeros after them."""
        steps = pushes.shape[1] + math.ceil(_LAGS * self._lag / period)
        keep = math.exp(-period / self._lag) if self._lag > 0.0 else 0.0
        commands = pushes[:, :, None]
        acting = np.where(commands > self._thresholds, commands, 0.0)
        speed, ways = np.zeros((len(pushes), len(self._thresholds))), 0.0
        for k in range(steps):
            speed = keep * speed + (1.0 - keep) * (acting[:, k] if k < pushes.shape[1] else 0.0)
            ways = ways + np.maximum(0.0, speed[:, :, None] - self._resistances)
        return np.asarray(self._gain * period * ways)

    def losses(self, pushes: Array, period: float, wanted: float) -> Array:
        """Mean square (m,) of what each push leaves of the way `wanted`; too far counts more, as the way back turns the
        castors round."""
        ways = self.ways(pushes, period)
        left = (ways - wanted) ** 2 * np.where(ways > wanted, _TOO_FAR, 1.0)
        return np.asarray(np.sum(self._weights * (left + (_SHARE * ways) ** 2), axis=(1, 2)))

    def learn(self, push: Array, period: float, way: float) -> None:
        """These commands (k,) brought the chair so far (negative: the other way)."""
        expected = self.ways(push[None, :], period)[0]
        variance = self._noise**2 + (_SHARE * expected) ** 2
        likelihood = np.exp(-0.5 * (way - expected) ** 2 / variance) / np.sqrt(variance)
        weights = self._weights * likelihood
        total = float(weights.sum())
        if total > 0.0:
            self._weights = (1.0 - _DOUBT) * weights / total + _DOUBT * self._prior

    def forget(self) -> None:
        """In part: the chair has moved otherwise since."""
        self._weights = (1.0 - _FORGOTTEN) * self._weights + _FORGOTTEN * self._prior
