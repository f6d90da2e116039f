"""What deadband an axis has, learned from how it responds to small commands.

A set of hypotheses, each a deadband of some width and kind. Each predicts the speed from the commands that were sent;
what is measured is compared with that in short windows, by a heavy-tailed (Cauchy) measure since castors and bumps
push the chair, too. Large commands say nothing: all predict the same. A hypothesis has to be ahead of the configured
one, or of the one believed in, by a margin before it is believed.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.drive.axis import AxisDrive

Array = NDArray[np.float64]

_WINDOW = 0.1  # [s] over which speeds are averaged before they are compared
_MARGIN = 4.0  # in log likelihood, by which another hypothesis has to be ahead
_MOST = 25.0  # so far at most can one fall behind: what was true can change
_PRIOR, _PRIOR_OFFSET = 1.0, 1.0  # penalties of hypotheses that are not the configured one, and of offsets
_GAP = 0.5  # [s] between two measurements after which the prediction begins anew

Segments = Iterable[tuple[float, float]]  # (duration [s], command that acts)


class DeadbandEstimator:
    """Of one axis. Feed it what acted and what was measured; `drive` is what is believed."""

    def __init__(self, configured: AxisDrive, lag: float, widths: Iterable[float], typical: float, sd: float) -> None:
        """`lag` [s] of the motors; `widths`: deadbands that are thought possible beside the configured one, the
        `typical` one first among equals; `sd`: of the speed averaged over a window [m/s or rad/s]."""
        self._lag, self._sd = lag, sd
        different = [width for width in widths if abs(width - configured.deadband) > 1e-3 * typical]
        self._hypotheses = [configured]
        for offset in (False, True):
            self._hypotheses += [AxisDrive(configured.gain, width, offset) for width in different if width > 0.0]
        if configured.deadband > 0.0:
            self._hypotheses.append(AxisDrive(configured.gain, 0.0, False))
        self._width = np.array([each.deadband for each in self._hypotheses])
        self._offset = np.array([each.offset for each in self._hypotheses])
        self._prior = np.where(self._offset, _PRIOR_OFFSET, 0.0) + _PRIOR
        self._prior += 0.3 * np.abs(np.log(np.maximum(self._width, 0.1 * typical) / typical))
        self._prior[0] = 0.0
        self._cost = self._prior.copy()
        self._believed = 0
        self.restart()

    def restart(self) -> None:
        """The chair stands, nothing acts; what was learned stays."""
        self._speed = np.zeros(len(self._hypotheses))
        self._measured, self._predicted, self._time = 0.0, np.zeros(len(self._hypotheses)), 0.0

    @property
    def drive(self) -> AxisDrive:
        """What is believed."""
        return self._hypotheses[self._believed]

    def add(self, segments: Segments, measured: float) -> None:
        """Between the last measurement and this one the `segments` of commands acted; then `measured` was the speed."""
        duration = 0.0
        for length, command in segments:
            self._predicted += length * self._advance(length, command)
            duration += length
        if duration > _GAP:
            self.restart()
            self._speed[:] = measured
            return
        self._measured += duration * measured
        self._time += duration
        if self._time >= _WINDOW:
            self._compare()

    def _advance(self, length: float, command: float) -> Array:
        """Mean speeds over a segment; the speeds are then those at its end."""
        beyond = abs(command) - self._width
        size = np.where(beyond > 0.0, np.where(self._offset, beyond, abs(command)), 0.0)
        target = np.sign(command) * self._hypotheses[0].gain * size
        if self._lag <= 0.0:
            self._speed = target
            return target
        decay = np.exp(-length / self._lag)
        mean = target + (self._speed - target) * (1.0 - decay) * self._lag / length
        self._speed = target + (self._speed - target) * decay
        return mean

    def _compare(self) -> None:
        residual = (self._measured - self._predicted) / self._time / self._sd
        self._cost += np.log1p(residual**2)
        self._cost = np.minimum(self._cost - self._cost.min(), _MOST + self._prior)
        self._measured, self._predicted, self._time = 0.0, np.zeros(len(self._hypotheses)), 0.0
        best = int(np.argmin(self._cost))
        if self._cost[best] < self._cost[self._believed] - _MARGIN:
            self._believed = best
