"""Stamps: of the exposure, never of the future, never backwards, and one per image."""

import math

import pytest
from virtual import PERIOD, Time, picture

from seater_camera.clock.stamps import Refusal, RefusedError, Stamper
from seater_camera.frames import Clock, Frame
from seater_camera.settings import ClockSettings


def stamper(time: Time, **settings: float) -> Stamper:
    return Stamper(ClockSettings(**settings), steady=lambda: time.steady, wall=time.wall)


def give(made: Stamper, time: Time, own: float, clock: Clock = Clock.MONOTONIC, seed: int = 0) -> float:
    return made.stamp(Frame(picture(seed), own, clock, time.steady))


def refusal(made: Stamper, time: Time, own: float, clock: Clock = Clock.MONOTONIC, seed: int = 0) -> Refusal:
    with pytest.raises(RefusedError) as error:
        give(made, time, own, clock, seed)
    return error.value.refusal


def test_the_kernels_times_become_ros_time() -> None:
    time = Time()
    assert give(stamper(time), time, time.steady - 0.03) == pytest.approx(time.wall() - 0.03, abs=1e-6)
    own = time.wall() - 0.03
    assert give(stamper(time), time, own, Clock.WALL) == pytest.approx(own, abs=1e-6)
    assert give(stamper(time), time, 0.0, Clock.ARRIVAL) == pytest.approx(time.wall(), abs=1e-6)


def test_a_told_delay_is_taken_off() -> None:
    time = Time()
    assert give(stamper(time, delay=0.012), time, time.steady) == pytest.approx(time.wall() - 0.012, abs=1e-6)


def test_a_frame_that_comes_twice_goes_out_once() -> None:
    time = Time()
    made, own = stamper(time), time.steady - 0.03
    give(made, time, own, seed=1)
    assert refusal(made, time, own, seed=2) is Refusal.REPEATED
    assert refusal(made, time, own + PERIOD / 2, seed=2) is Refusal.FROZEN
    give(made, time, own + PERIOD / 2 + 1e-3, seed=3)


@pytest.mark.parametrize(("ahead", "why"), [(0.001, Refusal.FUTURE), (-0.6, Refusal.OLD), (math.nan, Refusal.NO_TIME)])
def test_times_that_cannot_be(ahead: float, why: Refusal) -> None:
    time = Time()
    assert refusal(stamper(time), time, time.steady + ahead) is why


def test_a_wall_clock_set_back_publishes_nothing_until_it_has_caught_up() -> None:
    time = Time()
    made = stamper(time)
    last, refused = give(made, time, time.steady - 0.03, seed=0), 0
    time.wall_offset -= 2.0
    for i in range(1, 90):
        time.steady += PERIOD
        try:
            stamp = give(made, time, time.steady - 0.03, seed=i)
        except RefusedError as error:
            assert error.refusal is Refusal.BACKWARDS
            refused += 1
            continue
        assert last < stamp <= time.wall()
        last = stamp
    assert 55 <= refused <= 61


def test_stamps_go_on_after_a_camera_was_opened_anew() -> None:
    time = Time()
    made = stamper(time)
    first = give(made, time, 100.0, Clock.DEVICE, seed=1)
    made.connected(math.inf)
    time.steady += PERIOD
    assert give(made, time, 0.5, Clock.DEVICE, seed=2) > first  # its clock has begun anew
    assert made.device.restarts == 0
