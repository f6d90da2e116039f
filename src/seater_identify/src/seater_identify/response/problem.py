"""The least-squares problem of one axis: separable (Golub and Pereyra 1973).

For each delay, lag, ramp and deadband the gain and the disturbances (weak priors) are a linear problem. Residuals count
less the farther out they lie (Huber). Slow and fast motion have standard deviations of their own: ticks of the encoders
disturb the one, floor and motors the other.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_identify.response.data import AxisData
from seater_identify.response.disturbances import PRIOR_SD, SWING, Disturbances, way_since_change
from seater_identify.response.model import AxisModel, grid_of, lagged, mean_speeds

Array = NDArray[np.float64]

HUBER = 2.5  # robust standard deviations beyond which a residual counts linearly
SLOW = 0.3  # of the typical speed
# [s] after the demand has become zero a brake may hold the wheels; what is measured from then on is left out for
# RELEASE, because it says nothing about the lag.
BRAKE, RELEASE = 0.15, 2.0
UNLIKE = 0.1  # share by which the deadbands of both ways usually differ
SWINGING = 0.2  # weight of what is measured while the castors swing round
SMALLEST_SD = 0.001  # of the typical speed: a simulation without noise


class AxisProblem:
    """Residuals of one axis as a function of the free parameters, an array in the order of `free`."""

    def __init__(self, data: AxisData, free: tuple[str, ...], offset: bool, trailing: bool = False) -> None:
        """`trailing`: castors brake at any rate alike; not to be told from a deadband that is taken off (`offset`)."""
        self.data, self.free, self.offset, self.trailing = data, free, offset, trailing
        self._grid = grid_of(data.begin, data.end)
        self.sd = np.where(np.abs(data.measured) < SLOW * data.unit, 0.015, 0.05) * data.unit
        self.huber = np.ones(len(data.measured))
        self._extra = Disturbances(data, trailing)
        self.prior = np.array([PRIOR_SD[name] for name in self._extra.names])

    def model(self, parameters: Array) -> AxisModel:
        """The model with these values of the free parameters."""
        values = dict(zip(self.free, np.abs(parameters).tolist(), strict=True))
        return AxisModel(offset=self.offset, **values)

    def columns(self, model: AxisModel) -> Array:
        """(n, 1 + disturbances): the answer with gain 1, then what disturbs it."""
        speed = lagged(self.data.commands.demand(self._grid, model), model.lag)
        answer = mean_speeds(speed, self._grid, self.data.begin, self.data.end)
        return np.column_stack([answer, *self._extra.columns(answer)])

    def solve(self, model: AxisModel) -> tuple[Array, Array]:
        """Linear coefficients (1 + d,) and predicted speeds (n,)."""
        A = self.columns(model)
        root = np.sqrt(self.huber) / self.sd
        penalty = np.zeros((A.shape[1] - 1, A.shape[1]))
        penalty[:, 1:] = np.diag(1.0 / self.prior)
        left = np.vstack([A * root[:, None], penalty])
        right = np.concatenate([self.data.measured * root, np.zeros(len(penalty))])
        coefficients = np.linalg.lstsq(left, right, rcond=None)[0]
        return coefficients, A @ coefficients

    def residuals(self, parameters: Array) -> Array:
        """(n + d,) weighted, with those of the priors."""
        coefficients, predicted = self.solve(self.model(parameters))
        weighted = np.sqrt(self.huber) * (self.data.measured - predicted) / self.sd
        return np.concatenate([weighted, coefficients[1:] / self.prior, [self._unlike(parameters)]])

    def _unlike(self, parameters: Array) -> float:
        """The prior that the deadbands of both ways are alike: a slope moves their difference, too."""
        plus, minus = (parameters[self.free.index(f"deadband_{way}")] for way in ("plus", "minus"))
        return float((plus - minus) / (UNLIKE * 0.5 * (plus + minus) + 0.001 * self.data.unit))

    def reweight(self, parameters: Array) -> None:
        """Standard deviations and Huber's weights from the residuals at these parameters."""
        residual = self.data.measured - self.solve(self.model(parameters))[1]
        speed = np.abs(self.data.measured) + np.abs(self.data.measured - residual)
        slow = (speed > 1e-6) & (speed < 2.0 * SLOW * self.data.unit)
        fast = speed >= 2.0 * SLOW * self.data.unit
        for group in (slow, fast):
            if np.count_nonzero(group) > 10:
                sd = 1.4826 * float(np.median(np.abs(residual[group])))
                self.sd[group] = max(sd, SMALLEST_SD * self.data.unit)
        self.sd[~slow & ~fast] = np.max(self.sd[slow], initial=SMALLEST_SD * self.data.unit)
        self.huber = np.minimum(1.0, HUBER * self.sd / np.maximum(np.abs(residual), 1e-12))
        way = way_since_change(self.data.measured, self.data.other, self.data.end - self.data.begin, self.data.unit)
        self.huber[way < SWING[-1] * self.data.settling] *= SWINGING
        idle = self._idle(self.model(parameters))
        self.huber[(idle > BRAKE) & (idle < RELEASE)] = 0.0

    def _idle(self, model: AxisModel) -> Array:
        """(n,) [s] for which the demand has been zero at the end of each increment."""
        demand = self.data.commands.demand(self._grid, model)
        asked = np.where(np.abs(demand) > 1e-3 * self.data.unit, self._grid, -np.inf)
        last = np.maximum.accumulate(asked)
        return self.data.end - last[np.searchsorted(self._grid, self.data.end) - 1]

    def steps(self, parameters: Array) -> Array:
        """Differences for derivatives: wide enough to see over the steps of the commands and the deadband's edge."""
        least = [0.004 if name in ("delay", "lag") else 0.003 * self.data.unit for name in self.free]
        return np.maximum(0.03 * np.abs(parameters), least)

    def jacobian(self, parameters: Array) -> Array:
        """(n, parameters + 1 + d) of the predicted speeds."""
        coefficients, _ = self.solve(self.model(parameters))
        columns = []
        for index, (value, step) in enumerate(zip(parameters, self.steps(parameters), strict=True)):
            up, down = parameters.copy(), parameters.copy()
            up[index], down[index] = value + step, max(value - step, 0.0)
            difference = self.columns(self.model(up)) - self.columns(self.model(down))
            columns.append(difference @ coefficients / (up[index] - down[index]))
        return np.column_stack([*columns, self.columns(self.model(parameters))])
