"""A goal that ends at the predock point: the chair stands there, whichever side it came from."""

import math

import numpy as np
import pytest
from conftest import seldom

from seater_nmpc.sequence.goal.results import Phase, ResultCode


def stage(world, seconds: float = 40.0):
    """The last step of the goal."""
    world.tick()
    world.sequence.start_dock(world.now, staging=True)
    step = world.run(seconds)
    assert step.done and (step.command.v, step.command.omega) == (0.0, 0.0) and not world.sequence.active
    return step


@pytest.mark.parametrize(
    "start", [(-2.0, -0.7, 25.0), seldom((-2.5, 0.0, 0.0)), seldom((-1.6, 0.3, -5.0)), (-0.6, 0.02, 1.0)]
)
def test_the_chair_stands_at_the_predock_point(make_world, start) -> None:
    world = make_world(start)
    result = stage(world).result
    assert result.code is ResultCode.SUCCESS and result.text == "stands at the predock point"
    off = world.truth - [world.dock.predock_x, 0.0, 0.0]
    assert np.hypot(off[0], off[1]) < 0.035 and abs(off[2]) < 0.11  # 2 cm and half a cycle; predock_heading
    assert abs(world.v) < 0.003
    assert [result.longitudinal_error, result.lateral_error, result.heading_error] == pytest.approx(off, abs=0.01)
    assert world.phases[-1] == "STAGING" and "FINAL" not in world.phases


def test_a_docked_chair_backs_out_slowly(make_world) -> None:
    world = make_world((0.0, 0.0, 0.0))
    world.tick()
    world.sequence.start_dock(world.now, staging=True)
    step = world.run(2.0, lambda step: step.command.v < -0.05)
    assert step.phase is Phase.STAGING and world.sequence.backs_out
    assert world.run(30.0).result.code is ResultCode.SUCCESS
    assert min(command.v for command in world.commands) >= -0.151  # back_out_speed
    assert world.smallest_clearance > 0.05


def test_a_chair_at_the_predock_point_stays(make_world) -> None:
    world = make_world((-1.21, 0.01, 0.5))
    assert stage(world, 3.0).result.code is ResultCode.SUCCESS
    assert all(command.v == command.omega == 0.0 for command in world.commands)


def test_a_chair_that_does_not_get_there_says_so(make_world) -> None:
    world = make_world((-1.6, 0.0, 0.0), moves=lambda w, v, omega: (0.0, 0.0))
    result = stage(world).result
    assert result.code in (ResultCode.FAILED_TO_STAGE, ResultCode.BLOCKED), result
    assert math.isclose(world.truth[0], -1.6)


def test_the_next_goal_docks(make_world) -> None:
    world = make_world((-1.6, 0.0, 0.0))
    stage(world)
    world.sequence.start_dock(world.now)
    assert world.run(40.0).result.code is ResultCode.SUCCESS
    assert np.hypot(*world.truth[:2]) < world.dock.tolerance.position
