"""What the controller learns of a chair on the way to the dock, told nothing."""

import math

import numpy as np
import pytest
from chairs import SlowChair
from conftest import seldom
from driving import CHAIR, DOCK

from seater_common.way_clearance import smallest_clearance
from seater_nmpc.control.controller import DockingController
from seater_nmpc.drive.axis import AxisDrive
from seater_nmpc.parameters import ControlParameters


def dock(chair: SlowChair, seconds: float = 16.0):
    """The controller after driving the chair to the dock, and the poses. Told nothing; half the steps, as long ones."""
    controller = DockingController(CHAIR, DOCK, ControlParameters(horizon=15, step=0.2), deterministic=True)
    poses = []
    for _ in range(round(seconds / 0.05)):
        command = controller.command(chair.pose, (chair.v, chair.omega), [0.0, 0.0, 0.0], stamp=chair.now)
        chair.drive((command.v, command.omega), 0.05, controller)
        poses.append(chair.pose)
    return controller, np.array(poses)


@pytest.mark.parametrize("offset", [pytest.param(False, marks=pytest.mark.extensive), True], ids=["jump", "offset"])
def test_a_slow_chair_with_deadbands_is_learned_and_docked(offset: bool) -> None:
    """Delay 0.25 s and lag 0.3 s where 0.15 s and 0.2 s are told, deadbands of 0.02 m/s and 0.05 rad/s."""
    chair = SlowChair((-2.5, 0.5, -0.3), 0.25, 0.3, AxisDrive(1.0, 0.02, offset), AxisDrive(1.0, 0.05, offset))
    controller, poses = dock(chair, 22.0)
    history = controller.history
    assert (history.delay, history.drive.lag_v) == pytest.approx((0.25, 0.28), abs=1e-6)
    assert 0.28 - 1e-6 <= history.drive.lag_omega <= 0.36 + 1e-6
    v = history.drive.v
    assert v.gain == pytest.approx(1.0, abs=0.05)
    assert (v.deadband, v.offset) == (0.02, True) if offset else v.deadband <= 0.03
    assert 0.02 <= history.drive.omega.deadband <= 0.065
    assert smallest_clearance(CHAIR, DOCK.bay, poses) > 0.03
    assert np.hypot(*poses[-1, :2]) < 0.005 and abs(math.degrees(poses[-1, 2])) < 0.6
    assert np.max(poses[:, 0]) < 0.015


@pytest.mark.parametrize("start", [(-2.0, -0.7, 0.4), seldom((-3.0, 0.0, 0.0))])
def test_what_is_right_stays(start) -> None:
    """A chair as told: nothing is learned, and after 13 s it is at the dock."""
    controller, poses = dock(SlowChair(start, 0.15, 0.2), 13.0)
    history = controller.history
    for drive in (history.drive.v, history.drive.omega):
        assert drive.deadband == 0.0 and drive.gain == pytest.approx(1.0, abs=0.01)
    assert (history.delay, history.drive.lag_v, history.drive.lag_omega) == pytest.approx((0.15, 0.2, 0.2))
    assert abs(history.drive.curvature) < 1e-3 and np.hypot(*poses[-1, :2]) < 0.003


@pytest.mark.parametrize("gain", [seldom(0.4), 0.7, seldom(1.3)])
def test_a_chair_whose_motors_make_less_or_more_of_each_command(gain: float) -> None:
    """A raised seat, a base that nobody calibrated: it docks on the same way, and a slow one is not asked for more than
    it can."""
    chair = SlowChair((-2.5, 0.5, -0.3), 0.15, 0.2, AxisDrive(gain), AxisDrive(gain))
    controller, poses = dock(chair, 16.0 / min(gain, 1.0))
    drive = controller.history.drive
    assert (drive.v.gain, drive.omega.gain) == pytest.approx((gain, gain), abs=0.06)
    assert smallest_clearance(CHAIR, DOCK.bay, poses) > 0.03
    assert np.hypot(*poses[-1, :2]) < 0.003 and abs(math.degrees(poses[-1, 2])) < 0.3


def test_of_wheels_that_slip_no_gain_is_learned() -> None:
    """Commanded 0.3 m/s and 0.2 rad/s, moving by half of it: weak motors, or a wet floor."""
    gains = {}
    for rolling in (True, False):
        controller = DockingController(CHAIR, DOCK, ControlParameters(horizon=15, step=0.2), deterministic=True)
        actuation = controller._actuation
        for k in range(100):
            actuation.send(0.05 * k, (0.3, 0.2), (0.3, 0.2), 0.05, False)
            actuation.measured(0.05 * (k + 1), 0.15, 0.1, rolling=rolling)
        drive = controller.history.drive
        gains[rolling] = drive.v.gain, drive.omega.gain
    assert gains[False] == (1.0, 1.0) and max(gains[True]) < 0.8


def test_a_chair_that_pulls_to_one_side_is_held_straight() -> None:
    """One side weaker: 0.06 rad/m, three and a half degrees in each metre, learned on the way and asked against."""
    chair = SlowChair((-2.5, 0.5, -0.3), 0.15, 0.2)
    chair.curvature = 0.06
    controller, poses = dock(chair)
    assert controller.history.drive.curvature == pytest.approx(0.06, abs=0.01)
    assert np.hypot(*poses[-1, :2]) < 0.003
    assert abs(math.degrees(poses[-1, 2])) < 0.3
