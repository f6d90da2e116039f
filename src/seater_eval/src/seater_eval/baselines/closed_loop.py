"""A controller in a closed loop with a perfect unicycle and perfect knowledge of its state."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from seater_common.geometry import Limits
from seater_common.se2 import arc_step, wrap_angle
from seater_eval.baselines.interface import PoseController
from seater_eval.baselines.trajectories import Array, Trajectory

Step = Callable[[Array, float, float, float], Array]


def euler_step(pose: Array, v: float, omega: float, duration: float) -> Array:
    """The paper's model (design, section 5): x + dt [v cos phi, v sin phi, omega]."""
    x, y, heading = pose
    return np.array(
        [x + duration * v * np.cos(heading), y + duration * v * np.sin(heading), wrap_angle(heading + duration * omega)]
    )


def arc_model(pose: Array, v: float, omega: float, duration: float) -> Array:
    """Exact motion with constant speeds."""
    return arc_step(pose, v, omega, duration)


def limited(
    command: tuple[float, float], before: tuple[float, float], limits: Limits, period: float, accelerations: bool = True
) -> tuple[float, float]:
    """What a motor controller makes of a command: speeds, and the change from `before`, within the limits."""
    v = min(max(command[0], -limits.v_reverse_max), limits.v_max)
    omega = min(max(command[1], -limits.omega_max), limits.omega_max)
    if accelerations:
        v = min(max(v, before[0] - limits.a_max * period), before[0] + limits.a_max * period)
        omega = min(max(omega, before[1] - limits.alpha_max * period), before[1] + limits.alpha_max * period)
    return float(v), float(omega)


def run_perfect(
    controller: PoseController,
    limits: Limits,
    start: ArrayLike,
    duration: float,
    *,
    model: Step = arc_model,
    accelerations: bool = True,
    until: Callable[[Array, tuple[float, float]], bool] | None = None,
) -> Trajectory:
    """The closed loop from rest at `start` (x, y, heading in the dock's frame), for `duration` [s] of simulated time.

    The speeds of a cycle hold until the next one. `accelerations`: whether the acceleration limits are applied to what
    the controller asks for. `until`: ends the run early (given pose and speeds).
    """
    controller.reset()
    pose, speed, period = np.asarray(start, dtype=float), (0.0, 0.0), controller.period
    poses, speeds, commands, wall, cpu, solves, failures = [pose], [speed], [], [], [], [], 0
    solves_cpu = []
    for _ in range(round(duration / period)):
        began, began_cpu = time.perf_counter(), time.thread_time()
        asked = controller.command(pose, speed)
        cpu.append(time.thread_time() - began_cpu)
        wall.append(time.perf_counter() - began)
        solves.append(getattr(controller, "solve_time", 0.0))
        solves_cpu.append(getattr(controller, "solve_cpu", 0.0))
        failures += bool(getattr(controller, "failed", False))
        speed = limited(asked, speed, limits, period, accelerations)
        pose = model(pose, *speed, period)
        poses.append(pose)
        speeds.append(speed)
        commands.append(speed)
        if until is not None and until(pose, speed):
            break
    times = period * np.arange(len(poses))
    return Trajectory(
        times,
        np.array(poses),
        np.array(speeds),
        np.array(commands),
        np.array(wall),
        np.array(cpu),
        np.array(solves),
        np.array(solves_cpu),
        failures,
    )
