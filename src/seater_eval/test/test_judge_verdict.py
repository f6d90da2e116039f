"""The judge: what counts as docked, touched, a reversal; acceleration and jerk of known motions."""

import math

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock
from seater_eval.judge.verdict import Motion, judge, sign_changes, smallest_gap

STEP = 0.005


def ending_at(x: float, y: float = 0.0, heading: float = 0.0, still: float = 1.0) -> Motion:
    """Drives straight to there and then stands for `still` seconds."""
    steps, rest = 400, round(still / STEP)
    way = np.concatenate([np.linspace(-1.0, 0.0, steps), np.zeros(rest)])
    poses = np.column_stack([way + x, np.full(len(way), y), np.full(len(way), heading)])
    v = np.concatenate([np.full(steps, 1.0 / (steps * STEP)), np.zeros(rest)])
    return Motion(STEP * np.arange(len(way)), poses, np.column_stack([v, np.zeros(len(v))]))


def verdict(motion: Motion, succeeded: bool | None = True) -> dict:
    return judge(motion, Chair(), Dock(), succeeded)


@pytest.mark.parametrize(
    ("x", "y", "degrees", "docked"),
    [
        (0.0, 0.0, 0.0, True),
        (0.0099, 0.0, 0.99, True),
        (0.011, 0.0, 0.0, False),
        (0.0, -0.011, 0.0, False),
        (0.008, 0.008, 0.0, False),
        (0.0, 0.0, 1.01, False),
        (0.0, 0.0, -1.01, False),
        (0.0, 0.0, 359.5, True),
    ],
)
def test_docked_is_within_ten_millimetres_and_one_degree(x: float, y: float, degrees: float, docked: bool) -> None:
    assert verdict(ending_at(x, y, math.radians(degrees)))["docked"] is docked


def test_docked_is_standing_for_half_a_second() -> None:
    assert verdict(ending_at(0.0, still=0.51))["docked"]
    moving = verdict(ending_at(0.0, still=0.4))
    assert not moving["docked"] and not moving["stands"] and moving["within"]


def test_docked_is_what_the_sequence_says_of_itself_too() -> None:
    assert not verdict(ending_at(0.0), False)["docked"]
    assert verdict(ending_at(0.0), None)["docked"]  # the class does not say


@pytest.mark.parametrize(
    ("pose", "gap"),
    [
        ((0.0, 0.0, 0.0), 0.15),  # docked: 0.15 m to the back wall, 0.175 m to the sides
        ((0.0, 0.174, 0.0), 0.001),
        ((0.0, 0.176, 0.0), -0.001),
        ((0.151, 0.0, 0.0), -0.001),
        ((-2.0, 0.0, 0.0), 2.0 - 0.75),  # to the ends of the side walls
        # Front left corner at y = 0.75 sin(h) + 0.325 cos(h)
        ((-0.3, 0.0, 0.2), 0.5 - (0.75 * math.sin(0.2) + 0.325 * math.cos(0.2))),
    ],
)
def test_gap_to_the_walls(pose: tuple[float, float, float], gap: float) -> None:
    assert smallest_gap(np.array([pose]), Chair(), Dock()) == pytest.approx(gap, abs=1e-12)


def test_a_touch_anywhere_on_the_way_counts() -> None:
    motion = ending_at(0.0)
    poses = motion.poses.copy()
    poses[200, 1] = 0.3  # its front is in the bay there
    assert not verdict(motion)["touched"]
    assert verdict(Motion(motion.times, poses, motion.speeds))["touched"]


def test_sign_changes() -> None:
    assert sign_changes(np.array([0.1, 0.1, -0.1, -0.1, 0.1]), 0.005) == 2
    assert sign_changes(np.array([0.1, 0.004, -0.004, 0.1]), 0.005) == 0  # within the dead zone
    assert sign_changes(np.array([0.1, 0.0, -0.1]), 0.005) == 1
    assert sign_changes(np.array([0.1] * 5 + [-0.1] * 2 + [0.1] * 5), 0.02, 3) == 0  # does not last
    assert sign_changes(np.array([0.1] * 5 + [-0.1] * 3 + [0.1] * 5), 0.02, 3) == 2
    assert sign_changes(np.zeros(5), 0.02) == 0


def test_peaks_of_a_smooth_motion() -> None:
    """v = V (1 - cos(w t)) / 2: acceleration V w / 2 at most, jerk V w^2 / 2; 5 Hz let 0.25 Hz through."""
    times, V, w = STEP * np.arange(1601), 0.4, 2.0 * math.pi * 0.25
    v = 0.5 * V * (1.0 - np.cos(w * times))
    poses = np.column_stack([np.cumsum(v) * STEP - 3.0, np.zeros_like(v), np.zeros_like(v)])
    found = verdict(Motion(times, poses, np.column_stack([v, 2.0 * v])))
    assert found["peak_acceleration_m_s2"] == pytest.approx(0.5 * V * w, rel=0.01)
    assert found["rms_acceleration_m_s2"] == pytest.approx(0.5 * V * w / math.sqrt(2.0), rel=0.01)
    assert found["peak_turning_acceleration_rad_s2"] == pytest.approx(V * w, rel=0.01)
    assert found["peak_jerk_m_s3"] == pytest.approx(0.5 * V * w * w, rel=0.03)  # more at the ends of the record
    assert found["time_s"] == pytest.approx(8.0, abs=0.1)


def test_time_ends_with_the_last_motion() -> None:
    assert verdict(ending_at(0.0, still=3.0))["time_s"] == pytest.approx(2.0, abs=2 * STEP)
