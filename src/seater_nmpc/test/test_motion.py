import math

import numpy as np
import pytest

from seater_nmpc.drive.prediction import CommandHistory
from seater_nmpc.observe.motion import MotionObserver
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import ObserverParameters, Prediction


def test_speed_follows_the_commands_behind_delay_and_lag() -> None:
    """A step to 0.4 m/s sent at 1.0 s acts at 1.04 s; without any further odometry the speed is that of the lag."""
    history = CommandHistory(Prediction(command_delay=0.04, motor_lag=0.1))
    motion = MotionObserver(history, ObserverParameters())
    motion.add_odometry(Odometry(1.0, np.zeros(3), 0.0, 0.0))
    history.sent(1.0, 0.4, -0.2)
    assert motion.at(1.03) == pytest.approx((0.0, 0.0))
    assert motion.at(1.14) == pytest.approx((0.4 * (1 - math.exp(-1)), -0.2 * (1 - math.exp(-1))))


def test_noise_of_the_odometry_is_halved_at_least_and_slip_is_followed() -> None:
    rng, history = np.random.default_rng(2), CommandHistory(Prediction(motor_lag=0.1))
    motion = MotionObserver(history, ObserverParameters())
    history.sent(0.0, 0.4, 0.0)
    errors = []
    for k in range(300):
        stamp, v = 0.02 * (k + 1), 0.4 * (1 - math.exp(-0.2 * (k + 1)))
        motion.add_odometry(Odometry(stamp, np.zeros(3), v + 0.02 * rng.normal(), 0.02 * rng.normal()))
        errors.append([motion.at(stamp)[0] - v, motion.at(stamp)[1]])
    assert np.all(np.sqrt(np.mean(np.square(errors), axis=0)) < 0.01)
    for k in range(300, 360):  # the wheels stand on a threshold, whatever is asked for
        motion.add_odometry(Odometry(0.02 * (k + 1), np.zeros(3), 0.0, 0.0))
    assert abs(motion.at(7.2)[0]) < 0.08


def test_after_a_gap_and_without_commands_the_last_speed_counts() -> None:
    history = CommandHistory(Prediction(motor_lag=0.1))
    motion = MotionObserver(history, ObserverParameters())
    assert motion.at(0.0) == (0.0, 0.0)
    motion.add_odometry(Odometry(1.0, np.zeros(3), 0.1, 0.0))
    motion.add_odometry(Odometry(3.0, np.zeros(3), 0.3, 0.2))
    assert motion.at(3.05) == (0.3, 0.2)
    history.sent(3.0, 0.0, 0.0)
    history.clear()
    assert motion.at(3.2) == (0.3, 0.2)
