"""The contract of a base driver: silence stops, two senders stop, and the power has to be told."""

import math

import numpy as np
import pytest

from seater_base.commander import Commander
from seater_base.settings import BaseSettings

SETTINGS = BaseSettings()
STEP = 0.02


def driving(v: float = 0.5, omega: float = 0.2, until: float = 1.0) -> Commander:
    """With power since 0 and commanded until `until` [s]."""
    made = Commander(SETTINGS)
    for now in np.arange(0.0, until + 1e-9, STEP):
        made.power(True, now)
        made.velocity(v, omega, "gate", now)
        made.request(now + 1e-3)
    return made


def test_drives_as_it_is_told() -> None:
    request = driving().request(1.01)
    assert (request.v, request.omega, request.power, request.why) == (0.5, 0.2, True, "")


def test_silence_brakes_along_the_curve_and_stays_at_zero() -> None:
    made, requests = driving(), []
    for now in np.arange(1.02, 2.0, STEP):
        made.power(True, now)
        requests.append(made.request(now))
    speeds = np.array([(r.v, r.omega) for r in requests])
    begun = int(np.argmax(speeds[:, 0] < 0.5))
    assert 1.02 + begun * STEP == pytest.approx(1.3, abs=2 * STEP)
    assert np.all(-np.diff(speeds[:, 0]) <= SETTINGS.brake * STEP + 1e-9)
    moving = speeds[:, 0] > 0.0
    assert np.allclose(speeds[moving, 1] / speeds[moving, 0], 0.4)
    assert np.all(speeds[begun + round(0.5 / 1.5 / STEP) + 2 :] == 0.0)
    assert all(r.power for r in requests) and "silent" in requests[-1].why


@pytest.mark.parametrize(("on", "quiet", "why"), [(False, 0.0, "false"), (True, 0.31, "silent")])
def test_without_motor_enable_there_is_no_power_at_once(on: bool, quiet: float, why: str) -> None:
    made = driving()
    made.power(on, 1.0)
    now = 1.01 + quiet
    made.velocity(0.5, 0.0, "gate", now)
    request = made.request(now)
    assert (request.v, request.omega, request.power) == (0.0, 0.0, False)
    assert why in request.why


def test_never_heard_of_means_off() -> None:
    made = Commander(SETTINGS)
    made.velocity(0.5, 0.0, "gate", 0.0)
    assert not made.request(0.01).power


def test_a_command_of_before_the_power_moves_nothing() -> None:
    made = Commander(SETTINGS)
    made.power(False, 0.0)
    made.request(0.0)
    made.velocity(0.5, 0.0, "gate", 0.01)
    made.power(True, 0.02)
    assert made.request(0.03).v == 0.0 and made.request(0.05).v == 0.0
    made.velocity(0.5, 0.0, "gate", 0.06)
    assert made.request(0.07).v == 0.5


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_like_silence(value: float) -> None:
    made = driving()
    for now in np.arange(1.02, 1.6, STEP):
        made.power(True, now)
        made.velocity(value, 0.0, "gate", now)
        request = made.request(now)
        assert math.isfinite(request.v) and math.isfinite(request.omega)
    assert request.v < 0.5 and "not finite" in request.why


def test_two_who_command_brake() -> None:
    made = driving()
    made.velocity(0.3, 0.0, "another", 1.01)
    request = made.request(1.03)
    assert request.v < 0.5 and "two command: another, gate" in request.why
    made.power(True, 1.4)
    made.velocity(0.3, 0.0, "gate", 1.4)
    assert made.request(1.41).v == 0.3, "the other one has ended"


def test_more_than_the_limits_is_cut_off() -> None:
    request = driving(v=-9.0, omega=9.0).request(1.01)
    assert (request.v, request.omega) == (-SETTINGS.v_max, SETTINGS.omega_max)


def test_after_the_emergency_stop_of_the_base_zero_has_to_be_commanded_once() -> None:
    made = driving()
    made.emergency_stop(True)
    request = made.request(1.01)
    assert (request.v, request.power) == (0.0, False) and "pressed" in request.why
    made.velocity(0.0, 0.0, "gate", 1.02)  # while it is pressed: counts for nothing
    made.emergency_stop(False)
    for now in np.arange(1.04, 1.5, STEP):
        made.power(True, now)
        made.velocity(0.5, 0.0, "gate", now)
        request = made.request(now + 1e-3)
        assert request.v == 0.0
    assert request.power and "zero has not been commanded" in request.why
    made.velocity(0.0, 0.0, "gate", 1.5)
    made.velocity(0.5, 0.0, "gate", 1.52)
    assert made.request(1.53).v == 0.5


def test_a_base_that_was_started_waits_for_zero() -> None:
    made = driving()
    made.base_started()
    assert made.request(1.01).v < 0.5
    made.velocity(0.0, 0.0, "gate", 1.02)
    made.velocity(0.4, 0.0, "gate", 1.04)
    assert made.request(1.05).v == 0.4
