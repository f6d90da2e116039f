"""A turn on the spot leaves what the push after it will turn; a chair that rolls is turned only where it must be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from conftest import FINE, seldom

from seater_nmpc.sequence.rest.after_effects import AfterEffects
from seater_nmpc.sequence.rest.roll import Roll


def test_nothing_is_known_before_the_first_move() -> None:
    effects = AfterEffects()
    assert effects.turn_of_push(-0.01) == 0.0 and not effects.shifts(0.0)


def test_turns_that_hardly_turn_the_chair_are_named() -> None:
    """Of two in a row, whatever is pushed between; one that turns it takes that back, a small error says nothing."""
    effects, off = AfterEffects(), np.array([0.0, 0.0, 0.05])
    effects.learn(True, off, off - [0.0, 0.0, 0.004])
    assert effects.in_words == ""
    effects.learn(False, off, off + [0.01, 0.0, 0.0])
    effects.learn(True, off, off)
    assert "2 turns on the spot" in effects.in_words
    effects.learn(True, off, off - [0.0, 0.0, 0.02])
    for _ in range(2):
        effects.learn(True, 0.1 * off, 0.1 * off)
    assert effects.in_words == ""


def test_turns_are_in_vain_where_the_pushes_after_them_turn_the_chair_back() -> None:
    off, turned = np.array([0.0, 0.0, -0.018]), np.array([0.033, 0.0, -0.006])
    for shifts, back, in_vain in ((1.0, -0.017, True), (1.0, -0.010, False), (0.2, -0.017, False)):
        effects, there = AfterEffects(), turned * [shifts, 1.0, 1.0]
        effects.learn(True, off, there)
        assert not effects.are_in_vain(back, 0.01), "nothing has been pushed"
        effects.learn(False, there, np.array([0.002, 0.0, back]))
        assert effects.are_in_vain(back, 0.01) is in_vain, (shifts, back)


def test_the_turn_per_metre_of_a_push_is_learned() -> None:
    effects = AfterEffects()
    effects.learn(False, np.array([-0.02, 0.0, -0.02]), np.array([-0.01, 0.0, -0.026]))
    assert effects.turn_of_push(-0.02) == pytest.approx(-0.6 * 0.02)
    assert effects.turn_of_push(0.01) == pytest.approx(0.6 * 0.01)  # backward, it turns the other way
    effects.learn(False, np.array([-0.02, 0.0, 0.0]), np.array([-0.01, 0.0, -0.002]))
    assert effects.turn_of_push(-0.01) == pytest.approx(-0.4 * 0.01)  # the mean
    effects.learn(False, np.array([-0.002, 0.0, 0.0]), np.array([-0.0005, 0.0, 0.1]))  # too short to say anything
    assert effects.turn_of_push(-0.01) == pytest.approx(-0.4 * 0.01)
    for _ in range(20):
        effects.learn(False, np.array([-0.02, 0.0, 3.1]), np.array([-0.01, 0.0, -3.1]))
    assert effects.turn_of_push(-0.01) == pytest.approx(0.03, rel=1e-3)  # 3 rad/m at most


def test_the_turn_of_a_push_against_a_roll_is_that_of_the_way_it_is_driven() -> None:
    """Driven back 54 mm, rolled ahead 50 mm, turned by 0.7 deg each time: per metre that it got that is 3 rad, and of
    the push from 49 mm on, after the turn, 3 deg the other way were expected."""
    effects = AfterEffects()
    effects.roll = Roll(0.026, 1.45, 0.007)
    for x in (0.024, 0.02):
        effects.learn(False, np.array([x, 0.0, 0.0]), np.array([x - 0.004, 0.0, 0.0125]), 0.5)
    assert effects.turn_of_push(0.004) == pytest.approx(0.0125, abs=0.0005)
    assert 0.01 < effects.turn_of_push(0.049) < 0.015


def test_the_shift_of_a_turn_is_learned() -> None:
    effects = AfterEffects()
    effects.learn(True, np.array([0.0, 0.0, 0.02]), np.array([-0.02, 0.0, 0.0]))
    assert effects.shifts(0.019) and not effects.shifts(0.021) and effects.way_per_turn == pytest.approx(-0.02)


class Castors:
    """Each turn on the spot swings them out; driving on, they turn the chair by `rate` [rad/m] the other way, and the
    turn itself pushes it back a little."""

    def __init__(self, rate: float) -> None:
        self.rate, self.swung = rate, 0.0

    def moves(self, world, v, omega):
        if world.phases[-1:] != ["CORRECTING"]:
            return v, omega
        if omega != 0.0:
            self.swung = math.copysign(1.0, omega)
            return -0.06, omega
        return v, omega - self.swung * self.rate * abs(v)


def moves_until_docked(make_world, rate: float) -> tuple[int, float]:
    world = make_world((-0.5, 0.0, 1.5), sequence={"hold_heading": 0.004, "release_heading": 0.006}, **FINE)
    world.moves = Castors(rate).moves
    world.tick()
    world.sequence.start_dock(world.now)
    pushed = []

    def turn_it(step) -> bool:
        if step.phase.name == "STOPPING" and not pushed:
            pushed.append(True)
            world.truth = world.truth + [0.0, 0.0, 0.03]
        return False

    result = world.run(60.0, until=turn_it).result
    assert result is not None and result.success, result
    return world.phases.count("CORRECTING"), abs(float(world.truth[2]))


@pytest.mark.parametrize(("rate", "most"), [seldom(0.5, 2), (2.0, 6)])
def test_a_push_that_undoes_the_turn_is_reckoned_with(make_world, rate: float, most: int) -> None:
    """Turn and push went to and fro until the moves were used up: ten from 2 rad/m on."""
    moves, heading = moves_until_docked(make_world, rate)
    assert moves <= most and heading < 0.008, (moves, heading)
