"""A goal that a person has stopped waits, stands, and goes on only when it is resumed."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import World

from seater_nmpc.sequence.goal.results import Phase, ResultCode, Step

WHY = "the joystick was moved"
PAUSE = {"pause_time": 20.0}


def driving(make_world, **settings) -> World:
    """A chair on its way in, inside the bay's mouth or before."""
    world = make_world((-2.0, 0.05, 0.0), **{"sequence": PAUSE, **settings})
    world.tick()
    world.sequence.start_dock(world.now)
    world.run(20.0, until=lambda step: world.truth[0] > -1.2)
    return world


def pause(world: World) -> Step:
    step = world.sequence.pause(world.now, ResultCode.STOPPED_BY_USER, WHY)
    world.commands.append(step.command)
    return step


def test_it_stands_says_so_and_goes_on_from_wherever_it_was_driven(make_world) -> None:
    world = driving(make_world)
    step = pause(world)
    assert (step.phase, step.command.v, step.result) == (Phase.PAUSED, 0.0, None)
    world.moves = lambda world, v, omega: (-0.3, 0.1)  # the joystick drives
    step = world.run(3.0)
    assert step.phase is Phase.PAUSED and step.result is None and WHY in step.command.text
    assert "17 s are left to resume" in step.command.text and world.truth[0] < -1.8
    world.moves = lambda world, v, omega: (v, omega)
    world.sequence.resume(world.now)
    step = world.run(40.0)
    assert step.result is not None and step.result.code is ResultCode.SUCCESS, step.result
    assert np.hypot(*world.truth[:2]) < 0.01


def test_it_never_goes_on_by_itself_and_ends_as_without_a_pause(make_world) -> None:
    world = driving(make_world)
    pause(world)
    step = world.run(30.0)
    assert step.result is not None and step.result.code is ResultCode.STOPPED_BY_USER
    assert step.result.text == f"{WHY}, and not resumed within 20 s"
    assert all(command.v == command.omega == 0.0 for command in world.commands[-400:])
    assert not world.sequence.active and not world.sequence.paused


def test_a_pause_counts_as_no_time_of_the_goal(make_world) -> None:
    world = driving(make_world)
    before = world.run(0.05).elapsed
    pause(world)
    world.run(10.0)
    world.sequence.resume(world.now)
    assert before < world.run(0.05).elapsed < before + 0.2


def test_a_dock_out_of_sight_is_found_again_after_the_pause(make_world) -> None:
    """Carried away blindly: what was known of the dock does not count, and it is waited for as at the start."""
    world = driving(make_world, timeouts={"detect": 2.0})
    pause(world)
    world.seen = lambda world: False
    world.moves = lambda world, v, omega: (-0.3, 0.0)
    world.run(3.0)
    world.moves = lambda world, v, omega: (v, omega)
    world.sequence.resume(world.now)
    assert world.run(1.0).phase is Phase.WAITING_FOR_DOCK
    assert world.run(3.0).result.code is ResultCode.FAILED_TO_DETECT_DOCK


def test_a_paused_goal_ends_when_cancelled_or_without_odometry(make_world) -> None:
    for end in ("cancel", "odometry"):
        world = driving(make_world)
        pause(world)
        world.run(0.5)
        if end == "cancel":
            world.sequence.cancel()
        else:
            world.odometry_alive = lambda world: False
        code = ResultCode.CANCELED if end == "cancel" else ResultCode.ODOMETRY_LOST
        assert world.run(2.0).result.code is code


def test_undocking_goes_on_from_the_dock_that_it_left(make_world) -> None:
    world = make_world((0.0, 0.0, 0.0), sequence=PAUSE, seen=lambda world: False)
    world.tick()
    world.sequence.start_undock(world.now, force=True)
    world.run(20.0, until=lambda step: world.truth[0] < -0.4)
    pause(world)
    assert not world.sequence.backs_out, "the joystick is not slowed down"
    world.run(1.0)
    world.sequence.resume(world.now)
    assert world.sequence.backs_out
    assert world.run(30.0).result.success
    assert abs(world.truth[0] - world.dock.predock_x) < 0.1


def test_what_cannot_be_paused_or_resumed(make_world) -> None:
    world = driving(make_world, sequence={"pause_time": 0.0})
    assert not world.sequence.can_pause
    with pytest.raises(ValueError, match="cannot be paused"):
        pause(world)
    with pytest.raises(ValueError, match="no goal is paused"):
        world.sequence.resume(world.now)
    assert world.run(40.0).result.success
