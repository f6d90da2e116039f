"""A chair written apart from the estimator and from seater_sim: plain Euler steps of 2 ms, quick to read."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair
from seater_identify.drive.driver import Driver, DriveState
from seater_identify.record.recording import Recording
from seater_identify.settings import IdentifySettings

Array = NDArray[np.float64]
DT = 0.002  # [s]


@dataclass(frozen=True)
class Truth:
    """Of the chair; axes: speed, turning rate."""

    delay: float = 0.16
    lag: tuple[float, float] = (0.21, 0.14)
    gain: tuple[float, float] = (0.96, 1.03)
    deadband: tuple[float, float] = (0.018, 0.04)
    ramp: tuple[float, float] = (2.0, 4.0)
    errors: tuple[float, float, float] = (0.015, -0.02, 0.01)  # odometry: scale, heading scale, drift
    tick: float = 0.0005  # [m] of odometry


def drive(truth: Truth, seed: int = 1, dock: bool = True, settings: IdentifySettings | None = None) -> Recording:
    """The scripted drive; commands reach the chair every 20 ms, odometry comes every 30 ms, images every 80 ms."""
    rng, settings = np.random.default_rng(seed), settings or IdentifySettings()
    driver = Driver(settings, Chair())
    demand, speed = np.zeros(2), np.zeros(2)
    pose, wheels, measured = np.array([-2.2, 0.0, 0.0]), np.zeros(2), np.zeros(2)
    seen_pose = np.zeros(3)
    queue: list[tuple[float, Array]] = []
    gain, deadband, lag = np.array(truth.gain), np.array(truth.deadband), np.array(truth.lag)
    limit, e = np.array(truth.ramp) * DT, truth.errors
    wanted, rows = np.zeros(2), {"command": [], "odometry": [], "dock": []}
    for now_ms in range(0, 150_000, 2):
        now = 1e-3 * now_ms
        if now_ms % 30 == 0:
            counted = np.round(wheels / truth.tick) * truth.tick
            way, turn = counted - measured
            measured = counted
            middle = seen_pose[2] + 0.5 * turn
            seen_pose = seen_pose + [way * math.cos(middle), way * math.sin(middle), turn]
            rows["odometry"].append([now, *seen_pose])
            driver.odometry(now, seen_pose, now)
        if now_ms % 20 == 0:
            if driver.state is DriveState.READY:
                driver.start(now)
            command = np.array(driver.command(now))
            rows["command"].append([now, *command])
            queue.append((now + truth.delay, command))
            if driver.state in (DriveState.DONE, DriveState.STOPPED):
                break
        if dock and now_ms % 80 == 0 and abs(math.remainder(pose[2], 2 * math.pi)) < 0.4:
            c, s = math.cos(pose[2]), math.sin(pose[2])
            local = np.array([-c * pose[0] - s * pose[1], s * pose[0] - c * pose[1], -pose[2]])
            rows["dock"].append([now, *(local + [0.003, 0.003, 0.004] * rng.standard_normal(3))])
        while queue and queue[0][0] <= now:
            acting = queue.pop(0)[1]
            wanted = np.where(np.abs(acting) > deadband, gain * acting, 0.0)
        demand = demand + np.minimum(np.maximum(wanted - demand, -limit), limit)
        speed = speed + (demand - speed) * DT / lag
        pose = pose + DT * np.array([speed[0] * math.cos(pose[2]), speed[0] * math.sin(pose[2]), speed[1]])
        wheels = wheels + DT * np.array([(1 + e[0]) * speed[0], (1 + e[1]) * speed[1] + e[2] * speed[0]])
    assert driver.state is DriveState.DONE, driver.text
    dock_rows = np.array(rows["dock"]).reshape(-1, 4)
    covariance = np.tile(np.diag([0.003**2, 0.003**2, 0.004**2]), (len(dock_rows), 1, 1))
    return Recording(np.array(rows["command"]), np.array(rows["odometry"]), dock_rows, covariance)
