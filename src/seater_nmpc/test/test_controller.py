"""What one command is: its plan, its fallbacks, and what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from conftest import AT_ONCE, seldom
from driving import CHAIR, DOCK, PERIOD, T_COMMON_DOCK, drive

from seater_common.geometry import Chair, Dock
from seater_common.se2 import arc_step, compose, relative
from seater_nmpc.control.command import Counters, Status
from seater_nmpc.control.controller import DockingController
from seater_nmpc.control.limits import clamp
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import ProblemData, WarmStart
from seater_nmpc.solve.interface import Solution, SolveStatus


def test_path_starts_at_the_chair_and_ends_nearer(controller) -> None:
    """On the dock's axis: beside it the first plan, made while standing, is about the way to the axis."""
    for start in ([-2.0, 0.0, 0.0], [-2.0, 0.3, 0.0]):
        controller.reset()
        pose = compose(T_COMMON_DOCK, start)
        command = controller.command(pose, (0.0, 0.0), T_COMMON_DOCK, stamp=5.0)
        end = relative(T_COMMON_DOCK, command.path[-1])
        assert command.path.shape == (31, 3) and command.path[0] == pytest.approx(pose, abs=1e-6)
        assert np.hypot(*end[:2]) < 1.5 if start[1] == 0.0 else abs(end[1]) < 0.6 * start[1]


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
    return solver, DockingController(
        CHAIR, DOCK, ControlParameters(prediction=AT_ONCE), deterministic=True, solver=solver
    )


@pytest.fixture
def failing(with_failing_solver):
    """Works until its mode is set."""
    solver, controller = with_failing_solver
    solver.mode = "work"
    controller.reset()
    controller.counters = Counters()
    return solver, controller


@pytest.mark.parametrize("mode", [seldom("fail"), "violation"])
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


def test_a_command_that_someone_else_sent_is_where_the_next_one_begins(controller) -> None:
    """A zero sent while the odometry was late: the controller goes on from it, not from its own request."""
    pose, commands = [-2.5, 0.0, 0.0], drive(controller, (-2.5, 0.0, 0.0), 0.5)[1]
    assert commands[-1].v > 0.2
    controller.history.sent(0.5, 0.0, 0.0)
    command = controller.command(compose(T_COMMON_DOCK, pose), (0.0, 0.0), T_COMMON_DOCK, stamp=0.55)
    assert command.v <= CHAIR.limits.a_max * PERIOD + 1e-9


def test_jerk_limits_with_a_stage_wise_solver_are_refused() -> None:
    with pytest.raises(ValueError, match="control/solver: is 'fatrop'"):
        DockingController(Chair(), Dock(), replace(ControlParameters(), solver="fatrop", max_jerk=1.0))
