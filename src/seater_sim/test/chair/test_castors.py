"""Castors swing round as their equation says, and push while they do."""

import math

import pytest
from wheelchairs import LIMITS, STEP, drive, make, only

from seater_sim.chair.castors import BREAKAWAY, Castors
from seater_sim.settings import CastorSettings

TRAIL = 0.05
SETTINGS = CastorSettings(trail=TRAIL, ahead=0.4, spread=0.5, push_v=0.02, push_omega=0.1, start_angle=0.0)


def castors(angle: float) -> Castors:
    made = Castors(SETTINGS, 1)
    made.angles = [angle, angle]
    return made


def test_swing_straight_ahead_is_the_closed_form() -> None:
    made = castors(2.5)
    for _ in range(30):
        made.swing(0.003, 0.0)
    expected = 2.0 * math.atan(math.tan(1.25) * math.exp(-0.09 / TRAIL))
    assert made.angles == pytest.approx([expected, expected], abs=1e-12)


def test_the_size_of_the_step_does_not_matter() -> None:
    coarse, fine = castors(1.0), castors(1.0)
    for _ in range(50):
        coarse.swing(0.004, 0.003)
    for _ in range(500):
        fine.swing(0.0004, 0.0003)
    assert coarse.angles == pytest.approx(fine.angles, abs=0.004)  # first order in the turn of a step


def test_backwards_they_turn_round() -> None:
    made = castors(0.05)
    for _ in range(200):
        made.swing(-0.003, 0.0)
    assert [abs(angle) for angle in made.angles] == pytest.approx([math.pi, math.pi], abs=0.01)


def test_turning_on_the_spot_lays_them_on_the_circle() -> None:
    made = castors(0.0)
    for _ in range(2000):
        made.swing(0.0, 0.003)
    for angle, y in zip(made.angles, (0.25, -0.25), strict=True):
        # In the chair's frame the steady angle lags behind the pivot's motion: sin(psi - angle) = trail / radius.
        lag = math.asin(TRAIL / math.hypot(0.4, y))
        assert math.remainder(angle - (math.atan2(0.4, -y) - lag), 2.0 * math.pi) == pytest.approx(0.0, abs=0.005)


def test_push_of_castors_that_lie_across_costs_speed_only() -> None:
    v, omega = castors(0.5 * math.pi).push(0.3, 0.0)
    assert v == pytest.approx(-0.02 * 0.3 / (0.3 + BREAKAWAY)) and omega == pytest.approx(0.0, abs=1e-12)


def test_push_of_castors_at_45_degrees_turns_the_chair_to_their_side() -> None:
    v, omega = castors(0.25 * math.pi).push(0.3, 0.0)
    share = 0.3 / (0.3 + BREAKAWAY)
    assert (v, omega) == pytest.approx((-0.5 * 0.02 * share, 0.1 * share))
    assert castors(-0.25 * math.pi).push(0.3, 0.0) == pytest.approx((v, -omega))


def test_one_castor_alone_turns_by_its_drag_too() -> None:
    made = castors(0.0)
    made.angles[0] = 0.5 * math.pi  # the left one lies across: the chair is held back on the left
    v, omega = made.push(0.3, 0.0)
    share = 0.3 / (0.3 + BREAKAWAY)
    assert (v, omega) == pytest.approx((-0.5 * 0.02 * share, 0.1 * share * 0.25 / 0.4))


def test_trailing_castors_do_not_push_and_dry_friction_moves_nothing() -> None:
    assert castors(0.0).push(0.3, 0.0) == (0.0, 0.0)
    assert castors(1.0).push(0.0, 0.0) == (0.0, 0.0)
    for speed in (0.001, 0.01, 0.1):
        assert speed + castors(0.5 * math.pi).push(speed, 0.0)[0] > 0.0


def test_start_angles_are_drawn_by_the_seed() -> None:
    angles = [a for seed in range(200) for a in Castors(CastorSettings(start_angle=1.0), seed).angles]
    assert -1.0 <= min(angles) < -0.95 and 0.95 < max(angles) <= 1.0
    assert Castors(CastorSettings(), 3).angles == Castors(CastorSettings(), 3).angles


def test_they_push_the_chair_until_they_trail() -> None:
    keys = {"trail": TRAIL, "ahead": 0.4, "push_v": 0.02, "push_omega": 0.1}
    plant = make(only(castors=keys), limits=LIMITS)
    plant.castors.angles = [0.9, 0.9]
    speeds = drive(plant, 300, 0.2)
    assert speeds[0] == pytest.approx((0.2, 0.0))  # the push follows the motion by a step
    assert speeds[1][0] < 0.19 and speeds[1][1] > 0.08
    assert speeds[-1] == pytest.approx((0.2, 0.0), abs=2e-4)
    assert plant.pose[2] > 0.02 and plant.time_ns == 300 * STEP
    off = make(only(castors=keys | {"trail": 0.0}))
    assert set(drive(off, 50, 0.2)) == {(0.2, 0.0)}
