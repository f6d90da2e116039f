"""What a stop shows of a chair that rolls while its brakes are open."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from conftest import seldom

from seater_nmpc.sequence.rest.creep import HOLDS, Creep, Demand, fit, likely_holds
from seater_nmpc.sequence.rest.roll import Belief, Roll, RollWatch
from seater_nmpc.sequence.rest.stops import Stops

DELAY, LAG = 0.2, (0.2, 0.2)  # [s] believed in
TICK = 0.0011  # [m] of a coarse encoder


class Chair:
    """Motors behind a delay and a lag; its roll ends as its brakes grip, and so does what the motors still do."""

    def __init__(self, speed: float = 0.0, hold: float = 1.0, *, turning: float = 0.0, late: float = 0.0) -> None:
        """Rolls with these speeds [m/s, rad/s] until `hold` [s] after the demand; `late`: as much more delay and lag
        than is believed in [s]."""
        self.rolls, self.hold, self.late = (speed, turning), hold, late

    def stops(self, belief: Belief, v: float, *, pushes: int = 0, period: float = 0.05) -> Belief:
        """After a drive at `v` [m/s], or a push of so many cycles with it, from a heading of 0.7 rad."""
        watch, pose, motor, step = RollWatch(), np.array([1.0, 2.0, 0.7]), 0.0 if pushes else v, 0.01
        ends = pushes * period + DELAY + self.late
        for k in range(round(3.0 / step)):
            now = k * step
            if k % round(period / step) == 0:
                if now < pushes * period:
                    watch.push(now, v)
                else:
                    watch.stop(now, now + DELAY + 0.7)
                ticks = np.round(pose[:2] / TICK) * TICK
                watch.see(now, [*ticks, pose[2]])
            asked = v if (now >= DELAY + self.late or not pushes) and now < ends else 0.0
            motor += step / (LAG[0] + self.late) * (asked - motor)
            opened = now < ends + self.hold and (now >= DELAY + self.late or not pushes)
            way, turn = (motor + self.rolls[0], self.rolls[1]) if opened else (0.0, 0.0)
            pose += step * np.array([way * math.cos(pose[2]), way * math.sin(pose[2]), turn])
        return belief.after(watch, DELAY, LAG)


@pytest.mark.parametrize(
    ("speed", "hold"),
    [(-0.024, 0.45), seldom(-0.024, 0.8), (-0.024, 1.5), seldom(-0.016, 0.8), (0.012, 1.5), seldom(0.02, 0.9)],
)
@pytest.mark.parametrize("late", [seldom(0.0), 0.06])
def test_one_stop_shows_the_roll_however_soon_the_brakes_grip(speed: float, hold: float, late: float) -> None:
    """To 3.5 mm: two ticks, what is rolled in a cycle, and what may be lag."""
    found = Chair(speed, hold, late=late).stops(Belief(), 0.07).roll
    assert found.way() == pytest.approx(speed * hold, abs=0.0035) and found.hold == pytest.approx(hold, abs=0.2)
    assert found.way(0.5) == pytest.approx(found.way() + 0.5 * found.speed)


def test_what_may_be_a_lag_is_reckoned_with_in_part() -> None:
    """Ahead, and over before the motors stand."""
    assert 0.0 <= Chair(0.012, 0.45, late=0.06).stops(Belief(), 0.07).roll.way() < 0.0054


@pytest.mark.parametrize("late", [0.0, 0.08, -0.08])
def test_motors_that_run_on_hardly_look_like_a_roll(late: float) -> None:
    for v, pushes in ((0.03, 0), (0.1, 0), (0.06, 6), (-0.06, 6)):
        assert abs(Chair(late=late).stops(Belief(), v, pushes=pushes).roll.way()) < 0.0025


def test_a_push_shows_it_as_well_whichever_way_it_goes() -> None:
    for v in (0.05, -0.05, 0.0):
        found = Chair(-0.02, 0.7).stops(Belief(), v, pushes=8).roll
        assert found.way() == pytest.approx(-0.014, abs=0.003), v


def test_it_turns_downhill_across_a_slope() -> None:
    """Whether it rolls as well, which shows for how long, or not."""
    for speed, least in ((0.0, 0.009), (-0.015, 0.0126)):
        found = Chair(speed, 1.3, turning=0.012).stops(Belief(), 0.06).roll
        assert least < found.turn() < 0.0186 and found.way() == pytest.approx(speed * 1.3, abs=0.003)


def test_it_is_unlearned_where_it_rolls_no_more() -> None:
    belief = Chair(-0.02, 0.9).stops(Belief(), 0.07)
    again = Chair(-0.02, 0.9).stops(belief, 0.07)
    assert again.roll.way() == pytest.approx(-0.018, abs=0.002)
    level = Chair()
    assert abs(level.stops(level.stops(again, 0.07), 0.07).roll.way()) < 0.003


def test_what_shows_nothing_leaves_what_is_known() -> None:
    """Odometry that is of no use."""
    times, known = np.arange(0.0, 2.0, 0.05), Creep(-0.02, 0.003, 0.9)
    found, holds = fit(times, np.zeros(40), Demand(0.0), DELAY, LAG[0], known, likely_holds(None), noise=10.0)
    assert (found.mean, found.sd, found.probability) == pytest.approx((-0.02, 0.003, 0.9), rel=0.01)
    assert holds == pytest.approx(likely_holds(None), rel=0.01)
    assert Belief((known, Creep()), holds).roll.speed == pytest.approx(-0.018)
    assert Belief((replace(known, probability=0.4), Creep()), holds).roll == Roll()


def test_a_chair_that_was_steered_until_it_stopped_does_not_turn_by_itself() -> None:
    watch = RollWatch()
    watch.stop(0.0, DELAY + 0.7)
    for now in np.arange(0.0, 2.5, 0.05):
        watch.see(float(now), [0.0, 0.0, 0.03 * math.sin(min(float(now), 0.8))])
    assert Belief().after(watch, DELAY, LAG).roll == Roll()


def test_a_trace_that_is_too_short_says_nothing() -> None:
    watch = RollWatch()
    watch.see(0.0, [0.0, 0.0, 0.0])
    watch.stop(0.0, 0.9)
    watch.see(0.1, [0.01, 0.0, 0.0])
    assert Belief().after(watch, DELAY, LAG) == Belief() and Belief().roll == Roll()


class Slope:
    """Rolls with these speeds [m/s, rad/s] while its brakes are open: until 1.3 s after the last command."""

    def __init__(self, speed: float, turning: float) -> None:
        self.speed, self.turning, self.idle = speed, turning, math.inf
        self.moved = (0.0, 0.0)

    def moves(self, world, v: float, omega: float) -> tuple[float, float]:
        self.idle = 0.0 if v or omega else self.idle + world.period
        self.moved = (v + self.speed, omega + self.turning) if self.idle < 1.3 else (v, omega)
        return self.moved

    def measures(self, world, odometry):
        """Encoders see the roll, too."""
        return replace(odometry, v=self.moved[0], omega=self.moved[1])


@pytest.mark.parametrize(("speed", "turning"), [seldom(0.016, 0.0), seldom(-0.012, 0.0), (-0.01, 0.006)])
def test_a_chair_that_rolls_docks_with_few_moves(make_world, speed: float, turning: float) -> None:
    world = make_world((-0.5, 0.0, 0.0), moves=Slope(speed, turning).moves)
    world.tick()
    world.sequence.start_dock(world.now)
    result = world.run(60.0).result
    assert result is not None and result.success and result.retries == 0
    assert world.phases.count("CORRECTING") <= 3 and abs(world.truth[0]) < 0.006, (world.phases, world.truth)


def test_the_next_docking_allows_for_the_roll(make_world) -> None:
    """The first one stands before the dock and drives on; the second one drives in once, and the roll is its last
    millimetres, its last degree its turn downhill."""
    slope = Slope(-0.012, 0.008)
    world = make_world((-0.9, 0.0, 0.0), moves=slope.moves, measures=slope.measures)
    world.tick()
    ends, headings, stops = [], [], []
    for _ in range(2):
        world.phases.clear()
        world.sequence.start_dock(world.now)
        result = world.run(60.0).result
        assert result is not None and result.success, result
        ends.append(float(world.truth[0]))
        headings.append(float(world.truth[2]))
        stops.append(world.phases.count("STOPPING"))
        world.sequence.start_undock(world.now)
        assert world.run(30.0).result.success
    assert stops[0] > 1 and stops[1] == 1 and abs(ends[1]) < 0.005, (stops, ends)
    assert abs(headings[1]) < 0.004 < slope.turning * 1.3, headings


def test_another_way_in_allows_for_the_mean_of_the_stops_of_a_chair_that_rolls() -> None:
    """By the last one alone it stood 11 mm to either side of the dock in turns."""
    stops, zero = Stops(), (0.0, 0.0)
    stops.ended(np.array([0.03, 0.0, 0.006]), zero, first=True)
    stops.ended(np.array([0.042, 0.0, 0.01]), zero, first=False)
    assert stops.next_off == pytest.approx([0.042, 0.01])  # it may have been another floor
    stops._belief = Belief((Creep(0.025, 0.002, 1.0), Creep()), np.where(np.isclose(HOLDS, 1.4), 1.0, 0.0))
    assert stops.next_off == pytest.approx([(0.03 + 0.042 + 0.035) / 3, 0.008], abs=2e-4)
    stops.ended(np.array([0.0, 0.0, 0.0]), None, first=False)
    assert stops.next_off == pytest.approx([(0.03 + 0.042 + 0.035) / 3, 0.008], abs=2e-4)
    stops.begin_docking()
    stops.ended(np.array([0.0, 0.0, 0.0]), None, first=True)
    assert stops.next_off is None


@pytest.mark.parametrize(("speed", "turns"), [(-0.012, False), seldom(0.0, True)])
def test_a_chair_that_rolls_is_not_turned_out_of_the_tolerance_in_its_last_attempt(make_world, speed, turns) -> None:
    """Heading 0.9 deg off, of 1.0: a turn on the spot rolled it 5 cm, and the pushes back turned it again."""
    slope = Slope(speed, 0.0)
    world = make_world((-0.9, 0.0, 0.0), moves=slope.moves, measures=slope.measures, sequence={"max_retries": 0})
    world.tick()
    world.sequence.start_dock(world.now)
    assert world.run(60.0).result.success
    world.sequence.start_undock(world.now)
    assert world.run(30.0).result.success
    world.sequence.start_dock(world.now)  # that knows its roll
    world.run(60.0, until=lambda step: step.phase.name == "STOPPING" and slope.moved == (0.0, 0.0))
    world.truth = world.truth + [0.0, 0.0, 0.0157 - world.truth[2]]
    world.phases.clear()
    result = world.run(60.0).result
    assert result is not None and result.success and ("CORRECTING" in world.phases) == turns, world.phases
