"""What a standing chair makes of a short push, with what is not known about it: weighted hypotheses.

Each hypothesis has a threshold, up to which a command does nothing, and a resistance, by which the speed is smaller
than what the motors, behind their lag, would give (castors that point the wrong way, carpet, friction): a short push
may not overcome it though a long one does. Both are known from driving at best in part: a deadband that was never met,
castors that only a turn on the spot has to swing round. How far a push got tells them apart. On a slope a chair rolls
until its brakes hold: the way that it rolls after the end of a push is a third unknown of straight moves, and it rolls
as fast during the push (roll.py).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.drive.axis import AxisDrive
from seater_nmpc.sequence.rest.roll import Roll

Array = NDArray[np.float64]

_THRESHOLDS = (np.arange(0.0, 0.055, 0.01), np.arange(0.0, 0.13, 0.02))  # [m/s], [rad/s]
_RESISTANCES = (np.arange(0.0, 0.05, 0.004), np.arange(0.0, 0.21, 0.02))
_ROLLS = 0.004 * np.arange(-16, 17)  # [m] the way it is pushed
_LEVEL = 0.97  # prior probability that it does not roll, or no farther than while the motors run on
_TYPICAL_ROLL, _USUAL_ROLL = 0.006, 0.025  # [m] mean, where it does; most, where no stop has shown more
_OTHERWISE = 0.05  # probability that it rolls otherwise than stops have shown
_TYPICAL = (0.006, 0.06)  # mean resistance beyond the known one, where there is any
_NONE = (0.7, 0.4)  # prior probability of no resistance beyond the known one
_LESS = 0.5  # of less than the known one
_KNOWN = 0.6  # and of the threshold that the drive has
_LAGS = 4.0  # for so many times the lag the motors run on
_NOISE = (0.0015, 0.003)  # [m, rad] of where the chair was seen before and after
_SHARE = 0.25  # of the way, by which it differs from push to push,
_SWUNG = (0.03, 0.12)  # [m, rad] but not of what is beyond that: by then the castors have swung round
_DOUBT = 0.01  # weight of what else may have happened, per push
_TOO_FAR = 3.0  # weight
_FORGOTTEN = 0.3  # of what was learned, when the castors have turned since


class PushResponse:
    """Of one axis (`turning` or straight) in one direction."""

    def __init__(self, turning: bool, drive: AxisDrive, lag: float, other: PushResponse | None = None) -> None:
        """Before anything was tried, by what `drive` is known to do. `lag`: of the motors [s]. `other`: the same axis
        the other way; where the chair rolls, it rolls that way whichever way it is pushed."""
        self._hold = Roll().hold
        i = int(turning)
        self._thresholds = np.union1d(_THRESHOLDS[i], drive.deadband)
        known = drive.deadband if drive.offset else 0.0
        self._resistances = np.union1d(_RESISTANCES[i], known)
        self._rolls = np.zeros(1) if turning else _ROLLS
        self._noise, self._swung, self._gain, self._lag = _NOISE[i], _SWUNG[i], drive.gain, lag
        met = self._thresholds == drive.deadband
        by_threshold = _KNOWN * met + (1.0 - _KNOWN) * ~met / max(1, np.sum(~met))
        more, less = self._resistances > known, self._resistances < known
        by_resistance = _NONE[i] * (self._resistances == known) + (1.0 - _NONE[i]) * _decaying(
            self._resistances - known, more, _TYPICAL[i]
        )
        if less.any():
            by_resistance = (1.0 - _LESS) * by_resistance + _LESS * less / less.sum()
        level = np.abs(self._rolls) < 1e-9
        by_roll = level.astype(float)
        if other is not None:
            by_roll = other._weights.sum(axis=(0, 1))[::-1]
        elif not turning:
            size = np.abs(self._rolls)
            usual = _decaying(size, ~level & (size < _USUAL_ROLL), _TYPICAL_ROLL)
            by_roll = _LEVEL * level + (1.0 - _LEVEL) * usual
        self._prior = by_threshold[:, None, None] * by_resistance[:, None] * by_roll
        self._weights: Array = self._prior

    @property
    def resistance(self) -> float:
        """Mean [m/s or rad/s]."""
        return float(self._weights.sum(axis=(0, 2)) @ self._resistances)

    @property
    def roll(self) -> float:
        """Mean [m] that it rolls on, the way that it is pushed."""
        return float(self._weights.sum(axis=(0, 1)) @ self._rolls)

    def saw(self, roll: Roll, direction: float) -> None:
        """What stops have shown; `direction`: 1.0, where it is pushed ahead, or -1.0."""
        if len(self._rolls) == 1 or not roll.seen:
            return
        self._hold, way = roll.hold, min(max(direction * roll.way(), self._rolls[0]), self._rolls[-1])
        shown = np.exp(-0.5 * ((self._rolls - way) / roll.sd) ** 2)
        so_far = self._weights.sum(axis=(0, 1))
        by_roll = (1.0 - _OTHERWISE) * shown / shown.sum() + _OTHERWISE * so_far
        given_roll = self._weights / np.maximum(so_far, 1e-300)
        given_roll[:, :, so_far <= 0.0] = self._weights.sum(axis=2, keepdims=True)
        self._weights = given_roll * by_roll

    def _rolled(self, pushes: Array, period: float) -> Array:
        """How far each hypothesis rolls (m, 1, 1, rolls), during and after the push."""
        pushed = period * np.count_nonzero(pushes > 0.0, axis=1)
        return np.asarray(self._rolls * (1.0 + pushed / self._hold)[:, None, None, None])

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

    def _differs(self, ways: Array) -> Array:
        """Standard deviation of ways from push to push."""
        return np.asarray(_SHARE * np.minimum(ways, self._swung))

    def losses(self, pushes: Array, period: float, wanted: float, *, one_way: bool = False) -> Array:
        """Mean square (m,) of what each push leaves of the way `wanted`; too far counts more, as the way back turns the
        castors round (`one_way`: it does not, or they are turned anyway)."""
        ways = self.ways(pushes, period)[..., None]
        left = ways + self._rolled(pushes, period) - wanted
        square = left**2 * np.where(left > 0.0, 1.0 if one_way else _TOO_FAR, 1.0) + self._differs(ways) ** 2
        return np.asarray(np.sum(self._weights * square, axis=(1, 2, 3)))

    def learn(self, push: Array, period: float, way: float) -> None:
        """These commands (k,) brought the chair so far (negative: the other way)."""
        ways = self.ways(push[None, :], period)[0][..., None]
        variance = self._noise**2 + self._differs(ways) ** 2
        rolled = self._rolled(push[None, :], period)[0]
        likelihood = np.exp(-0.5 * (way - ways - rolled) ** 2 / variance) / np.sqrt(variance)
        weights = self._weights * likelihood
        total = float(weights.sum())
        if total > 0.0:
            self._weights = (1.0 - _DOUBT) * weights / total + _DOUBT * self._prior

    def forget(self) -> None:
        """In part: the chair has moved otherwise since."""
        self._weights = (1.0 - _FORGOTTEN) * self._weights + _FORGOTTEN * self._prior


def _decaying(values: Array, where: NDArray[np.bool_], typical: float) -> Array:
    """Probabilities of these values, exponential with that mean, of those `where` only."""
    weights = np.where(where, np.exp(-values / typical), 0.0)
    return weights / max(weights.sum(), 1e-12)
