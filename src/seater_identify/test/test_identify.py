"""Estimates against the truth of a chair written apart (chair_by_hand), and what is refused."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from chair_by_hand import Truth, drive

from seater_identify.record.recording import Recording, RecordingError
from seater_identify.result.identify import Identification, identify
from seater_identify.result.values import Quality

TRUTH = Truth()


@functools.cache
def recording() -> Recording:
    return drive(TRUTH)


@functools.cache
def result() -> Identification:
    return identify(recording())


# name, truth, largest error: the bars of issue 11, for odometry half of what the observer assumes of a chair.
@pytest.mark.parametrize(
    ("name", "truth", "bar"),
    [
        ("delay", TRUTH.delay, 0.015),
        ("lag_v", TRUTH.lag[0], 0.030),
        ("lag_omega", TRUTH.lag[1], 0.030),
        ("gain_v", TRUTH.gain[0], 0.02),
        ("gain_omega", TRUTH.gain[1], 0.02),
        ("deadband_v", TRUTH.deadband[0], 0.2 * TRUTH.deadband[0]),
        ("deadband_omega", TRUTH.deadband[1], 0.2 * TRUTH.deadband[1]),
        ("odometry_scale", TRUTH.errors[0], 0.005),
        ("odometry_heading_scale", TRUTH.errors[1], 0.005),
        ("odometry_heading_drift", TRUTH.errors[2], 0.003),
    ],
)
def test_truth_is_found_and_lies_in_the_interval(name: str, truth: float, bar: float) -> None:
    estimate = result()[name]
    low, high = estimate.interval()
    assert estimate.usable, estimate.text
    assert abs(estimate.value - truth) <= bar
    assert low <= truth <= high


def test_a_ramp_slower_than_the_commands_is_found_and_a_faster_one_is_a_bound() -> None:
    slow = identify(drive(Truth(ramp=(0.3, 4.0))))["ramp_v"]
    assert slow.usable and slow.value == pytest.approx(0.3, rel=0.15)
    fast = result()["ramp_v"]
    assert fast.quality is Quality.BOUND and fast.value == pytest.approx(0.5, rel=0.1)


@pytest.mark.extensive  # those that matter are found always
def test_deadbands_that_hardly_matter_are_found() -> None:
    found = identify(drive(Truth(deadband=(0.0038, 0.006), tick=1e-4)))
    assert found["deadband_v"].value == pytest.approx(0.0038, abs=0.001)
    assert found["deadband_omega"].value == pytest.approx(0.006, abs=0.001)


def test_without_the_dock_odometry_is_refused_and_gains_are_less_certain() -> None:
    blind = identify(drive(TRUTH, dock=False))
    for name in ("odometry_scale", "odometry_heading_scale", "odometry_heading_drift"):
        assert blind[name].quality is Quality.REFUSED and "dock" in blind[name].text
    assert blind["gain_v"].sd > 1.5 * result()["gain_v"].sd


def test_a_chair_that_never_turned_says_nothing_about_turning() -> None:
    whole = recording()
    straight = Recording(whole.commands * [1.0, 1.0, 0.0], whole.odometry * [1.0, 1.0, 0.0, 0.0])
    found = identify(straight)
    for name in ("lag_omega", "gain_omega", "deadband_omega", "ramp_omega"):
        assert found[name].quality is Quality.REFUSED and "not turn" in found[name].text


def test_a_drive_without_slow_commands_says_nothing_about_deadbands() -> None:
    whole = recording()
    slow = (np.abs(whole.commands[:, 1]) < 0.15) & (np.abs(whole.commands[:, 1]) > 0.0)
    commands = whole.commands.copy()
    commands[slow, 1] = 0.0
    found = identify(Recording(commands, whole.odometry))["deadband_v"]
    assert found.quality is Quality.REFUSED and "grow slowly from zero" in found.text


def test_order_of_arrival_does_not_matter() -> None:
    whole, rng = recording(), np.random.default_rng(3)
    mixed = Recording(rng.permutation(whole.commands), rng.permutation(np.vstack([whole.odometry, whole.odometry[:9]])))
    assert np.array_equal(mixed.commands, whole.commands)
    assert np.array_equal(mixed.odometry, whole.odometry)


def test_too_little_is_said_in_words() -> None:
    with pytest.raises(RecordingError, match="odometry: 0 usable"):
        Recording(recording().commands, np.zeros((0, 4)))
    with pytest.raises(RecordingError, match="do not overlap"):
        Recording(recording().commands + [1e4, 0.0, 0.0], recording().odometry)
