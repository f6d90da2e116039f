"""Commands that were sent, and what they do until they act."""

import math

import pytest

from seater_nmpc.drive.prediction import CommandHistory, coasting_pose
from seater_nmpc.parameters import Prediction


def test_prediction_rolls_through_commands_that_do_not_act_yet() -> None:
    """0.2 s delay: 0.1 s at rest, then 0.1 s at 0.4 m/s."""
    history = CommandHistory(Prediction(command_delay=0.2, motor_lag=0.0))
    commands = history.view()
    history.sent(0.9, 0.4, 0.0)
    pose, v, _ = commands.roll(1.0, [1.0, 0.0, 0.0], 0.0, 0.0)
    assert pose == pytest.approx([1.04, 0.0, 0.0], abs=1e-9) and v == 0.4


def test_prediction_follows_the_motor_lag() -> None:
    history = CommandHistory(Prediction(command_delay=0.3, motor_lag=0.1))
    commands = history.view()
    history.sent(0.7, 0.5, 0.0)
    pose, v, _ = commands.roll(1.0, [0.0, 0.0, 0.0], 0.0, 0.0)
    assert v == pytest.approx(0.5 * (1 - math.exp(-3)), abs=1e-9)
    assert pose[0] == pytest.approx(0.5 * (0.3 - 0.1 * (1 - math.exp(-3))), abs=1e-9)
    assert coasting_pose([0.0, 0.0, 0.0], 0.5, 0.0, 0.1) == pytest.approx([0.05, 0.0, 0.0])


def test_of_two_commands_for_one_stamp_the_later_one_acts_and_a_view_begins_where_it_was_made() -> None:
    history = CommandHistory(Prediction())
    everything = history.view()
    history.sent(1.0, 0.1, 0.0)
    history.sent(1.05, 0.3, 0.2)
    later = history.view()
    assert everything.last == (0.3, 0.2) and later.last is None and later.acceleration(0.05) == (0.0, 0.0)
    history.sent(1.05, 0.2, 0.1)
    assert everything.last == later.last == (0.2, 0.1)
    assert everything.acceleration(0.05) == pytest.approx((2.0, 2.0)) and later.acceleration(0.05) == (0.0, 0.0)
    history.sent(0.5, 0.0, 0.0)  # time began anew
    assert everything.last == (0.0, 0.0) and everything.acceleration(0.05) == (0.0, 0.0)
