"""What the controller asks the chair for, where it comes from, and how often what happened."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.solve.interface import Solution

Array = NDArray[np.float64]


class Status(IntEnum):
    """Where a command comes from; the numbers of seater_msgs/ControllerStatus."""

    SOLVED = 0
    TIME_LIMIT = 1
    FALLBACK_SHIFTED = 2
    FALLBACK_BRAKE = 3
    IDLE = 4


@dataclass(frozen=True, kw_only=True)
class Command:
    """What the chair is asked for, and how it came about."""

    v: float  # [m/s]
    omega: float  # [rad/s]
    status: Status = Status.IDLE
    solver: str = ""
    text: str = ""
    solve_time: float = 0.0  # wall time [s]
    solve_cpu: float = 0.0  # the solver's time on the processor, in this thread [s]
    iterations: int = 0
    cost: float = 0.0
    constraint_violation: float = 0.0  # largest violation in the plan [m or m/s]
    path: Array = field(default_factory=lambda: np.zeros((0, 3)))  # planned poses (N + 1, 3) in the common frame

    def after(self, solution: Solution | None, solve_cpu: float) -> Command:
        """The same, given in a cycle whose solution, if there is one, took that long and was of no use."""
        if solution is None:
            return self
        return replace(self, solve_time=solution.solve_time, solve_cpu=solve_cpu, iterations=solution.iterations)


@dataclass
class Counters:
    """How often what happened since the start of the program."""

    cycles: int = 0
    refused_inputs: int = 0  # non-finite
    time_limits: int = 0
    shifted: int = 0
    braked: int = 0
    obstacle_stops: int = 0  # braked as an obstacle or wall was within the stopping distance; not in `braked`
    consecutive_failures: int = 0  # cycles in a row that needed a fallback
