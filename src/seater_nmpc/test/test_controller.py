import math
from dataclasses import replace

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock, clearance
from seater_common.se2 import arc_step, compose, relative
from seater_nmpc.control.command import Counters, Status
from seater_nmpc.control.controller import DockingController
from seater_nmpc.control.limits import clamp, in_bay
from seater_nmpc.observe.prediction import CommandHistory, coasting_pose
from seater_nmpc.parameters import ControlParameters, Prediction
from seater_nmpc.programme import ProblemData, WarmStart
from seater_nmpc.solve.interface import Solution, SolveStatus

PERIOD, CHAIR, DOCK = 0.05, Chair(), Dock()
T_COMMON_DOCK = np.array([3.0, -1.0, 2.5])


def drive(controller, start, seconds, target="dock"):
    """Perfect unicycle in a turned common frame; poses in the dock's frame and commands, one row per cycle."""
    pose, velocity = np.array([start[0], start[1], math.radians(start[2])]), (0.0, 0.0)
    poses, commands = [pose], []
    controller.reset()
    for k in range(round(seconds / PERIOD)):
        command = controller.command(compose(T_COMMON_DOCK, pose), velocity, T_COMMON_DOCK, target, k * PERIOD)
        velocity = (command.v, command.omega)
        pose = arc_step(pose, *velocity, PERIOD)
        poses.append(pose)
        commands.append(command)
    return np.array(poses), commands


@pytest.mark.parametrize("start", [(-2.5, 0.8, -20.0), (-3.0, 0.0, 0.0), (-2.0, -0.7, 25.0), (-3.5, 1.2, -10.0)])
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
    assert min(clearance(CHAIR, DOCK.bay, pose) for pose in poses) > controller.parameters.margin - 0.01
    assert all(command.status is Status.SOLVED for command in commands)
    assert controller.counters.consecutive_failures == 0


@pytest.fixture(scope="module")
def in_free_space() -> DockingController:
    """No walls: the paper's setting."""
    return DockingController(CHAIR, DOCK, replace(ControlParameters(), walls=False), deterministic=True)


@pytest.mark.parametrize("start", [(-1.5, 2.0, 90.0), (1.5, 2.0, -90.0), (1.5, 2.0, 0.0), (-1.5, 2.0, 0.0)])
def test_papers_poses_in_free_space(in_free_space, start) -> None:
    poses, _ = drive(in_free_space, start, 17.0)
    assert np.hypot(*poses[-1, :2]) < 1e-4 and abs(math.degrees(poses[-1, 2])) < 0.05


def test_drives_backward_to_the_predock_point(controller) -> None:
    poses, commands = drive(controller, (0.0, 0.0, 0.0), 11.0, "predock")
    assert poses[-1] == pytest.approx([DOCK.predock_x, 0.0, 0.0], abs=1e-3)
    assert min(c.v for c in commands) < -0.1 and min(clearance(CHAIR, DOCK.bay, pose) for pose in poses) > 0.0


def test_path_starts_at_the_chair_and_ends_nearer(controller) -> None:
    controller.reset()
    pose = compose(T_COMMON_DOCK, [-2.0, 0.3, 0.0])
    command = controller.command(pose, (0.0, 0.0), T_COMMON_DOCK, stamp=5.0)
    assert command.path.shape == (31, 3) and command.path[0] == pytest.approx(pose, abs=1e-6)
    assert np.hypot(*relative(T_COMMON_DOCK, command.path[-1])[:2]) < 1.5


def test_ten_lines_without_ros() -> None:
    """The example in the docstring of DockingController, run as it stands there."""
    lines = DockingController.__doc__.split("without ROS:\n\n")[1].split("\n\n    Whatever")[0]
    code = "\n".join(line[8:] for line in lines.splitlines())
    names: dict = {}
    exec(code, names)
    assert len([line for line in code.splitlines() if line.strip()]) <= 11
    assert np.hypot(*names["pose"][:2]) < 1e-4


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_inputs_that_are_not_finite_are_refused_and_brake(controller, bad) -> None:
    drive(controller, (-2.5, 0.0, 0.0), 1.0)
    before, refused = controller._commands.last, controller.counters.refused_inputs
    assert before[0] > 0.1
    command = controller.command([bad, 0.0, 0.0], (0.1, 0.0), T_COMMON_DOCK)
    assert command.status is Status.FALLBACK_BRAKE and 0.0 <= command.v < before[0]
    assert controller.counters.refused_inputs == refused + 1


def test_an_unknown_target_is_named(controller) -> None:
    with pytest.raises(ValueError, match="garage"):
        controller.command([0, 0, 0], (0, 0), [0, 0, 0], "garage")


class FailingSolver:
    """Passes on to a real solver until its mode is a fault."""

    name = "failing"

    def __init__(self, real) -> None:
        self.real, self.mode = real, "work"

    def prepare(self, limits) -> None:
        self.real.prepare(limits)

    def solve(self, data: ProblemData, start: WarmStart, time_limit=None) -> Solution:
        solution = self.real.solve(data, start, time_limit)
        if self.mode == "fail":
            return replace(solution, status=SolveStatus.FAILED, x=np.full_like(solution.x, np.nan), text="injected")
        if self.mode == "violation":
            return replace(solution, status=SolveStatus.LIMIT, violation=0.5, text="injected")
        if self.mode == "limit":
            return replace(solution, status=SolveStatus.LIMIT, violation=1e-5, text="injected")
        return solution


@pytest.fixture(scope="module")
def with_failing_solver(controller):
    solver = FailingSolver(controller._replanner._solver)
    return solver, DockingController(CHAIR, DOCK, deterministic=True, solver=solver)


@pytest.fixture
def failing(with_failing_solver):
    """Works until its mode is set."""
    solver, controller = with_failing_solver
    solver.mode = "work"
    controller.reset()
    controller.counters = Counters()
    return solver, controller


@pytest.mark.parametrize("mode", ["fail", "violation"])
def test_solver_failure_goes_down_the_chain_to_standing(failing, mode) -> None:
    solver, controller = failing
    poses, commands = drive(controller, (-2.5, 0.0, 0.0), 1.0)
    solver.mode = mode
    pose, statuses, speeds = poses[-1], [], [commands[-1].v]
    for k in range(40):
        command = controller.command(
            compose(T_COMMON_DOCK, pose), (speeds[-1], 0.0), T_COMMON_DOCK, stamp=1.0 + k * PERIOD
        )
        pose = arc_step(pose, command.v, command.omega, PERIOD)
        statuses.append(command.status)
        speeds.append(command.v)
        assert math.isfinite(command.v) and math.isfinite(command.omega)
    assert statuses[:6] == [Status.FALLBACK_SHIFTED] * 6 and set(statuses[6:]) == {Status.FALLBACK_BRAKE}
    assert speeds[-1] == 0.0 and np.max(np.abs(np.diff(speeds))) <= CHAIR.limits.a_max * PERIOD + 1e-9
    assert controller.counters.consecutive_failures == 40
    solver.mode = "work"
    again = controller.command(compose(T_COMMON_DOCK, pose), (0.0, 0.0), T_COMMON_DOCK, stamp=3.05)
    assert again.status is Status.SOLVED and controller.counters.consecutive_failures == 0


def test_a_feasible_iterate_at_the_limit_is_used(failing) -> None:
    solver, controller = failing
    solver.mode = "limit"
    _, commands = drive(controller, (-2.5, 0.0, 0.0), 0.3)
    assert {c.status for c in commands} == {Status.TIME_LIMIT} and commands[-1].v > 0.05
    assert controller.counters.time_limits == len(commands)


def test_clamp_keeps_speed_acceleration_and_finiteness() -> None:
    assert clamp(CHAIR, 9.0, -9.0, (0.59, -0.79), PERIOD, False) == (0.6, -0.8)
    assert clamp(CHAIR, 0.6, 0.8, (0.0, 0.0), PERIOD, False) == pytest.approx((0.025, 0.05))
    assert clamp(CHAIR, -9.0, 0.0, (-0.29, 0.0), PERIOD, False) == pytest.approx((-0.3, 0.0))
    assert clamp(CHAIR, 0.6, 0.0, (0.14, 0.0), PERIOD, True) == pytest.approx((0.15, 0.0))
    assert clamp(CHAIR, -0.6, 0.0, (-0.14, 0.0), PERIOD, True) == pytest.approx((-0.15, 0.0))
    assert clamp(CHAIR, math.nan, math.inf, (0.01, 0.0), PERIOD, False) == (0.0, 0.0)


def test_prediction_rolls_through_commands_that_do_not_act_yet() -> None:
    """0.2 s delay: 0.1 s at rest, then 0.1 s at 0.4 m/s."""
    history = CommandHistory(Prediction(command_delay=0.2))
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


def test_a_command_that_someone_else_sent_is_where_the_next_one_begins(controller) -> None:
    """A zero sent while the odometry was late: the controller goes on from it, not from its own request."""
    pose, commands = [-2.5, 0.0, 0.0], drive(controller, (-2.5, 0.0, 0.0), 0.5)[1]
    assert commands[-1].v > 0.2
    controller.history.sent(0.5, 0.0, 0.0)
    command = controller.command(compose(T_COMMON_DOCK, pose), (0.0, 0.0), T_COMMON_DOCK, stamp=0.55)
    assert command.v <= CHAIR.limits.a_max * PERIOD + 1e-9


def test_jerk_limits_hold_from_command_to_command(controller) -> None:
    """1 m/s^3 and 3 rad/s^3: accelerations change no faster (without the option they jump); the end is as exact."""

    def jerk(commands) -> np.ndarray:
        speeds = [(0.0, 0.0), (0.0, 0.0), *((command.v, command.omega) for command in commands)]
        return np.max(np.abs(np.diff(speeds, n=2, axis=0)), axis=0) / PERIOD**2

    start = (-2.5, 0.5, math.degrees(-0.2))
    limited = replace(ControlParameters(), max_jerk=1.0, max_angular_jerk=3.0)
    poses, commands = drive(DockingController(CHAIR, DOCK, limited, deterministic=True), start, 16.0)
    assert all(command.status is Status.SOLVED for command in commands)
    assert np.hypot(*poses[-1, :2]) < 1e-3 and abs(poses[-1, 2]) < 2e-3
    assert jerk(commands)[0] <= 1.0 + 0.02 and jerk(commands)[1] <= 3.0 + 0.06
    free = jerk(drive(controller, start, 5.0)[1])
    assert free[0] > 5.0 and free[1] > 6.0


def test_jerk_limits_with_a_stage_wise_solver_are_refused() -> None:
    with pytest.raises(ValueError, match="control/solver: is 'fatrop'"):
        DockingController(Chair(), Dock(), replace(ControlParameters(), solver="fatrop", max_jerk=1.0))


def test_known_delay_and_lag_are_compensated() -> None:
    """A chair with 0.2 s delay and 0.15 s lag overshoots when the controller does not know, and hardly when it does."""

    def overshoot(prediction: Prediction) -> float:
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

    blind, aware = overshoot(Prediction()), overshoot(Prediction(command_delay=0.2, motor_lag=0.15))
    assert aware < 0.015 and blind > 3.0 * aware
