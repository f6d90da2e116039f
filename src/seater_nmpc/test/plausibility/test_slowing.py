"""A chair that is told to slow down: one that does, late or by too little, and one that does not."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from seater_common.geometry import Chair
from seater_nmpc.drive.prediction import CommandHistory
from seater_nmpc.parameters import Prediction
from seater_nmpc.plausibility.slowing import Slowing

CYCLE, BEGINS = 0.05, 2.0  # [s]
DELAY, LAG = 0.2, 0.25  # [s] believed


def begun() -> Slowing:
    return Slowing(CommandHistory(Prediction(command_delay=DELAY, motor_lag=LAG)), Chair().limits)


def asked(stamp: float) -> float:
    """0.6 m/s, from 2 s on 0.3 m/s^2 less, down to 0.15 m/s: into a bay."""
    return max(0.15, 0.6 - 0.3 * max(0.0, stamp - BEGINS))


def noticed(delay: float = DELAY, lag: float = LAG, share: float = 1.0, keeps: float = 0.0, hill: float = 0.0) -> float:
    """When [s] it is noticed that a chair does not slow down; infinite: never. Its motors have this delay and lag, do
    `share` of the slowing down that they are asked for, and keep to the speed `keeps` [m/s] at least; it is `hill`
    [m/s] faster than asked."""
    slowing = begun()
    speed = asked(0.0)
    for cycle in range(1, 100):
        now = CYCLE * cycle
        told = 0.6 - share * (0.6 - asked(now - delay))
        speed += (max(told, keeps) - speed) * (1.0 - math.exp(-CYCLE / lag))
        if slowing.keeps(now, speed + hill, asked) is not None:
            return now
    return math.inf


def test_one_that_keeps_its_speed_is_noticed_within_half_a_second_of_when_it_should_have_slowed_down() -> None:
    """Commands act after the delay and the lag: 0.3 s of that are a window."""
    assert BEGINS + DELAY + LAG < noticed(keeps=0.6) < BEGINS + DELAY + LAG + 0.4
    assert noticed(share=0.2) < BEGINS + DELAY + LAG + 0.5
    # It drives as asked until 0.4 m/s, 0.67 s later.
    assert BEGINS + 0.6 + DELAY + LAG < noticed(keeps=0.4) < BEGINS + 0.6 + DELAY + LAG + 0.5


@pytest.mark.parametrize(
    "chair",
    [
        {},
        {"delay": DELAY + 0.1},
        {"delay": DELAY - 0.1},
        {"lag": 2.0 * LAG},
        {"share": 0.6},
        {"hill": 0.08},
        {"delay": DELAY + 0.1, "lag": 1.5 * LAG, "hill": 0.05},
    ],
)
def test_one_that_obeys_is_not(chair: dict[str, float]) -> None:
    assert noticed(**chair) == math.inf


@pytest.mark.parametrize("later", [0.0, 0.1, 0.2])
def test_one_that_is_told_to_stop_at_once_brakes_as_it_can(later: float) -> None:
    """Its delay had been learned too short, and zero was asked for at 0.55 m/s: four of twelve dockings with one marker
    ended with RUNAWAY."""
    slowing, speed = begun(), 0.55
    for cycle in range(1, 100):
        now = CYCLE * cycle
        braking = now > BEGINS + DELAY + later
        speed -= min(speed, 0.4 * CYCLE) if braking else 0.0
        assert slowing.keeps(now, speed, lambda stamp: 0.0 if stamp >= BEGINS else 0.55) is None


def test_backward_is_the_same() -> None:
    """And what was expected has the sign of the way it drives."""
    slowing, back = begun(), mirrored(asked)
    found = [slowing.keeps(CYCLE * cycle, -0.6, back) for cycle in range(1, 100)]
    assert found[: int(BEGINS / CYCLE)] == [None] * int(BEGINS / CYCLE)
    assert any(one is not None and -0.6 < one < -0.15 for one in found)


def mirrored(of: Callable[[float], float]) -> Callable[[float], float]:
    return lambda stamp: -of(stamp)


def test_one_that_has_just_been_late_to_speed_up_is_late_to_slow_down() -> None:
    """Its delay and its lag, here 0.4 and 0.3 s, are longer than is known yet, here 0.15 and 0.2 s."""

    def soon(stamp: float) -> float:
        return 0.5 * stamp if stamp < 1.2 else max(0.3, 0.6 - 0.3 * max(0.0, stamp - 1.5))

    slowing, speed = Slowing(CommandHistory(Prediction(command_delay=0.15, motor_lag=0.2)), Chair().limits), 0.0
    for cycle in range(1, 60):
        now = CYCLE * cycle
        speed += (soon(max(0.0, now - 0.4)) - speed) * (1.0 - math.exp(-CYCLE / 0.3))
        assert slowing.keeps(now, speed, soon) is None


def over_a_sill(springs: float, held: float, keeps: float = 0.0) -> float:
    """When [s] it is noticed that a chair does not slow down; infinite: never. It is slower than asked by `held` [m/s]
    at 2.9 s, then up to `springs` [m/s] faster for 0.25 s; with `keeps` [s] for so long, at the same speed."""
    slowing, most = begun(), 0.0
    for cycle in range(1, 100):
        now = CYCLE * cycle
        speed, since = asked(now - DELAY - LAG), now - 2.85
        if 0.0 < since < 0.12:
            speed -= held
        elif 0.17 < since < max(0.42, keeps):
            speed = most = max(speed + springs, most if keeps else 0.0)
        if slowing.keeps(now, speed, asked) is not None:
            return now
    return math.inf


@pytest.mark.parametrize("held", [0.03, 0.06])
@pytest.mark.parametrize("springs", [0.08, 0.12])
def test_one_that_a_sill_has_held_springs_ahead(springs: float, held: float) -> None:
    """Two of 180 chairs of rigid bodies ended with RUNAWAY behind sills of 5 and 6 mm."""
    assert over_a_sill(springs, held) == math.inf


def test_one_that_keeps_that_speed_is_noticed() -> None:
    assert over_a_sill(0.08, 0.06, keeps=9.0) < 2.85 + 0.7


def test_one_that_speeds_up_instead_is_noticed() -> None:
    """As soon as the 0.4 s are over in which it might swing back."""
    slowing, found = begun(), math.inf
    for cycle in range(1, 100):
        now = CYCLE * cycle
        speed = asked(now - DELAY - LAG) + max(0.0, now - 2.9)
        if slowing.keeps(now, speed, asked) is not None:
            found = min(found, now)
    assert found < 2.9 + 0.55


def test_one_that_drives_as_asked_is_none_whatever_gain_was_learned() -> None:
    """The patch on which it has slipped by a quarter ends as it is to slow down: two of 40 ended with RUNAWAY."""
    slowing = Slowing(CommandHistory(Prediction(command_delay=0.02, motor_lag=0.05, gain_v=0.77)), Chair().limits)
    speed = 0.0
    for cycle in range(1, 100):
        now = CYCLE * cycle
        grips = min(1.0, 0.77 + 0.45 * max(0.0, now - BEGINS))
        speed += (grips * asked(now) - speed) * (1.0 - math.exp(-CYCLE / 0.05))
        assert slowing.keeps(now, speed, asked) is None, now
