"""Wheels that spin, odometry that trembles, a chair that creeps though its motors stand: found on a tester's plant."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from conftest import FINE, T_ODOM_DOCK, seldom

from seater_common.geometry import Bay, Chair, Dock, Marker
from seater_common.se2 import arc_step, compose, inverse
from seater_nmpc.plan.corridor import room_beyond
from seater_nmpc.sequence.goal.results import Phase


class WetSpot:
    """From x = `at` on for 0.3 m one wheel slips; the odometry, which counts its turns, knows nothing of it."""

    def __init__(self, at: float, turn: float) -> None:
        """`turn` [rad/m]: a chair of 0.55 m track turns by 1.1 where a wheel slips by 60 %, by 1.6 where by 90 %."""
        self.at, self.turn, self.wheels = at, turn, None

    def moves(self, world, v, omega):
        on_it = self.at <= world.truth[0] <= self.at + 0.3
        self.commanded = (v, omega)
        return (0.7 * v, omega + self.turn * v) if on_it else (v, omega)

    def measures(self, world, odometry):
        if self.wheels is None:
            self.wheels = compose(T_ODOM_DOCK, world.truth)
        self.wheels = arc_step(self.wheels, *self.commanded, world.period)
        return replace(odometry, pose=self.wheels, v=self.commanded[0], omega=self.commanded[1])


@pytest.mark.parametrize(
    ("at", "turn"), [(-0.8, 1.1), seldom(-0.5, 1.1), seldom(-0.8, 1.6), seldom(-0.8, -1.6), seldom(-0.5, 1.6)]
)
def test_a_wheel_that_spins_in_front_of_the_bay(make_world, at: float, turn: float) -> None:
    """It turned 17 deg against a wall, as no filter believed the images any more. Where it is too wet, the
    docking ends; no wall is touched."""
    world = make_world((-2.0, 0.1, 0.0), seen=lambda w: round(w.now * 100) % 12 == 0, **FINE)  # 8 Hz
    spot = WetSpot(at, turn)
    world.moves, world.measures = spot.moves, spot.measures
    world.tick()
    world.sequence.start_dock(world.now)
    off = []

    def estimate_is_off(step) -> bool:
        estimate = world.sequence.observer.estimate()
        if estimate is not None:
            expected = compose(spot.wheels, inverse(world.truth))
            off.append(abs(math.remainder(estimate.pose[2] - expected[2], 2.0 * math.pi)))
        return False

    step = world.run(60.0, until=estimate_is_off)
    assert step.result is not None and (step.result.success or abs(turn) > 1.5), step.result
    assert world.smallest_clearance > 0.02 and max(off) < math.radians(4.0)


@pytest.mark.parametrize("noise", [seldom(0.0005), seldom(0.001), 0.002])
def test_odometry_with_noise_stands_all_the_same(make_world, noise: float) -> None:
    """As from matching laser scans or images: [m, rad] in each pose."""
    rng = np.random.default_rng(4)
    world = make_world((-1.2, 0.02, 1.0))
    world.measures = lambda world, odometry: replace(odometry, pose=odometry.pose + rng.normal(size=3) * noise)
    world.tick()
    world.sequence.start_dock(world.now)
    assert world.run(40.0).result.success


def test_a_chair_that_creeps_is_not_docked(make_world) -> None:
    """At 13 mm/s a chair was called docked: verification looked at its wheels when it began, and not again."""
    world = make_world((-1.0, 0.0, 0.0))
    world.tick()
    world.sequence.start_dock(world.now)
    world.moves = lambda w, v, omega: (v - 0.013, omega) if "VERIFY" in w.phases else (v, omega)
    step = world.run(60.0, until=lambda step: step.phase is Phase.STOPPING and "VERIFY" in world.phases)
    assert step.result is None and abs(step.command.v) == 0.0
    step = world.run(60.0)
    assert not step.result.success and "come to rest" in step.result.text, step.result


@pytest.mark.parametrize("after", [seldom(0.1), 0.15, seldom(0.2)])
def test_a_chair_that_is_pushed_while_it_is_verified_is_measured_anew(make_world, after: float) -> None:
    """By 12 mm in a moment, on tyres that slide: images before and after gave a mean within the tolerance."""
    world = make_world((-1.0, 0.0, 0.0))
    world.measures = lambda w, odometry: replace(odometry, pose=compose(T_ODOM_DOCK, w.truth - w.pushed))
    world.shows = lambda w, found: [replace(seen, covariance=16.0 * seen.covariance) for seen in found]  # ill told
    world.pushed, began = np.zeros(3), []

    def push(step) -> bool:
        began.extend([world.now] if step.phase is Phase.VERIFY and not began else [])
        if began and world.now - began[0] >= after and not world.pushed.any():
            world.pushed = np.array([0.0, 0.013, 0.0])
            world.truth = world.truth + world.pushed
        return False

    world.tick()
    world.sequence.start_dock(world.now)
    step = world.run(60.0, until=push)
    assert world.pushed.any() and step.result is not None
    assert not step.result.success or math.hypot(*world.truth[:2]) <= 0.01


def test_a_chair_that_castors_push_away_again_and_again_is_stopped(make_world) -> None:
    """It went to and fro for a minute, a centimetre before the dock, until FINAL timed out; small moves do better."""
    world = make_world((-0.8, 0.0, 0.0))
    near: list[float] = []

    def pushed(w, v, omega):
        if w.phases[-1:] != ["FINAL"] or w.truth[0] < -0.015:
            return v, omega
        near.append(w.now)
        return 0.02 * math.sin(6.0 * w.now), 0.12 * math.cos(3.0 * w.now)

    world.moves = pushed
    world.tick()
    world.sequence.start_dock(world.now)
    step = world.run(30.0, until=lambda step: step.phase is Phase.STOPPING)
    assert step.phase is Phase.STOPPING and 3.0 < world.now - near[0] < 6.0
    assert world.run(30.0).result.success


class RollsOn:
    """On a slope: whenever it is asked to stand, it goes on by itself until its brakes hold, 1.2 s later."""

    def __init__(self, speed: float) -> None:
        self.speed, self.asked = speed, -math.inf

    def moves(self, world, v, omega):
        if (v, omega) != (0.0, 0.0):
            self.asked = world.now
        return (v or self.speed, omega) if world.now - self.asked < 1.2 else (0.0, 0.0)


@pytest.mark.parametrize("speed", [seldom(0.03), 0.045])
def test_a_chair_that_rolls_on_after_each_stop_is_stopped_earlier_the_next_time(make_world, speed: float) -> None:
    """By 36 and 54 mm towards the dock; the second is more than small moves can mend."""
    world = make_world((-1.3, 0.0, 0.0))
    world.moves = RollsOn(speed).moves
    world.tick()
    world.sequence.start_dock(world.now)
    step = world.run(60.0)
    assert step.result is not None and step.result.success, step.result
    assert abs(world.truth[0]) < 0.01 and step.result.retries <= 1
    assert max(pose[0] for pose in world.track) < 1.2 * speed + 0.01


def test_a_chair_that_rolls_back_after_each_stop_is_stopped_beyond_the_dock(make_world) -> None:
    """By 30 mm, and short pushes do not move it: it tried again from the predock point until it had to give up."""
    world, rolls = make_world((-1.3, 0.0, 0.0)), RollsOn(-0.025)
    world.moves = lambda w, v, omega: rolls.moves(w, 0.0 if w.phases[-1:] == ["CORRECTING"] else v, omega)
    world.tick()
    world.sequence.start_dock(world.now)
    step = world.run(60.0)
    assert step.result is not None and step.result.success, step.result
    assert abs(world.truth[0]) < 0.01 and step.result.retries == 0
    assert 0.02 < max(pose[0] for pose in world.track) < 0.04


def test_it_is_not_driven_beyond_the_dock_to_where_something_stands() -> None:
    near, wide = Bay(back_wall_x=0.79), Bay(back_wall_x=2.0, side_wall_length=0.0)
    post, aside = Marker(0, 0.1, [0.8, 0.0, 0.7]), Marker(0, 0.1, [0.8, 0.6, 0.7])
    rooms = [room_beyond(Chair(), dock) for dock in (Dock(), Dock(bay=near), Dock(bay=Bay(back_wall_x=0.76)))]
    assert rooms == pytest.approx([0.04, 0.01, 0.0])
    assert room_beyond(Chair(), Dock(bay=wide, markers=[post])) == pytest.approx(0.02)
    assert room_beyond(Chair(), Dock(bay=wide, markers=[aside])) == 0.04


def test_a_stop_that_was_timed_badly_is_no_slope(make_world) -> None:
    """It stood a centimetre too far, and where it was to roll as far after a small move, none seemed of use."""
    world = make_world((-1.3, 0.0, 0.0))
    stops: list[float] = []

    def late(w, v, omega):
        if w.phases[-1:] == ["STOPPING"] and "CORRECTING" not in w.phases:
            stops.append(w.now)
            return (0.08, 0.0) if w.now - stops[0] < 0.15 else (v, omega)
        return v, omega

    world.moves = late
    world.tick()
    world.sequence.start_dock(world.now)
    step = world.run(60.0, until=lambda step: step.phase in (Phase.CORRECTING, Phase.RETRY))
    assert step.phase is Phase.CORRECTING and world.truth[0] > 0.009, (step, world.truth)
    result = world.run(30.0).result
    assert result.success and result.retries == 0 and abs(world.truth[0]) < 0.006


def test_a_chair_is_not_judged_before_its_motors_have_to_stand(make_world) -> None:
    """Motors that still pushed it back against its roll held it on the spot for 0.3 s; then it rolled 20 mm on."""
    world = make_world((-0.6, 0.0, 0.0))
    world.tick()
    world.sequence.start_dock(world.now)
    world.run(30.0, until=lambda step: step.phase is Phase.STOPPING)
    stopped, world.sequence._controller.history.delay = world.now, 1.0
    step = world.run(10.0, until=lambda step: step.phase is not Phase.STOPPING)
    assert step.phase in (Phase.VERIFY, Phase.CORRECTING) and 1.2 < world.now - stopped < 2.0


def test_moves_are_counted_until_the_chair_leaves_the_dock(make_world) -> None:
    """One that crept back each time that it was verified was pushed in again for two minutes, until TIMEOUT."""
    world = make_world((-0.6, 0.0, 0.0), sequence={"max_moves": 4, "max_retries": 0})
    world.moves = lambda w, v, omega: (v - 0.02, omega) if "VERIFY" in w.phases[-1:] else (v, omega)
    world.tick()
    world.sequence.start_dock(world.now)
    result = world.run(40.0).result
    assert result is not None and world.phases.count("CORRECTING") <= 4
