"""How the speed of one axis answers to its commands: delay, ramp of the motor controller, deadband, lag.

What lies inside the deadband moves nothing; the demand follows the rest of the delayed command within the ramp; the
speed follows the demand as a first-order lag (Hammerstein model: a static curve, then a linear system; Giri and Bai,
Block-oriented Nonlinear System Identification, Springer 2010). Gains are left out: they are linear in the answer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]

STEP = 0.005  # [s] of the time grid; times in between are interpolated
SMOOTHING = 0.02  # of the command: the deadband's edge is rounded by so much, so that the fit has a slope there
# Commands rise in steps, which a ramp smooths even where it is steeper than they; seen through it, half a step late at
# most. Motor controllers are usually about so much quicker than docking asks for.
USUAL_RAMP = 2.2
NO_RAMP = 100.0  # [m/s^2], [rad/s^2] a demand that jumps


@dataclass(frozen=True)
class AxisModel:
    """Of one axis, in m or rad."""

    delay: float  # [s]
    lag: float  # [s]
    ramp: float | None = None  # [1/s^2]; None: unknown, steeper than the commands
    deadband_plus: float = 0.0  # [1/s] largest positive command that does not move the chair
    deadband_minus: float = 0.0  # the same for negative ones, a positive number
    offset: bool = False  # True: beyond the deadband the speed is command - deadband; False: the command


class Commands:
    """Commands of one axis as steps in time. `assumed_ramp` [1/s^2] holds where none is fitted."""

    def __init__(self, times: Array, values: Array, timeout: float = 0.6) -> None:
        """Times sent (n,) [s], values (n,). Where commands end for `timeout` [s], zero is taken."""
        gaps = np.flatnonzero(np.diff(times) > timeout)
        self.times = np.insert(times, gaps + 1, times[gaps] + timeout)
        self.values = np.insert(values, gaps + 1, 0.0)
        steepest = self.steepest()
        self.assumed_ramp = USUAL_RAMP * steepest if steepest > 0.0 else NO_RAMP

    def steepest(self) -> float:
        """[1/s^2] slope that the commands reach for a time: a ramp above it cannot be told from none."""
        if len(self.times) < 8:
            return 0.0
        width = 5
        slopes = np.abs(self.values[width:] - self.values[:-width]) / (self.times[width:] - self.times[:-width])
        return float(np.percentile(slopes, 99.0)) if len(slopes) else 0.0

    def demand(self, grid: Array, model: AxisModel) -> Array:
        """The demand at the times of the grid, after deadband, delay and ramp."""
        ramp, values = model.ramp or self.assumed_ramp, active(self.values, model)
        changes = np.append(True, np.diff(values) != 0.0)  # most commands repeat the one before
        times, values = self.times[changes], values[changes]
        knots, levels = [times[0] - 1.0], [0.0]
        demand, before = 0.0, times[0] - 1.0
        for index, (start, value) in enumerate(zip(times.tolist(), values.tolist(), strict=True)):
            if start > before:
                knots.append(start)
                levels.append(demand)
            end = times[index + 1] if index + 1 < len(times) else math.inf
            needed = abs(value - demand) / ramp
            if start + needed <= end:
                demand = value
                before = start + needed
            else:
                demand += math.copysign(ramp * (end - start), value - demand)
                before = end
            if before > knots[-1]:
                knots.append(before)
                levels.append(demand)
        return np.interp(grid - model.delay, knots, levels)


def active(command: Array, model: AxisModel) -> Array:
    """The part of commands that moves the chair."""
    result = np.zeros_like(command)
    for sign, edge in ((1.0, model.deadband_plus), (-1.0, model.deadband_minus)):
        side = np.maximum(sign * command, 0.0)
        if edge <= 0.0:
            result += sign * side
        else:
            over = 1.0 / (1.0 + np.exp(-np.clip((side / edge - 1.0) / SMOOTHING, -60.0, 60.0)))
            result += sign * over * np.maximum(side - (edge if model.offset else 0.0), 0.0)
    return result


def lagged(values: Array, lag: float) -> Array:
    """First-order lag of a signal on the grid that is linear between its points, exactly."""
    if lag < 1e-4:
        return values
    decay = math.exp(-STEP / lag)
    share = (1.0 - decay) * lag / STEP
    return np.asarray(lfilter([1.0 - share, share - decay], [1.0, -decay], values))


def grid_of(begin: Array, end: Array) -> Array:
    """Times on which a recording of these increments is simulated."""
    return np.asarray(np.arange(begin[0] - 2.0, end[-1] + 2.0 * STEP, STEP))


def mean_speeds(speed: Array, grid: Array, begin: Array, end: Array) -> Array:
    """Mean of a speed on the grid between the times begin and end, each (n,)."""
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * STEP)])
    return (np.interp(end, grid, way) - np.interp(begin, grid, way)) / (end - begin)
