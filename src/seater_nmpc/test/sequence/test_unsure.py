"""While it is not known what is in the way the chair stands, and not for ever."""

from __future__ import annotations

import pytest
from conftest import World, seldom

from seater_nmpc.sequence.goal.results import Phase, ResultCode

WHY = "nothing new on `obstacles` for 0.5 s"


def driving(make_world, kind: str) -> World:
    world = make_world((-2.5, 0.5, 0.0) if kind == "dock" else (0.0, 0.0, 0.0), sequence={"obstacle_wait": 8.0})
    world.tick()
    if kind == "dock":
        world.sequence.start_dock(world.now)
    else:
        world.sequence.start_undock(world.now, force=True)
    world.run(20.0, until=lambda step: abs(step.command.v) > 0.1)
    return world


@pytest.mark.parametrize("kind", ["dock", seldom("undock")])
def test_the_chair_stands_while_it_is_not_known_what_is_in_the_way(make_world, kind) -> None:
    """Longer than any patience with a chair that gets nowhere; then it goes on."""
    world = driving(make_world, kind)
    world.sequence.unsure = WHY
    step = world.run(7.0)
    assert step.result is None and step.command.text == f"waits to know what is in the way: {WHY}"
    assert all(command.v == command.omega == 0.0 for command in world.commands[-139:])
    world.sequence.unsure = ""
    assert world.run(40.0).result.success


@pytest.mark.parametrize(
    "outline", [seldom([(-5, -5), (5, -5), (5, 5), (-5, 5)]), [(-3.0, 0.2), (-1.4, 0.2), (-1.4, 0.8)]]
)
def test_a_chair_does_not_flee_from_an_obstacle_that_it_would_stand_in(make_world, outline) -> None:
    world = driving(make_world, "dock")
    world.sequence._controller.set_obstacles([outline])
    before = world.truth.copy()
    step = world.run(7.0)
    assert step.result is None and step.command.text.endswith("an obstacle is told where the chair itself stands")
    assert world.truth[0] > before[0] - 0.01 and all(command.v >= 0.0 for command in world.commands[-139:])
    world.sequence._controller.set_obstacles([])
    assert world.run(40.0).result.success


def test_it_does_not_wait_for_ever(make_world) -> None:
    world = driving(make_world, "dock")
    world.sequence.unsure, began = WHY, world.now
    step = world.run(20.0)
    assert step.result is not None and step.result.code is ResultCode.BLOCKED
    assert step.result.text == f"waited for 8 s to know what is in the way: {WHY}"
    assert 8.0 < world.now - began < 8.2 and step.result.retries == 0


def test_who_stands_anyway_does_not_wait(make_world) -> None:
    """Looking for the dock and verifying move nothing."""
    world = make_world((-2.0, 0.0, 0.0), seen=lambda world: False, timeouts={"detect": 3.0})
    world.sequence.unsure = WHY
    world.tick()
    world.sequence.start_dock(world.now)
    step = world.run(2.0)
    assert step.phase is Phase.WAITING_FOR_DOCK and step.command.text == ""
