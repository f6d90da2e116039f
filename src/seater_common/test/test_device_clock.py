"""A device's clock against the host's: drift, jitter, wrap and leaps."""

import numpy as np
import pytest

from seater_common.device_clock import DeviceClock

LEAST = 0.020  # [s] of the delays
PERIOD = 1.0 / 30.0


def run(clock: DeviceClock, device: np.ndarray, taken: np.ndarray, jitter: float, seed: int = 1) -> np.ndarray:
    """Error of each frame's time [s]: against exposure plus the least delay, which is all that can be seen."""
    arrival = taken + LEAST + np.random.default_rng(seed).exponential(jitter, len(taken))
    found = [clock.to_host(d, a) for d, a in zip(device, arrival, strict=True)]
    assert np.all(np.array(found) <= arrival), "never in the future"
    return np.array(found) - taken - LEAST


@pytest.mark.parametrize("drift", [-100e-6, 0.0, 100e-6])
def test_ten_minutes_of_drift_and_jitter(drift: float) -> None:
    taken = 1000.0 + PERIOD * np.arange(18000)
    clock = DeviceClock()
    error = run(clock, (taken - 900.0) * (1.0 - drift), taken, jitter=0.004)
    # The fastest of 30 arrivals is 0.13 ms late on average; arrivals themselves scatter by 4 ms.
    assert np.abs(error[300:]).max() < 1.0e-3
    assert error[1800:].std() < 0.2e-3
    assert clock.drift == pytest.approx(drift, abs=10e-6)
    assert clock.restarts == 0


def test_the_first_seconds_are_no_worse_than_the_jitter() -> None:
    taken = PERIOD * np.arange(300)
    error = run(DeviceClock(), taken * (1.0 + 100e-6), taken, jitter=0.004)
    assert np.abs(error[30:]).max() < 2e-3


def test_steps_between_frames_stay_those_of_the_camera() -> None:
    taken = PERIOD * np.arange(6000)
    error = run(DeviceClock(), taken, taken, jitter=0.010)
    assert np.abs(np.diff(error[300:])).max() < 2e-3


def test_a_wrap_of_32_bits_of_microseconds_is_none_of_the_time() -> None:
    period = 2**32 * 1e-6
    taken = PERIOD * np.arange(3000)
    device = (taken + period - 50.0) % period
    assert np.any(np.diff(device) < 0.0)
    clock = DeviceClock(period)
    error = run(clock, device, taken, jitter=0.002)
    assert np.abs(error[300:]).max() < 1e-3
    assert clock.restarts == 0


@pytest.mark.parametrize("leap", [3.0, 0.3, -0.3, -3.0, -800.0])
def test_a_leap_of_the_devices_clock_is_found(leap: float) -> None:
    taken = PERIOD * np.arange(3000)
    device = taken + 900.0
    device[1500:] += leap
    clock = DeviceClock()
    error = run(clock, device, taken, jitter=0.002)
    assert clock.restarts == 1
    assert np.abs(error[1800:]).max() < 1e-3
    if leap > 0.0 or leap < -PERIOD:  # seen at once: no frame gets a time of before the leap's
        assert error[1500:].max() < 0.02


def test_a_clock_that_stood_is_found_within_two_seconds() -> None:
    taken = PERIOD * np.arange(1500)
    device = taken.copy()
    device[900:] -= 0.2 - PERIOD  # it stood for 0.2 s, without going back between two frames
    device[900:906] = device[899] + 1e-4 * np.arange(1, 7)
    clock = DeviceClock()
    error = run(clock, device, taken, jitter=0.001)
    assert clock.restarts >= 1
    assert np.abs(error[1100:]).max() < 1e-3


def test_a_host_that_stands_for_a_second_leaves_the_line_as_it_is() -> None:
    taken = PERIOD * np.arange(1500)
    clock, errors = DeviceClock(), []
    for i, t in enumerate(taken):
        arrival = max(t + LEAST, taken[630] + LEAST if 600 <= i <= 630 else 0.0)
        errors.append(clock.to_host(t, arrival) - t - LEAST)
    assert clock.restarts == 0
    assert np.abs(errors).max() < 1e-6
