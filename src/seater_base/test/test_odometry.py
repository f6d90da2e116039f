"""Counts to poses: closed forms, wraps, restarts, leaps."""

import math
from dataclasses import replace

import numpy as np
import pytest

from seater_base.odometry import Driven, WheelOdometry
from seater_base.protocol import Flags, Reading
from seater_base.settings import BaseSettings

SETTINGS = BaseSettings()
WORD = 2**32


def drive(
    odometry: WheelOdometry, v: float, omega: float, seconds: float, *, start: float = 0.0, counts=(0, 0), clock=0
) -> list[Driven]:
    """A constant motion; `counts` and `clock` [ms] of the base at its beginning."""
    wheels, found = SETTINGS.wheels, []
    for k in range(round(seconds / 0.02) + 1):
        t = 0.02 * k
        left = round((v - 0.5 * wheels.separation * omega) * t * wheels.left_counts) + counts[0]
        right = round((v + 0.5 * wheels.separation * omega) * t * wheels.right_counts) + counts[1]
        words = [(c + WORD // 2) % WORD - WORD // 2 for c in (left, right)]
        reading = Reading((clock + round(1e3 * t)) % WORD, words[0], words[1], Flags.POWER)
        driven = odometry.add(reading, start + t + 0.004)
        if driven is not None:
            found.append(driven)
    return found


def test_straight_and_speed() -> None:
    found = drive(WheelOdometry(SETTINGS), 0.3, 0.0, 2.0)
    assert found[-1].pose == pytest.approx([0.6, 0.0, 0.0], abs=1e-4)
    assert found[-1].v == pytest.approx(0.3, abs=1e-3) and found[-1].omega == pytest.approx(0.0, abs=2e-3)


def test_a_circle_closes() -> None:
    found = drive(WheelOdometry(SETTINGS), 0.4, 0.5, 2.0 * math.pi / 0.5)
    assert found[-1].pose[:2] == pytest.approx([0.0, 0.0], abs=6e-3)  # the last 20 ms are missing or too much
    quarter = next(d for d in found if d.pose[2] >= 0.5 * math.pi)
    assert quarter.pose[:2] == pytest.approx([0.8, 0.8], abs=9e-3)  # 8 mm a step
    assert found[50].omega == pytest.approx(0.5, abs=5e-3)


def test_counters_and_clock_that_wrap() -> None:
    odometry = WheelOdometry(SETTINGS)
    found = drive(odometry, 0.5, 0.0, 4.0, counts=(WORD // 2 - 10000, -WORD // 2 + 100), clock=WORD - 1500)
    assert found[-1].pose == pytest.approx([2.0, 0.0, 0.0], abs=1e-3)
    assert odometry.leaps == 0 and len(found) == 200


def test_times_are_those_of_the_base_and_rise() -> None:
    found = drive(WheelOdometry(SETTINGS), 0.1, 0.0, 20.0, start=100.0)
    times = np.array([d.time for d in found])
    assert np.all(np.diff(times) > 0.0)
    assert times[100:] == pytest.approx(100.004 + 0.02 * np.arange(101, 1001), abs=2e-3)


def test_a_base_that_starts_anew_moves_nothing() -> None:
    odometry = WheelOdometry(SETTINGS)
    drive(odometry, 0.5, 0.0, 2.0, counts=(123456, 987654), clock=500000)
    before = odometry.pose.copy()
    found = drive(odometry, 0.0, 0.0, 0.2, start=3.0)
    assert odometry.leaps == 1
    assert found[-1].pose == pytest.approx(before)
    assert all(abs(d.v) < 1e-9 for d in found)


def test_a_leap_of_the_counts_moves_nothing_and_is_counted() -> None:
    odometry = WheelOdometry(SETTINGS)
    drive(odometry, 0.0, 0.0, 1.0)
    assert odometry.add(Reading(1020, 20000, 0, Flags.POWER), 1.024) is None
    driven = odometry.add(Reading(1040, 20000, 0, Flags.POWER), 1.044)
    assert driven is not None and driven.pose == pytest.approx([0.0, 0.0, 0.0])
    assert odometry.leaps == 1


def test_readings_left_out_lose_no_way() -> None:
    odometry = WheelOdometry(SETTINGS)
    odometry.add(Reading(0, 0, 0, Flags.POWER), 0.004)
    driven = odometry.add(Reading(1000, 10000, 10000, Flags.POWER), 1.004)
    assert driven is not None and driven.pose == pytest.approx([0.5, 0.0, 0.0])
    assert odometry.add(Reading(1000, 10000, 10000, Flags.POWER), 1.005) is None, "the same one again"


def test_the_covariance_is_that_of_many_drives() -> None:
    """Of wheels with random errors per step, as `noise` says."""
    noise, random = SETTINGS.noise, np.random.default_rng(2)
    v, omega, steps, runs = 0.4, 0.3, 250, 400
    ends = []
    for _ in range(runs):
        pose = np.zeros(3)
        way = v * 0.02 + noise.distance * math.sqrt(v * 0.02) * random.normal(size=steps)
        sd = math.hypot(noise.heading * math.sqrt(v * 0.02), noise.turn * math.sqrt(omega * 0.02))
        turn = omega * 0.02 + sd * random.normal(size=steps)
        for d, t in zip(way, turn, strict=True):
            pose = pose + [d * math.cos(pose[2] + 0.5 * t), d * math.sin(pose[2] + 0.5 * t), t]
        ends.append(pose)
    found = drive(WheelOdometry(SETTINGS), v, omega, 5.0)[-1]
    assert np.sqrt(np.diag(found.pose_covariance)) == pytest.approx(np.std(ends, axis=0), rel=0.15)


def test_counts_that_fall_forward() -> None:
    wheels = replace(SETTINGS.wheels, left_counts=-20000.0)
    odometry = WheelOdometry(replace(SETTINGS, wheels=wheels))
    odometry.add(Reading(0, 0, 0, Flags.POWER), 0.0)
    driven = odometry.add(Reading(20, -100, 100, Flags.POWER), 0.02)
    assert driven is not None and driven.pose == pytest.approx([0.005, 0.0, 0.0])
    with pytest.raises(ValueError, match="left_counts"):
        replace(wheels, left_counts=0.0)
