"""What is told of a goal: each cycle a step, at the end the result with how sure it is."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Dock
from seater_nmpc.control.command import Command
from seater_nmpc.observe.observer import DockEstimate
from seater_nmpc.parameters import ObserverParameters
from seater_nmpc.sequence.goal.progress import Progress
from seater_nmpc.sequence.goal.results import Phase, Result, ResultCode, Step

Array = NDArray[np.float64]


def make_step(
    goal: Progress, now: float, dock: Dock, estimate: DockEstimate | None, command: Command, result: Result | None
) -> Step:
    """Of the cycle at message time `now` [s]; `estimate`: of the dock, None while it is not known."""
    error, distance = _off(goal, dock), -1.0
    if error is not None and goal.phase is Phase.UNDOCKING:
        distance = max(0.0, float(error[0]) - dock.predock_x)
    elif error is not None:
        distance = math.hypot(error[0], error[1])
    return Step(
        command=command,
        phase=goal.phase,
        elapsed=goal.deadlines.elapsed(now),
        result=result,
        distance=distance,
        lateral_error=0.0 if error is None else float(error[1]),
        heading_error=0.0 if error is None else float(error[2]),
        measurement_age=-1.0 if estimate is None else estimate.age,
        retries=goal.retries,
    )


def make_result(goal: Progress, now: float, dock: Dock, code: ResultCode, text: str, sd: tuple[float, float]) -> Result:
    """Of the goal that ends at message time `now` [s]; `sd`: standard deviations of the final error [m, rad]."""
    error = _off(goal, dock)
    x, y, heading = (float(value) for value in (np.zeros(3) if error is None else error))
    return Result(
        code=code,
        text=text,
        retries=goal.retries,
        duration=max(0.0, goal.deadlines.elapsed(now)),
        contact=bool(goal.contact),
        longitudinal_error=x,
        lateral_error=y,
        heading_error=heading,
        position_sd=sd[0],
        heading_sd=sd[1],
    )


def _off(goal: Progress, dock: Dock) -> Array | None:
    """The chair in the dock's frame (3,), or, where the goal ends at the predock point, from there."""
    if goal.error is None or not goal.staging:
        return goal.error
    return np.asarray(goal.error - [dock.predock_x, 0.0, 0.0])


def standard_deviations(
    covariance: Array, parameters: ObserverParameters, off: Array, spread: Array
) -> tuple[float, float]:
    """Of the final error [m, rad], the position's in the direction in which it is largest.

    The noise of the images (`covariance`, (3, 3)), what calibration leaves, and what the dockings so far say of the
    installation: by how much (x, y, heading) the docked chair seems to be `off` (3,) [m, m, rad], and the covariance
    of that, `spread` (3, 3).
    """
    position, heading = parameters.calibration_position, parameters.calibration_heading
    P = covariance + np.diag([position**2, position**2, heading**2]) + np.outer(off, off) + spread
    return math.sqrt(float(np.linalg.eigvalsh(P[:2, :2])[-1])), math.sqrt(float(P[2, 2]))
