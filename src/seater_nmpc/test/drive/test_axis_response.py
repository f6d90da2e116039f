"""Delay, lag and deadband, learned from the response of a simulated axis."""

import math

import numpy as np
import pytest

from seater_nmpc.drive.axis import AxisDrive
from seater_nmpc.drive.axis_response import AxisResponseEstimator, Expected

TURNING = Expected(widths=(0.01, 0.02, 0.03, 0.05, 0.085), typical=0.04, noise=0.012)
CYCLE, MESSAGE, PIECES = 0.05, 0.02, 4  # [s] between commands and between measurements; pieces of a simulated message
DELAY, LAG = 0.25, 0.3  # [s] of the axis


def swings(t: float) -> float:
    """Turning on the way to a dock: swings that get smaller [rad/s]."""
    return 0.35 * math.sin(math.pi * t / 2.0) * math.exp(-t / 6.0) + (0.05 * math.sin(5.0 * t) if t < 10.0 else 0.0)


def respond(
    estimator, drive, asked, seconds=14.0, bumps=None, seed=0, weight=1.0, delay=DELAY, lag=LAG
) -> list[AxisDrive]:
    """An axis with this delay, lag and drive, asked for `asked(t)`; what is believed after each message."""
    rng, speed, beliefs = np.random.default_rng(seed), 0.0, []
    sent = [asked(CYCLE * k) for k in range(round(seconds / CYCLE))]

    def at(t: float) -> float:
        return sent[min(math.floor(t / CYCLE + 1e-9), len(sent) - 1)] if t >= 0.0 else 0.0

    def mean(start: float, end: float) -> float:
        return sum(at(start + (end - start) * (i + 0.5) / PIECES) for i in range(PIECES)) / PIECES

    piece = MESSAGE / PIECES
    decay = math.exp(-piece / lag)
    for k in range(round(seconds / MESSAGE)):
        way = 0.0
        for i in range(PIECES):
            target = drive.effective(at(k * MESSAGE + i * piece - delay))
            way += target * piece + (speed - target) * lag * (1.0 - decay)
            speed = target + (speed - target) * decay
        measured = way / MESSAGE + 0.012 * rng.normal() + (bumps(k * MESSAGE) if bumps else 0.0)
        estimator.add(k * MESSAGE, (k + 1) * MESSAGE, mean, measured, weight=weight)
        beliefs.append(estimator.drive)
    return beliefs


def is_like(drive: AxisDrive, truth: AxisDrive, gain: float = 0.05) -> bool:
    return (drive.deadband, drive.offset) == (truth.deadband, truth.offset) and abs(drive.gain - truth.gain) <= gain


def believed_times(estimator) -> tuple[float, float]:
    delay = int(np.argmin(estimator.delay_costs()))
    return estimator.delays[delay], estimator.lags[int(np.argmin(estimator.lag_costs(delay)))]


def typical() -> AxisResponseEstimator:
    return AxisResponseEstimator(AxisDrive(), 0.15, 0.2, TURNING)


@pytest.mark.parametrize("offset", [False, True], ids=["jump", "offset"])
@pytest.mark.parametrize("seed", [0, 1])
def test_a_slower_axis_with_a_deadband_is_learned_while_driving(offset: bool, seed: int) -> None:
    """Delay 0.25 s where 0.15 s is configured, lag 0.3 s (0.28 s is the nearest hypothesis) where 0.2 s is, 0.05."""
    estimator, truth = typical(), AxisDrive(1.0, 0.05, offset)
    beliefs = respond(estimator, truth, swings, seed=seed)
    assert all(is_like(drive, truth) for drive in beliefs[500:])
    assert believed_times(estimator) == pytest.approx((0.25, 0.28))


@pytest.mark.parametrize("gain", [0.5, 0.85, 1.25])
@pytest.mark.parametrize("offset", [False, True], ids=["jump", "offset"])
def test_an_axis_that_makes_less_or_more_of_a_command_is_learned(gain: float, offset: bool) -> None:
    """With a deadband of 0.03 rad/s, delay and lag that are not told; the jump shows only where it is asked for."""
    estimator = typical()
    truth = AxisDrive(gain, 0.03, offset)
    for drive in respond(estimator, truth, swings)[400:]:
        assert drive.gain == pytest.approx(gain, abs=0.12)
        for command in (-0.3, 0.1, 0.2, 0.35):
            assert drive.effective(command) == pytest.approx(truth.effective(command), abs=0.025)


def test_slow_driving_says_little_about_the_gain() -> None:
    """Castors that hold by 0.01 rad/s at 0.03 rad/s are no weak motor."""
    estimator = typical()
    beliefs = respond(estimator, AxisDrive(1.0, 0.01, True), lambda t: 0.03 * math.sin(t), seconds=6.0)
    assert all(abs(drive.gain - 1.0) < 0.15 for drive in beliefs)


def test_a_chair_that_follows_slowly_is_learned() -> None:
    """As one whose drive smooths commands by two thirds of a second, told 0.15 and 0.2 s: it swung against a wall."""
    estimator = typical()
    respond(estimator, AxisDrive(), swings, delay=0.3, lag=0.67)
    assert believed_times(estimator) == pytest.approx((0.3, 0.7))


def test_the_times_of_a_quick_axis_are_learned_within_five_seconds() -> None:
    estimator = AxisResponseEstimator(AxisDrive(), 0.3, 0.4, TURNING)
    respond(estimator, AxisDrive(), swings, seconds=5.0)
    assert believed_times(estimator) == pytest.approx((0.25, 0.28)) and is_like(estimator.drive, AxisDrive())


def test_bumps_and_castors_change_no_belief() -> None:
    """A push of 0.3 rad/s for 0.15 s every two seconds, on an axis that is as configured."""
    estimator = AxisResponseEstimator(AxisDrive(), DELAY, LAG, TURNING)
    beliefs = respond(estimator, AxisDrive(), swings, bumps=lambda t: 0.3 if t % 2.0 < 0.15 else 0.0)
    assert all(is_like(drive, AxisDrive(), 0.08) for drive in beliefs) and believed_times(estimator) == (DELAY, LAG)


def test_large_steady_commands_say_nothing_about_jumps_and_times() -> None:
    """All predict the same once the speed is reached; what is believed comes from the beginning."""
    estimator = typical()
    respond(estimator, AxisDrive(1.0, 0.05), lambda t: 0.4, seconds=3.0, weight=0.0)
    before = estimator.delay_costs()
    settled = respond(estimator, AxisDrive(1.0, 0.05), lambda t: 0.4, seconds=1.0, weight=0.0)
    assert np.array_equal(estimator.delay_costs(), before) and set(settled) == {AxisDrive()}
    steady = typical()
    for k in range(150):
        steady.add(k * MESSAGE, (k + 1) * MESSAGE, lambda start, end: 0.4, 0.4, weight=float(k >= 100))
    assert np.ptp(steady.delay_costs() - typical().delay_costs()) < 0.05 and is_like(steady.drive, AxisDrive(), 1e-3)


def test_a_gap_and_absurd_speeds_begin_anew_and_keep_what_was_learned() -> None:
    estimator, truth = typical(), AxisDrive(1.0, 0.05, True)
    respond(estimator, truth, swings)
    costs = estimator.delay_costs()
    estimator.add(20.0, 25.0, lambda start, end: 0.4, 0.0, weight=1.0)
    estimator.add(25.0, 25.02, lambda start, end: 0.4, 1e300, weight=1.0)
    assert np.array_equal(estimator.delay_costs(), costs) and is_like(estimator.drive, truth)


def test_what_says_little_counts_little() -> None:
    half, full = typical(), typical()
    for estimator, weight in ((half, 0.5), (full, 1.0)):
        respond(estimator, AxisDrive(), swings, seconds=0.9, weight=weight)
    before = typical().delay_costs()
    gained = [np.ptp(estimator.delay_costs() - before) for estimator in (half, full)]
    assert 0.0 < gained[0] < 0.7 * gained[1]


def test_what_is_expected_is_the_mean_over_the_time_between_two_measurements() -> None:
    """A step to 0.4 rad/s behind a lag of 0.2 s, over its first 0.1 s: 0.4 (1 - 2 (1 - exp(-0.5)))."""
    estimator = AxisResponseEstimator(AxisDrive(), 0.0, 0.2, TURNING)
    estimator.add(0.0, 0.1, lambda start, end: 0.4, 0.4 * (1.0 - 2.0 * (1.0 - math.exp(-0.5))), weight=1.0)
    assert estimator.difference() == pytest.approx(0.0, abs=1e-12)


def test_while_a_command_changes_an_unknown_delay_is_no_chair_that_turns_by_itself() -> None:
    """A swinging command that acts 0.1 s later than thought: the first differences may be that. A steady turn of 0.05
    rad/s more than commanded is none of it."""
    late, turning = (
        AxisResponseEstimator(AxisDrive(), 0.15, 0.2, TURNING),
        AxisResponseEstimator(AxisDrive(), 0.15, 0.2, TURNING),
    )
    differences = []
    for k in range(15):
        start, end = 0.05 * k, 0.05 * (k + 1)
        late.add(start, end, lambda a, b: 0.6 * max(0.0, a), 0.6 * max(0.0, end - 0.35 - 0.1), weight=1.0)
        turning.add(start, end, lambda a, b: 0.0, 0.05, weight=1.0)
        differences.append(late.difference())
    assert max(map(abs, differences)) < 0.01
    assert turning.difference() == pytest.approx(0.05)
