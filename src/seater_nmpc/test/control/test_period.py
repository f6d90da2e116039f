"""Cycles that come slower than configured."""

import math

import numpy as np
import pytest
from conftest import AT_ONCE, seldom
from driving import CHAIR, DOCK

from seater_common.se2 import arc_step
from seater_common.way_clearance import smallest_clearance
from seater_nmpc.control.command import Status
from seater_nmpc.control.controller import DockingController
from seater_nmpc.parameters import ControlParameters

LIMITS = CHAIR.limits


@pytest.fixture(scope="module")
def controller() -> DockingController:
    return DockingController(CHAIR, DOCK, ControlParameters(prediction=AT_ONCE), deterministic=True)


def drive(controller, start, periods):
    """A perfect unicycle whose cycles are so far apart [s]; poses and commands."""
    controller.reset()
    pose, velocity, now, poses, commands = np.array(start), (0.0, 0.0), 0.0, [], []
    for period in periods:
        command = controller.command(pose, velocity, [0.0, 0.0, 0.0], stamp=now)
        velocity = (command.v, command.omega)
        pose = arc_step(pose, *velocity, period)
        now += period
        poses.append(pose)
        commands.append(command)
    return np.array(poses), commands


@pytest.mark.parametrize("rate", [5.0, seldom(8.0), seldom(12.0)])
@pytest.mark.parametrize("start", [seldom((-2.5, 0.5, -0.3)), (-2.0, -0.7, 0.4)])
def test_slow_cycles_dock_within_the_limits(controller, rate: float, start) -> None:
    """Accelerations count per time between cycles; the chair docks without touching and without swinging."""
    period = 1.0 / rate
    poses, commands = drive(controller, start, [period] * round(30.0 * rate))
    assert controller.period == pytest.approx(period)
    speeds = np.array([(c.v, c.omega) for c in commands])
    rates = np.abs(np.diff(np.vstack([[0.0, 0.0], speeds]), axis=0)) / period
    assert np.max(rates[:, 0]) <= LIMITS.a_max + 1e-9 and np.max(rates[:, 1]) <= LIMITS.alpha_max + 1e-9
    assert np.max(np.abs(speeds[:, 0])) <= LIMITS.v_max and np.max(np.abs(speeds[:, 1])) <= LIMITS.omega_max
    assert all(command.status is Status.SOLVED for command in commands)
    assert np.hypot(*poses[-1, :2]) < 2e-3 and abs(math.degrees(poses[-1, 2])) < 0.1
    assert smallest_clearance(CHAIR, DOCK.bay, poses) > 0.03
    turning = np.sign(speeds[np.abs(speeds[:, 1]) > 0.02, 1])
    assert np.count_nonzero(np.diff(turning)) <= 3


def test_one_late_cycle_and_noisy_stamps_change_nothing(controller) -> None:
    drive(controller, (-2.5, 0.5, -0.3), [0.05] * 10 + [0.2] + [0.05] * 2)
    assert controller.period == 0.05
    noise = np.random.default_rng(1).uniform(-0.004, 0.004, size=30)
    drive(controller, (-2.5, 0.5, -0.3), 0.05 + noise)
    assert controller.period == 0.05
    drive(controller, (-2.5, 0.5, -0.3), [0.1] * 5)
    assert controller.period == pytest.approx(0.1)
    drive(controller, (-2.5, 0.5, -0.3), [0.1] * 5 + [0.3] * 2)
    assert controller.period == pytest.approx(0.1)
    drive(controller, (-2.5, 0.5, -0.3), [0.1] * 5 + [0.02] * 3)
    assert controller.period == 0.05  # quick ones: nothing shorter than configured is planned for


def test_slow_cycles_drive_slower_and_say_why(controller) -> None:
    _, commands = drive(controller, (-3.5, 0.0, 0.0), [0.2] * 25)
    assert max(command.v for command in commands[10:]) == pytest.approx(0.3, abs=0.02)
    assert controller.pace.why == "odometry comes only every 0.20 s"
    _, commands = drive(controller, (-3.5, 0.0, 0.0), [0.05] * 60)
    assert max(command.v for command in commands) > 0.5 and controller.pace.why == ""


def test_small_moves_between_pauses_reckon_with_slow_cycles(controller) -> None:
    """As at the dock: a small move of few cycles, a pause for images, the next move."""
    drive(controller, (-0.5, 0.0, 0.0), [0.1] * 5)
    now = 0.5
    for cycles in (2, 1, 3):
        now += 2.2
        for _ in range(cycles):
            controller.move(now, (0.0, 0.0), 0.05, 0.0)
            now += 0.1
        assert controller.period == pytest.approx(0.1)
