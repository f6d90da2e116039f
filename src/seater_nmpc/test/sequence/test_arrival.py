"""The last centimetres: so slow that a push aside is seen, and answered, while there is way left."""

from __future__ import annotations

import pytest
from conftest import FINE

_NEAR = -0.14  # [m] of the dock's axis


def arrive(world) -> tuple[float, float, list[tuple[float, float]]]:
    """Reaction time [s], duration [s], and (x, v) [m, m/s] of the cycles of the final straight."""
    driven: list[tuple[float, float]] = []

    def note(step) -> bool:
        if world.phases[-1:] == ["FINAL"]:
            driven.append((float(world.truth[0]), step.command.v))
        return False

    world.tick()
    world.sequence.start_dock(world.now)
    assert world.run(60.0, until=note).result.success
    history = world.sequence._controller.history
    return history.delay + history.drive.lag_v + world.sequence.observer.images.period, world.now, driven


def with_eight_images_a_second(world):
    """The others do not come."""
    world.seen, add = lambda w: round(w.now * 100) % 12 == 0, world.sequence.add_detections
    world.sequence.add_detections = lambda stamp, found: add(stamp, found) if found else None
    return world


def test_no_more_is_driven_near_the_dock_than_can_be_mended(make_world) -> None:
    way = 0.008
    world = with_eight_images_a_second(make_world((-0.7, 0.01, 0.0), sequence={"arrival_way": way}, **FINE))
    reaction, _, driven = arrive(world)
    assert reaction > 0.1
    assert max(v for x, v in driven if x > _NEAR) * reaction <= way + 0.001
    assert max(v for x, v in driven if x < 2.0 * _NEAR) * reaction > 1.5 * way  # before, it drives as usual


def test_a_chair_that_reacts_at_once_is_not_slowed_down(make_world) -> None:
    _, usual, _ = arrive(make_world((-0.7, 0.01, 0.0), **FINE))
    reaction, free, _ = arrive(make_world((-0.7, 0.01, 0.0), sequence={"arrival_way": 10.0}, **FINE))
    assert reaction < 0.04 and usual == pytest.approx(free, abs=0.05)
