"""By how much a chair is faster or slower than its motors are thought to make it: one gain for each hypothesis.

A seat that is raised halves what the joystick's full deflection means, a base that nobody calibrated is 10 % off, a
weak speed loop gives way to the load. The prediction of each hypothesis is linear in the gain, so that it is found by
least squares, with evidence that fades, robust weights, and a prior about the gain that is configured: slow driving
says little about it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_SD = 0.2  # of a gain about the configured one, which is 1 here
_LEAST, _MOST = 0.2, 1.6


class Gains:
    """`values` of one axis, in the shape of its hypotheses."""

    def __init__(self, shape: tuple[int, ...], noise: float) -> None:
        """`noise`: standard deviation [m/s or rad/s] of a measured mean speed about a right prediction."""
        self._noise2, self._prior = noise**2, (noise / _SD) ** 2
        self._square, self._product = np.zeros(shape), np.zeros(shape)
        self._before = np.zeros(shape)  # what was predicted for the last window
        self.values = np.ones(shape)

    def add(self, predicted: Array, measured: float, weight: float, forgetting: float) -> None:
        """Speeds that the hypotheses predict with a gain of 1, and the measured one. `forgetting`: share of the
        evidence so far that is lost where the new one says much; standing makes nobody forget."""
        square, expected = predicted * predicted, self._noise2 + (_SD * predicted) ** 2
        keep = 1.0 - forgetting * square / (square + self._prior)
        weights = weight / (1.0 + (measured - self.values * predicted) ** 2 / expected)  # what is far off is a push
        # While a speed changes, a delay or lag that is not known yet looks like a gain.
        weights = weights / (1.0 + (predicted - self._before) ** 2 / self._noise2)
        self._before = predicted
        self._square = keep * self._square + weights * square
        self._product = keep * self._product + weights * predicted * measured
        self.values = np.clip((self._prior + self._product) / (self._prior + self._square), _LEAST, _MOST)

    @property
    def costs(self) -> Array:
        """Of each value, as a negative log likelihood, by the prior alone."""
        return np.asarray(0.5 * ((self.values - 1.0) / _SD) ** 2)
