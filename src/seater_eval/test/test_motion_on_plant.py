"""What the observer of the chair's motion gains on seater_sim's plant and odometry, where it counts: when the command
acts."""

import math
from pathlib import Path

import numpy as np

from seater_eval.run.setup_files import Setup, load_setup
from seater_nmpc.drive.prediction import CommandHistory
from seater_nmpc.observe.motion import MotionObserver
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import Prediction
from seater_sim.chair.odometry import Odometry as WheelOdometry
from seater_sim.chair.plant import KinematicPlant
from seater_sim.settings import NANOSECONDS, to_ns

CONFIG = Path(__file__).resolve().parents[3] / "config"
RUNS, SECONDS = 10, 6.0


def errors(setup: Setup, seed: int) -> np.ndarray:
    """(cycles, 2, 2): of the odometry's and of the observer's speeds rolled on; v [m/s], omega [rad/s]. The chair's own
    times are known."""
    rng, kinematic = np.random.default_rng([seed, 13]), setup.simulator.plant.kinematic
    told = Prediction(command_delay=kinematic.command_delay, motor_lag=kinematic.lag_v)
    plant = KinematicPlant(kinematic, setup.chair.limits, np.zeros(3))
    wheels, period = WheelOdometry(setup.simulator.odometry, seed), to_ns(setup.simulator.odometry.period)
    history, way, turn, rows = CommandHistory(told), 0.0, 0.0, []
    motion, commands = MotionObserver(history, setup.parameters.observer), history.view()
    delay = round(told.command_delay / 0.01)
    speed, swing, pending = rng.uniform(0.2, 0.5), rng.uniform(-0.5, 0.5), []
    for k in range(1, round(SECONDS / 0.01)):
        plant.step(to_ns(0.01))
        way, turn, now = way + plant.motion.way, turn + plant.motion.turn, 0.01 * k
        if pending and pending[0][0] == k:
            rows.append(pending.pop(0)[1] - [plant.v, plant.omega])
        if plant.time_ns % period:
            continue
        sample = wheels.update(way, turn, period, plant.time_ns)
        way = turn = 0.0
        motion.add_odometry(Odometry(sample.time_ns / NANOSECONDS, sample.pose, sample.v, sample.omega))
        if k % 10:
            continue
        speeds = (sample.v, sample.omega), motion.at(now)
        estimates = [commands.roll(now, np.zeros(3), v, omega)[1:] for v, omega in speeds]
        pending.append((k + delay, np.array(estimates)))
        command = min(0.4 * now, speed, 0.5 * (SECONDS - now)), swing * math.sin(2.0 * now)
        plant.command(*command)
        history.sent(now, *command)
    return np.array(rows)


def test_speeds_are_better_than_the_odometrys_when_the_command_acts() -> None:
    setup = load_setup(CONFIG)
    rms = np.sqrt(np.mean(np.concatenate([errors(setup, seed) for seed in range(RUNS)]) ** 2, axis=0))
    print(f"rms v, omega: odometry {1e3 * rms[0]} observer {1e3 * rms[1]} mm/s, mrad/s")
    assert np.all(rms[0] > 1.5 * rms[1])
