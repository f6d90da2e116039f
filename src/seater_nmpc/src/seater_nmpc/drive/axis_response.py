"""How an axis responds to commands, learned while driving: its deadband, and its delay and lag.

A set of hypotheses: each a deadband of some width and kind, with some delay and lag. Each predicts the speed from the
commands that were sent; what is measured is compared with that in short windows, by a heavy-tailed (Cauchy) measure
since castors and bumps push the chair, too. Large steady commands say nothing about delay, lag or the width of a jump:
the predictions are the same. What is believed changes only when another hypothesis is ahead by a margin. Each has its
own gain (gains.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.drive.axis import AxisDrive
from seater_nmpc.drive.gains import Gains

Array = NDArray[np.float64]

_WINDOW = 0.1  # [s] over which speeds are averaged before they are compared
_FORGETTING = 0.025  # of the evidence with each window: a slight misfit must not add up for ever
_MARGIN = 4.0  # in log likelihood, by which another hypothesis has to be ahead
_MOST = 25.0  # so far at most can one fall behind: what was true can change
_PRIOR, _PRIOR_OFFSET = 1.0, 1.0  # penalties of deadbands that are not the configured one, and of offsets
_PRIOR_TIMING, _TYPICAL_ERROR = 1.0, 0.1  # penalty of times that differ from the configured ones by so much [s]
_DELAYS = (-0.15, -0.1, -0.05, 0.0, 0.05, 0.1, 0.15)  # [s] added to the configured delay
_LAGS = (0.1, 0.4, 0.7, 1.0, 1.4, 1.8, 2.6, 3.5)  # times the configured lag
_GAP = 0.5  # [s] between two measurements after which the prediction begins anew
_GAIN_NOISE = 3.0  # times the noise of a window: what hills, castors and carpets do lasts for many of them
_FASTEST = 10.0  # [m/s or rad/s] beyond that it is no measurement of a chair


@dataclass(frozen=True)
class Expected:
    """What is thought possible of an axis beside what is configured."""

    widths: tuple[float, ...]  # deadbands [m/s or rad/s]
    typical: float  # the one that comes first among equals
    noise: float  # standard deviation of a speed averaged over a window


class AxisResponseEstimator:
    """Of one axis. Feed it what was commanded and what was measured; `drive` is the deadband that is believed in."""

    def __init__(self, configured: AxisDrive, delay: float, lag: float, expected: Expected) -> None:
        """`delay`, `lag` [s]: as configured."""
        self._drives = _deadbands(configured, expected)
        self.delays = sorted({max(0.0, delay + change) for change in _DELAYS})  # [s] that are thought possible
        self.lags = [factor * lag for factor in _LAGS] if lag > 0.0 else [0.0]
        self._lag = np.array(self.lags)[None, :, None]
        self._width = np.array([each.deadband for each in self._drives])
        self._offset = np.array([each.offset for each in self._drives])
        self._noise, self._gain = expected.noise, configured.gain
        self._prior = np.zeros((len(self.delays), len(self.lags), len(self._drives)))  # (delay, lag, deadband)
        self._prior += _PRIOR_TIMING * np.abs(np.array(self.delays) - delay)[:, None, None] / _TYPICAL_ERROR
        self._prior += _PRIOR_TIMING * np.abs(np.array(self.lags) - lag)[None, :, None] / _TYPICAL_ERROR
        self._prior += _prior(self._drives, expected)
        self._cost, self._drive = self._prior.copy(), 0
        self._gains = Gains(self._prior.shape, _GAIN_NOISE * expected.noise)
        self._add_up()
        self.restart()

    def restart(self) -> None:
        """The chair stands, nothing acts; what was learned stays."""
        self._speed = np.zeros_like(self._cost)
        self._difference = np.zeros_like(self._cost)
        self._begin_window()

    def _begin_window(self) -> None:
        self._measured, self._predicted, self._time, self._weight = 0.0, np.zeros_like(self._cost), 0.0, 1.0

    def _add_up(self) -> None:
        """The costs change with each window; they, and what follows from them, are asked for with each message."""
        self._costs = self._cost + self._gains.costs
        self._believed: AxisDrive | None = None
        self._delay_costs: Array | None = None
        self._lag_costs: tuple[int, Array] | None = None

    @property
    def drive(self) -> AxisDrive:
        """The deadband that is believed in, with the gain of the likeliest delay and lag."""
        if self._believed is None:
            costs, gains = self._costs[:, :, self._drive], self._gains.values[:, :, self._drive]
            drive = self._drives[self._drive]
            self._believed = replace(drive, gain=drive.gain * float(gains.flat[np.argmin(costs)]))
        return self._believed

    def difference(self) -> float:
        """Measured less expected speed in the last window: the smallest of all delays and lags that explain about as
        well what was measured so far. While a command changes, a delay that is not known yet looks like a chair that
        turns by itself."""
        costs, differences = self._costs[:, :, self._drive], self._difference[:, :, self._drive]
        likely = differences[costs <= costs.min() + _MARGIN]
        least, most = float(likely.min()), float(likely.max())
        return max(least, 0.0) + min(most, 0.0)

    def delay_costs(self) -> Array:
        """How badly each of `delays` explains what was measured, as a negative log likelihood."""
        if self._delay_costs is None:
            self._delay_costs = np.asarray(self._costs.min(axis=(1, 2)))
        return self._delay_costs

    def lag_costs(self, delay: int) -> Array:
        """The same of each of `lags`, given a delay (an index)."""
        if self._lag_costs is None or self._lag_costs[0] != delay:
            self._lag_costs = delay, np.asarray(self._costs[delay].min(axis=1))
        return self._lag_costs[1]

    def add(
        self, start: float, end: float, commanded: Callable[[float, float], float], measured: float, *, weight: float
    ) -> None:
        """`measured` was the speed between two times [s]; `commanded(start, end)`: mean of what was sent between two
        times, whenever it acts. `weight`, 0 to 1: how much it says about the motors."""
        duration = end - start
        if duration > _GAP or abs(measured) > _FASTEST:
            self.restart()
            return
        self._weight = min(self._weight, weight)
        commands = np.array([commanded(start - delay, end - delay) for delay in self.delays])[:, None, None]
        self._predicted += duration * self._advance(duration, commands)
        self._measured += duration * measured
        self._time += duration
        if self._time >= _WINDOW:
            self._compare()

    def _advance(self, duration: float, commands: Array) -> Array:
        """Mean speeds over a time in which these acted; the speeds are then those at its end."""
        size = np.abs(commands)
        beyond = size - self._width
        target = np.sign(commands) * self._gain * np.where(beyond > 0.0, np.where(self._offset, beyond, size), 0.0)
        decay = np.exp(-duration / np.maximum(self._lag, 1e-6))
        away = self._speed - target
        self._speed = target + away * decay
        return np.asarray(target + away * (1.0 - decay) * self._lag / duration)

    def _compare(self) -> None:
        measured, predicted = self._measured / self._time, self._predicted / self._time
        self._difference = measured - self._gains.values * predicted
        if self._weight > 0.0:
            square = (self._difference / self._noise) ** 2
            forgetting = self._weight * _FORGETTING
            self._cost = self._prior + (1.0 - forgetting) * (self._cost - self._prior)
            self._cost += self._weight * np.log1p(square)
            self._cost = np.minimum(self._cost - self._cost.min(), _MOST + self._prior)
            self._gains.add(predicted, measured, self._weight, forgetting)
            self._add_up()
            self._drive = better(self._costs.min(axis=(0, 1)), self._drive, _MARGIN)
        self._begin_window()


def _deadbands(configured: AxisDrive, expected: Expected) -> list[AxisDrive]:
    different = [w for w in (0.0, *expected.widths) if abs(w - configured.deadband) > 1e-3 * expected.typical]
    jump = [AxisDrive(configured.gain, width, False) for width in different]
    return [configured, *jump, *(AxisDrive(configured.gain, width, True) for width in expected.widths)]


def _prior(drives: list[AxisDrive], expected: Expected) -> Array:
    width = np.array([each.deadband for each in drives])
    prior = np.where([each.offset for each in drives], _PRIOR_OFFSET, 0.0) + _PRIOR
    prior += 0.3 * np.abs(np.log(np.maximum(width, 0.1 * expected.typical) / expected.typical))
    prior[0] = 0.0
    return np.asarray(prior)


def better(costs: Array, believed: int, margin: float) -> int:
    """The cheapest, if it is ahead of the believed one by the margin; else that."""
    best = int(np.argmin(costs))
    return best if costs[best] < costs[believed] - margin else believed
