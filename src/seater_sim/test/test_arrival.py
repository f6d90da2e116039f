"""Odometry that arrives late, and the simulator on the plant `wheelchair`."""

import dataclasses
import math
from typing import Any

import numpy as np

from seater_common.geometry import Chair, Dock
from seater_sim.loop.simulator import Due, Simulator
from seater_sim.settings import PlantSettings, SimulatorSettings, WheelchairSettings, WheelOdometrySettings


def run(seconds: float, seed: int = 1, **odometry: Any) -> list[Due]:
    chair = dataclasses.replace(WheelchairSettings(), odometry=WheelOdometrySettings(**odometry))
    settings = dataclasses.replace(SimulatorSettings(), plant=PlantSettings("wheelchair", wheelchair=chair))
    simulator = Simulator(settings, Chair(), Dock(), None, (-2.0, 0.1, 0.0), seed=seed)
    steps = []
    for k in range(round(seconds / 0.01)):
        simulator.command(0.2, 0.2 * math.sin(0.02 * k))
        steps.append(simulator.step())
    return steps


def test_odometry_arrives_late_and_in_order() -> None:
    steps = run(4.0, arrival_jitter=0.05)
    ages = [(due.time_ns - due.odometry.time_ns) / 1e9 for due in steps if due.odometry]
    stamps = [due.odometry.time_ns for due in steps if due.odometry]
    assert np.all(np.diff(stamps) == 20_000_000)
    assert min(ages) <= 0.011 and 0.035 < max(ages) <= 0.07  # a message may wait for the one before it
    assert len(set(np.round(ages, 3))) >= 4
    on_time = run(4.0, arrival_jitter=0.0)
    assert all(due.odometry.time_ns == due.time_ns for due in on_time if due.odometry)
    assert stamps == [due.odometry.time_ns for due in on_time if due.odometry][: len(stamps)]


def test_same_seed_same_run() -> None:
    def bits(seed: int) -> list[object]:
        return [
            (due.truth.pose.tolist(), due.odometry.pose.tolist(), due.time_ns)
            for due in run(3.0, seed, arrival_jitter=0.03)
            if due.odometry
        ]

    assert bits(2) == bits(2)
    assert bits(2) != bits(3)


def test_truth_is_the_true_pose_and_odometry_is_wrong() -> None:
    last = run(6.0, arrival_jitter=0.0)[-1]
    assert last.odometry is not None
    origin = SimulatorSettings().odometry.origin
    moved = float(np.hypot(*(last.odometry.pose[:2] - [origin.x, origin.y])))
    true = float(np.hypot(*(last.truth.pose[:2] - [-2.0, 0.1])))
    assert 0.005 < moved - true < 0.1  # slip: the wheels turn farther than the chair goes
    assert 0.0 < last.truth.v < 0.2
