"""What stands in the way out of the bay is named, and for how long the chair has got nowhere is known."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from conftest import World

from seater_common.geometry import Chair, Dock
from seater_nmpc.control.controller import DockingController
from seater_nmpc.plan.way_back import WayBack
from seater_nmpc.sequence.goal.results import Phase, ResultCode, Step

MARGIN = 0.02


@pytest.fixture(autouse=True)
def nothing_left(quick_controller: DockingController) -> Iterator[None]:
    """All tests use one controller."""
    yield
    quick_controller.set_obstacles([])


def box(x: float, y: float, side: float = 0.2) -> np.ndarray:
    return np.array([x, y]) + 0.5 * side * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])


def way_back(direction: str = "forward") -> WayBack:
    return WayBack(Chair(), replace(Dock(), direction=direction), MARGIN)


@pytest.mark.parametrize(
    ("x", "y", "named"),
    [
        (-0.5, 0.0, "0.10 m from the chair's rear"),
        (-0.5, 0.44, "rear"),
        (-0.5, 0.46, ""),  # beside the straight way
        (-0.75, 0.0, ""),  # farther than the next part of it
        (0.9, 0.0, ""),
    ],
)
def test_what_stands_in_the_straight_way_back(x: float, y: float, named: str) -> None:
    for here in (np.zeros(3), np.array([-1.0, 0.3, 0.4])):
        c, s = np.cos(here[2]), np.sin(here[2])
        outline = here[:2] + box(x, y) @ np.array([[c, s], [-s, c]])
        said = way_back().obstacle(here, [outline])
        assert named in said and bool(said) is bool(named)


@pytest.mark.parametrize(
    ("x", "y", "side", "turned"),
    [
        (-0.5, 0.0, "rear", "front"),
        (0.95, 0.0, "front", "rear"),
        (0.2, 0.5, "left side", "right side"),
        (0.2, -0.5, "right side", "left side"),
    ],
)
def test_the_cause_is_named_by_the_side_of_the_chair_that_people_know(x, y, side, turned) -> None:
    outlines = [box(x, y), box(3.0, 3.0)]
    assert way_back().cause(np.zeros(3), outlines).endswith(side)
    assert way_back("backward").cause(np.zeros(3), outlines).endswith(turned)
    assert way_back().cause(np.zeros(3), outlines[1:]) == ""


def test_moving_or_turning_is_getting_on() -> None:
    way = way_back()
    assert [way.update(now, np.array([x, 0.0, 0.0])) for now, x in ((5.0, 0.0), (7.0, 0.09), (8.0, -0.09))] == [0, 2, 3]
    assert way.update(9.0, np.array([-0.11, 0.0, 0.0])) == 0.0
    assert way.update(10.0, np.array([-0.11, 0.0, 3.1])) == 0.0
    assert way.update(11.0, np.array([-0.11, 0.0, -3.1])) == 1.0
    way.restart()
    assert way.update(12.0, np.zeros(3)) == 0.0


def undocking(make_world, **sequence: float) -> World:
    world = make_world((0.0, 0.0, 0.0), sequence=sequence)
    world.tick()
    world.sequence.start_undock(world.now, force=True)
    return world


def obstacles(world: World, *outlines: np.ndarray) -> None:
    world.sequence._controller.set_obstacles(outlines)


def test_backing_out_is_slow(make_world) -> None:
    world = undocking(make_world, back_out_speed=0.1)
    assert world.run(30.0).result.success
    assert -0.1 - 1e-9 <= min(command.v for command in world.commands) < -0.08


def test_what_stands_behind_the_chair_is_waited_for(make_world) -> None:
    world = undocking(make_world)
    obstacles(world, box(-0.5, 0.0))
    step = world.run(10.0)
    assert step.result is None and "waits to back out: something stands 0.10 m" in step.command.text
    assert all(command.v == 0.0 for command in world.commands)
    obstacles(world)
    assert world.run(30.0).result.success


@pytest.mark.parametrize("held", [False, True])
def test_it_waits_for_a_bounded_time_and_says_for_what(make_world, held) -> None:
    """An outline behind the chair, or a gate that lets nothing pass."""
    world = undocking(make_world, back_out_wait=5.0)
    if held:
        world.sequence.held, world.sequence.held_by, world.obeys = True, "somebody walks behind", False
    else:
        obstacles(world, box(-0.5, 0.0))
    began, step = world.now, world.run(10.0)
    assert step.result.code is ResultCode.BLOCKED and (step.command.v, step.command.omega) == (0.0, 0.0)
    assert "waited for 5 s to back out: some" in step.result.text
    assert 5.0 < world.now - began < 5.2


def test_another_attempt_does_not_begin_while_something_stands_behind(make_world) -> None:
    world = make_world((-2.0, 0.0, 0.0), sequence={"back_out_wait": 3.0})
    world.tick()
    world.sequence.start_dock(world.now)
    world.run(20.0, until=lambda step: step.phase is Phase.FINAL and world.truth[0] > -0.9)
    world.truth = world.truth + [0.0, 0.11, 0.0]  # pushed aside at the bay

    def stands_behind(step: Step) -> bool:
        if step.phase is Phase.RETRY and not world.sequence._controller.obstacles:
            obstacles(world, world.truth[:2] + box(-0.5, 0.0))
        return False

    result = world.run(10.0, until=stands_behind).result
    assert result.code is ResultCode.BLOCKED and "chair's rear" in result.text
    assert min(command.v for command in world.commands) > -0.05


def test_undocking_does_not_wait_for_images(make_world) -> None:
    """With a camera that has fallen silent, it goes by odometry, as fast as backing out may be."""
    world = make_world((0.0, 0.0, 0.0), seen=lambda world: world.now > 20.0 and round(world.now * 100) % 300 == 0)
    for _ in range(1500):
        world.tick()
    world.sequence.start_undock(world.now, force=True)
    assert world.run(30.0).result.success
    assert min(command.v for command in world.commands) < -0.14
