"""What a stop shows of a chair that rolls while its brakes are open."""

from __future__ import annotations

import math

import numpy as np
import pytest
from conftest import seldom

from seater_nmpc.sequence.rest.roll import Roll, RollWatch

DEMAND_ENDS, MOTORS_STAND, PERIOD = 10.0, 10.7, 0.08
TICK = 0.0011  # [m] of a coarse encoder


def seen(speed: float, hold: float, heading: float = 0.7, waits: float = 1.5) -> Roll:
    """By the odometry of a chair that rolls so fast until its brakes hold."""
    watch = RollWatch(DEMAND_ENDS, MOTORS_STAND)
    for now in np.arange(DEMAND_ENDS, DEMAND_ENDS + hold + waits, PERIOD):
        way = TICK * round(speed * (min(now, DEMAND_ENDS + hold) - DEMAND_ENDS) / TICK)
        watch.see(float(now), [1.0 + way * math.cos(heading), 2.0 + way * math.sin(heading), heading])
    return watch.seen


@pytest.mark.parametrize("speed", [-0.02, -0.009, 0.012, 0.016])
@pytest.mark.parametrize("hold", [1.2, 1.5])
def test_speed_and_time_of_the_roll_are_measured(speed: float, hold: float) -> None:
    """To 3 mm: two ticks, and what is rolled in a cycle."""
    found = seen(speed, hold)
    assert found.way() == pytest.approx(speed * hold, abs=0.003) and found.hold == pytest.approx(hold, abs=0.2)
    assert found.way(0.5) == pytest.approx(found.way() + 0.5 * found.speed)


def test_a_chair_that_stands_by_then_or_moves_by_a_tick_does_not_roll() -> None:
    assert seen(0.02, 0.6) == Roll() and seen(0.001, 1.5) == Roll() and RollWatch(0.0, 1.0).seen == Roll()


def test_it_turns_downhill_across_a_slope() -> None:
    """Whether it rolls as well or not."""
    for speed in (0.0, -0.012):
        watch = RollWatch(DEMAND_ENDS, MOTORS_STAND)
        for now in np.arange(DEMAND_ENDS, 13.0, PERIOD):
            rolled = min(float(now), DEMAND_ENDS + 1.4) - DEMAND_ENDS
            watch.see(float(now), [speed * rolled, 0.0, 0.012 * rolled])
        assert watch.seen.turn() == pytest.approx(0.012 * 1.4, abs=0.002)
        assert watch.seen.way() == pytest.approx(speed * 1.4, abs=0.002)


def test_stops_are_averaged_and_one_that_shows_nothing_halves_it() -> None:
    assert Roll().after(Roll(0.02, 1.2)) == Roll(0.02, 1.2)
    mean = Roll(0.02, 1.2).after(Roll(0.01, 1.4))
    assert (mean.speed, mean.hold) == pytest.approx((0.015, 1.3))
    assert Roll(0.02, 1.2).after(Roll()) == Roll(0.01, 1.2)


def test_a_stop_in_which_motors_run_on_until_the_brakes_hold_says_nothing() -> None:
    late = RollWatch(DEMAND_ENDS, DEMAND_ENDS + 1.3)
    late.see(12.0, [0.0, 0.0, 0.0])
    assert late.seen == Roll() and not late.would_show(Roll(0.02, 1.1))
    assert late.would_show(Roll()) and late.would_show(Roll(0.02, 1.5))


class Slope:
    """Rolls with these speeds [m/s, rad/s] while its brakes are open: until 1.3 s after the last command."""

    def __init__(self, speed: float, turning: float) -> None:
        self.speed, self.turning, self.idle = speed, turning, math.inf

    def moves(self, world, v: float, omega: float) -> tuple[float, float]:
        self.idle = 0.0 if v or omega else self.idle + world.period
        return (v + self.speed, omega + self.turning) if self.idle < 1.3 else (v, omega)


@pytest.mark.parametrize(("speed", "turning"), [seldom(0.016, 0.0), seldom(-0.012, 0.0), (-0.01, 0.006)])
def test_a_chair_that_rolls_docks_with_few_moves(make_world, speed: float, turning: float) -> None:
    world = make_world((-0.5, 0.0, 0.0), moves=Slope(speed, turning).moves)
    world.tick()
    world.sequence.start_dock(world.now)
    result = world.run(60.0).result
    assert result is not None and result.success and result.retries == 0
    assert world.phases.count("CORRECTING") <= 3 and abs(world.truth[0]) < 0.006, (world.phases, world.truth)
