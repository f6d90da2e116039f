"""Closed loops: where a perfect chair ends, within which limits, on which ways."""

import math
from dataclasses import replace

import numpy as np
import pytest
from conftest import AT_ONCE, seldom
from driving import CHAIR, DOCK, PERIOD, drive

from seater_common.se2 import arc_step
from seater_common.way_clearance import smallest_clearance
from seater_nmpc.control.command import Status
from seater_nmpc.control.controller import DockingController
from seater_nmpc.control.limits import in_bay
from seater_nmpc.parameters import ControlParameters, Prediction


@pytest.mark.parametrize(
    "start", [(-2.5, 0.8, -20.0), seldom((-3.0, 0.0, 0.0)), seldom((-2.0, -0.7, 25.0)), (-3.5, 1.2, -10.0)]
)
def test_docks_exactly_within_limits_and_clear_of_the_walls(controller, start) -> None:
    poses, commands = drive(controller, start, 13.0 if start[0] > -3.5 else 14.5)
    limits = CHAIR.limits
    speeds = np.array([(c.v, c.omega) for c in commands])
    rates = np.diff(np.vstack([[0.0, 0.0], speeds]), axis=0) / PERIOD
    assert np.hypot(*poses[-1, :2]) < 1e-3 and abs(math.degrees(poses[-1, 2])) < 0.05
    assert np.all(speeds[:, 0] <= limits.v_max + 1e-9) and np.all(speeds[:, 0] >= -limits.v_reverse_max - 1e-9)
    assert np.max(np.abs(speeds[:, 1])) <= limits.omega_max + 1e-9
    assert np.max(np.abs(rates[:, 0])) <= limits.a_max + 1e-9 and np.max(np.abs(rates[:, 1])) <= limits.alpha_max + 1e-9
    inside = [in_bay(CHAIR, DOCK.bay, pose) for pose in poses[:-1]]
    assert any(inside) and np.max(np.abs(speeds[inside, 0])) <= limits.v_bay_max + 1e-9
    assert smallest_clearance(CHAIR, DOCK.bay, poses) > controller.parameters.margin - 0.01
    assert all(command.status is Status.SOLVED for command in commands)
    assert controller.counters.consecutive_failures == 0


@pytest.fixture(scope="module")
def in_free_space() -> DockingController:
    """No walls: the paper's setting."""
    return DockingController(
        CHAIR, DOCK, replace(ControlParameters(prediction=AT_ONCE), walls=False), deterministic=True
    )


@pytest.mark.parametrize("start", [(-1.5, 2.0, 90.0), (1.5, 2.0, -90.0), (1.5, 2.0, 0.0), (-1.5, 2.0, 0.0)])
def test_papers_poses_in_free_space(in_free_space, start) -> None:
    poses, _ = drive(in_free_space, start, 17.0)
    assert np.hypot(*poses[-1, :2]) < 1e-4 and abs(math.degrees(poses[-1, 2])) < 0.05


def test_drives_backward_to_the_predock_point(controller) -> None:
    poses, commands = drive(controller, (0.0, 0.0, 0.0), 11.0, "predock")
    assert poses[-1] == pytest.approx([DOCK.predock_x, 0.0, 0.0], abs=1e-3)
    assert min(c.v for c in commands) < -0.1 and smallest_clearance(CHAIR, DOCK.bay, poses) > 0.0


def test_ten_lines_without_ros() -> None:
    """The example in the docstring of DockingController, run as it stands there."""
    lines = DockingController.__doc__.split("without ROS:\n\n")[1].split("\n\n    Whatever")[0]
    code = "\n".join(line[8:] for line in lines.splitlines())
    names: dict = {}
    exec(code, names)
    assert len([line for line in code.splitlines() if line.strip()]) <= 11
    assert np.hypot(*names["pose"][:2]) < 1e-4


def test_jerk_limits_hold_from_command_to_command(controller) -> None:
    """1 m/s^3 and 3 rad/s^3: accelerations change no faster (without the option they jump); the end is as exact."""

    def jerk(commands) -> np.ndarray:
        speeds = [(0.0, 0.0), (0.0, 0.0), *((command.v, command.omega) for command in commands)]
        return np.max(np.abs(np.diff(speeds, n=2, axis=0)), axis=0) / PERIOD**2

    start = (-2.5, 0.5, math.degrees(-0.2))
    limited = replace(ControlParameters(prediction=AT_ONCE), max_jerk=1.0, max_angular_jerk=3.0)
    poses, commands = drive(DockingController(CHAIR, DOCK, limited, deterministic=True), start, 16.0)
    assert all(command.status is Status.SOLVED for command in commands)
    assert np.hypot(*poses[-1, :2]) < 1e-3 and abs(poses[-1, 2]) < 2e-3
    assert jerk(commands)[0] <= 1.0 + 0.02 and jerk(commands)[1] <= 3.0 + 0.06
    free = jerk(drive(controller, start, 5.0)[1])
    assert free[0] > 5.0 and free[1] > 6.0


def overshoot(prediction: Prediction) -> float:
    """[m] by which a chair with 0.2 s delay and 0.15 s lag passes a target that is 1 m ahead."""
    parameters = replace(ControlParameters(), walls=False, prediction=prediction)
    controller = DockingController(CHAIR, DOCK, parameters, deterministic=True)
    pose, v, omega, pending, farthest = np.array([-1.0, 0.1, 0.0]), 0.0, 0.0, [(0.0, 0.0)] * 4, -1.0
    for k in range(160):
        command = controller.command(pose, (v, omega), [0.0, 0.0, 0.0], stamp=k * PERIOD)
        pending.append((command.v, command.omega))
        asked = pending.pop(0)
        for _ in range(5):
            v, omega = v + (asked[0] - v) * 0.01 / 0.15, omega + (asked[1] - omega) * 0.01 / 0.15
            pose = arc_step(pose, v, omega, 0.01)
        farthest = max(farthest, pose[0])
    return farthest


def test_known_delay_and_lag_are_compensated() -> None:
    """A chair overshoots when the controller takes it to obey at once, and hardly when it knows better."""
    blind, aware = (
        overshoot(replace(AT_ONCE, adapt=False)),
        overshoot(Prediction(command_delay=0.2, motor_lag=0.15, adapt=False)),
    )
    assert aware < 0.015 and blind > 3.0 * aware


def test_learning_does_not_unlearn_what_is_right() -> None:
    assert overshoot(Prediction(command_delay=0.2, motor_lag=0.15)) < 0.015


def test_told_nothing_a_chair_that_obeys_at_once_loses_nothing() -> None:
    """The defaults are those of a slower chair; that this one is quick is learned on the way."""
    poses, commands = drive(DockingController(CHAIR, DOCK, deterministic=True), (-2.5, 0.8, math.degrees(-0.35)), 15.0)
    assert np.hypot(*poses[-1, :2]) < 3e-4 and abs(math.degrees(poses[-1, 2])) < 0.05
    assert smallest_clearance(CHAIR, DOCK.bay, poses) > 0.04
    assert all(command.status is Status.SOLVED for command in commands)
