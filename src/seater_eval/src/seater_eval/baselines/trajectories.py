"""The record of a closed loop, and what the evaluation compares of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Tolerance
from seater_common.se2 import wrap_angle, wrap_angles

Array = NDArray[np.float64]
SAME = 1e-6  # [m/s], [rad/s] of commands


@dataclass
class Trajectory:
    """One run. Rows belong together; the last row is the end."""

    times: Array  # (n,) [s] from the start
    poses: Array  # (n, 3) true pose of base_link in the dock's frame
    speeds: Array  # (n, 2) true (v, omega)
    commands: Array = field(default_factory=lambda: np.zeros((0, 2)))  # (m, 2) one a control cycle
    cycle_times: Array = field(default_factory=lambda: np.zeros(0))  # (m,) wall time of the whole cycle [s]
    cycle_cpu: Array = field(default_factory=lambda: np.zeros(0))  # (m,) its time on the processor, this thread [s]
    solve_times: Array = field(default_factory=lambda: np.zeros(0))  # (m,) wall time in the solver [s]; 0 without one
    solve_cpu: Array = field(default_factory=lambda: np.zeros(0))  # (m,) the same on the processor, this thread [s]
    failures: int = 0  # cycles without a usable solution

    @property
    def final_position_error(self) -> float:
        """[m]"""
        return math.hypot(self.poses[-1, 0], self.poses[-1, 1])

    @property
    def final_heading_error(self) -> float:
        """[rad], not negative"""
        return abs(wrap_angle(float(self.poses[-1, 2])))

    def docking_time(self, tolerance: Tolerance) -> float | None:
        """The time from which on the chair is within the tolerance until the end [s]; None when it never is."""
        inside = within(self.poses, tolerance)
        if not inside[-1]:
            return None
        outside = np.flatnonzero(~inside)
        return float(self.times[outside[-1] + 1] if len(outside) else self.times[0])


def quickest(runs: Sequence[Trajectory]) -> Trajectory:
    """The same run, driven several times: each cycle at the shortest time it took. What delayed a cycle in one run and
    not in all of them was the machine and not the work.

    Raises ValueError when the commands differ, for then it was not the same run."""
    first = runs[0]
    if not all(_alike(first.commands, run.commands) for run in runs[1:]):
        raise ValueError("repeated runs differ: their cycles cannot be compared")

    def least(of: Callable[[Trajectory], Array]) -> Array:
        shortest: Array = np.minimum.reduce([of(run) for run in runs])
        return shortest

    return replace(
        first,
        cycle_times=least(lambda run: run.cycle_times),
        cycle_cpu=least(lambda run: run.cycle_cpu),
        solve_times=least(lambda run: run.solve_times),
        solve_cpu=least(lambda run: run.solve_cpu),
    )


def _alike(a: Array, b: Array) -> bool:
    """Solvers that keep their last solution begin elsewhere the second time: the same to their tolerance."""
    return a.shape == b.shape and np.allclose(a, b, rtol=0.0, atol=SAME)


def within(poses: Array, tolerance: Tolerance) -> NDArray[np.bool_]:
    """For each pose (n, 3) in the dock's frame, whether it is within the tolerance, (n,)."""
    heading = np.abs(wrap_angles(poses[:, 2]))
    result: NDArray[np.bool_] = (np.hypot(poses[:, 0], poses[:, 1]) <= tolerance.position) & (
        heading <= tolerance.heading
    )
    return result
