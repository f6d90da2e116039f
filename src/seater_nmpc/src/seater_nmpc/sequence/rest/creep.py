"""How fast, and how long, a standing chair creeps: fitted to the odometry of one stop, or of a small move and its stop.

While brakes are open, a chair on a slope rolls with a steady speed, and turns with one, beside what its motors make of
the command; when the brakes grip, both end at once. So its way along one axis is

    way(t) = gain * motor(t) + speed * open(t),    both constant from the moment on at which the brakes grip,

with motor(t) the way that a first-order lag makes of the commands (after a drive: of a speed that ends), and open(t)
the time since the brakes opened. Lag and delay are known about, the time until the brakes grip hardly: all are tried,
and of each the two factors follow by least squares (Bayesian linear regression: Bishop, Pattern Recognition and Machine
Learning, 3.3). What comes out is the mean over all, weighted by the evidence.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

HOLDS = np.concatenate([np.arange(0.1, 1.0, 0.05), np.arange(1.0, 2.6, 0.1)])  # [s] from the demand's end
_LAGS, _LAG_SD = np.exp(np.arange(-1.0, 1.1, 0.5)), 0.5  # times the one that is believed in; of its logarithm
_LAG = (0.08, 0.3)  # [s] that is believed in, at least and at most: a roll is learned as lag, too
_DELAYS, _DELAY_SD = np.arange(-0.15, 0.16, 0.05), 0.06  # [s] beside the one that is believed in
_GAIN_SD = 0.15  # [m/s or rad/s] of a drive's or push's speed
_HOLD_SD = 0.3  # [s] from stop to stop
_LONG = 1e3  # [s] that a chair has been driving, and its brakes have been open, before a stop


@dataclass(frozen=True)
class Creep:
    """Of one axis, as far as it is known."""

    mean: float = 0.0  # [m/s or rad/s] if it creeps
    sd: float = 0.02
    probability: float = 0.5  # that it creeps

    def before(self, drift: float) -> Creep:
        """Known of the next stop, that may differ by `drift` (standard deviation)."""
        return Creep(self.mean, math.hypot(self.sd, drift), min(max(self.probability, 0.1), 0.9))


@dataclass(frozen=True)
class Demand:
    """What was asked for until the chair was to stand."""

    ends: float  # [s], when the last command was followed by zero
    steps: tuple[tuple[float, float], ...] = ()  # (time [s], command) of a small move; none: it had been driving

    def shape(self, times: Array, delay: float, lags: Array) -> Array:
        """Way (lags, n) that motors make of it at `times` (n,), or of each lag its own (lags, n)."""
        if not self.steps:
            after, lag = times - self.ends - delay, lags[:, None]
            return np.where(after < 0.0, after, lag * -np.expm1(-np.maximum(after, 0.0) / lag))
        most = max(abs(command) for _, command in self.steps) or 1.0
        way, last = np.zeros(np.broadcast_shapes(times.shape, (len(lags), 1))), 0.0
        for at, command in (*self.steps, (self.ends, 0.0)):
            since, lag = np.maximum(times - at - delay, 0.0), lags[:, None]
            way += (command - last) / most * (since + lag * np.expm1(-since / lag))
            last = command
        return way

    @property
    def begins(self) -> float:
        """When the brakes were asked to open [s]."""
        return self.steps[0][0] if self.steps else self.ends - _LONG


def fit(
    times: Array, ways: Array, demand: Demand, delay: float, lag: float, known: Creep, hold: Array, noise: float
) -> tuple[Creep, Array]:
    """What `ways` (n,) [m or rad] at `times` (n,) [s], until the chair stands, show beyond what is `known`; and how
    likely each of HOLDS is if it creeps, given how likely it was, `hold`. `delay`, `lag` [s]: believed in. `noise`:
    standard deviation of each way."""
    lags = np.clip(lag, *_LAG) * _LAGS
    gains, opened = _shapes(times, demand, max(0.0, delay) + _DELAYS, lags)
    ways = (ways - ways[0]) / noise
    gains, opened = gains / noise, opened / noise
    prior = -0.5 * ((np.log(_LAGS) / _LAG_SD)[None, :, None] ** 2 + (_DELAYS / _DELAY_SD)[:, None, None] ** 2)
    a = np.sum(gains**2, axis=-1) + _GAIN_SD**-2
    b = np.sum(gains * opened, axis=-1)
    c = np.sum(opened**2, axis=-1) + known.sd**-2
    p, q = gains @ ways, opened @ ways + known.mean / known.sd**2
    determinant = a * c - b * b
    speed, spread = (a * q - b * p) / determinant, a / determinant
    explained = (c * p * p - 2.0 * b * p * q + a * q * q) / determinant - (known.mean / known.sd) ** 2
    creeps = prior + 0.5 * explained - 0.5 * np.log(determinant * (_GAIN_SD * known.sd) ** 2)
    stands = prior + 0.5 * p * p / a - 0.5 * np.log(a * _GAIN_SD**2)
    most = max(creeps.max(), stands.max())
    w, w0 = np.exp(creeps - most) * hold, float(np.sum(np.exp(stands - most) * hold))
    total = float(w.sum())
    odds = known.probability * total, (1.0 - known.probability) * w0
    if not total > 0.0:
        return Creep(known.mean, known.sd, odds[0] / max(sum(odds), 1e-300)), hold
    w /= total
    mean = float(np.sum(w * speed))
    variance = float(np.sum(w * (spread + (speed - mean) ** 2)))
    return Creep(mean, math.sqrt(variance), odds[0] / sum(odds)), w.sum(axis=(0, 1))


def likely_holds(known: Array | None) -> Array:
    """Of HOLDS, before a stop: as the ones before it had it, less surely."""
    if known is None:
        return np.full(len(HOLDS), 1.0 / len(HOLDS))
    blurred = np.exp(-0.5 * ((HOLDS[:, None] - HOLDS) / _HOLD_SD) ** 2) @ known + 0.1 / len(HOLDS)
    return np.asarray(blurred / blurred.sum())


def _shapes(times: Array, demand: Demand, delays: Array, lags: Array) -> tuple[Array, Array]:
    """Motor's way and time with open brakes (delays, lags, holds, n), from the first of `times` on."""
    gains, opened = [], []
    for delay in np.maximum(delays, 0.0):
        grip = demand.ends + delay + HOLDS
        moving = demand.shape(times, delay, lags)[:, None, :]
        stopped = demand.shape(grip, delay, lags)[:, :, None]
        gain = np.where(times < grip[:, None], moving, stopped)
        time = np.clip(times, demand.begins + delay, grip[:, None])
        gains.append(gain - gain[..., :1])
        opened.append(np.broadcast_to(time - time[:, :1], gain.shape))
    return np.array(gains), np.array(opened)
