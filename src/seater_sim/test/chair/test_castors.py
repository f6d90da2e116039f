"""Castors swing round as their equation says, and push while they do."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from wheelchairs import LIMITS, STEP, drive, make, only

from seater_sim.chair.castors import BREAKAWAY, Castors
from seater_sim.settings import CastorSettings

Array = NDArray[np.float64]

TRAIL = 0.05
STIFF = {"trail": TRAIL, "ahead": 0.45, "spread": 0.5, "push_v": 0.025, "push_omega": 0.15}  # the worn chair's most
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


def law(settings: CastorSettings, angles: list[float], v: float, omega: float) -> Array:
    """The push on a chair that moves with v and omega, as docs/explanation/simulator.md gives it."""
    push = np.zeros(2)
    for angle, y in zip(angles, (0.5 * settings.spread, -0.5 * settings.spread), strict=True):
        vx, vy = v - omega * y, omega * settings.ahead
        u = math.hypot(vx, vy)
        force = math.sin(angle - math.atan2(vy, vx)) * u / (u + BREAKAWAY)
        lever = math.cos(angle) + y / settings.ahead * math.sin(angle)
        push += 0.5 * force * np.array([-settings.push_v * math.sin(angle), 2.0 * settings.push_omega * lever])
    return push


def check_push(made: Castors, v: float, push: tuple[float, float]) -> None:
    """They push a chair by this that then moves straight ahead with v."""
    assert made.push(v - push[0], -push[1]) == pytest.approx(push, abs=1e-8)


def test_push_of_castors_that_lie_across_costs_speed_only() -> None:
    check_push(castors(0.5 * math.pi), 0.3, (-0.02 * 0.3 / (0.3 + BREAKAWAY), 0.0))


def test_push_of_castors_at_45_degrees_turns_the_chair_to_their_side() -> None:
    share = 0.3 / (0.3 + BREAKAWAY)
    check_push(castors(0.25 * math.pi), 0.3, (-0.5 * 0.02 * share, 0.1 * share))
    check_push(castors(-0.25 * math.pi), 0.3, (-0.5 * 0.02 * share, -0.1 * share))


def test_one_castor_alone_turns_by_its_drag_too() -> None:
    made = castors(0.0)
    made.angles[0] = 0.5 * math.pi  # the left one lies across: the chair is held back on the left
    share = 0.3 / (0.3 + BREAKAWAY)
    check_push(made, 0.3, (-0.5 * 0.02 * share, 0.1 * share * 0.25 / 0.4))


def test_trailing_castors_hold_back_a_turn_on_the_spot() -> None:
    pivot = math.hypot(0.4, 0.25)
    for left in (0.001, 0.03, 0.5):
        held = 2.0 * 0.1 * 0.4 * left / (pivot * left + BREAKAWAY)
        assert castors(0.0).push(0.0, left + held) == pytest.approx((0.0, -held), abs=1e-7)


def test_trailing_castors_do_not_push_and_dry_friction_moves_nothing() -> None:
    assert castors(0.0).push(0.3, 0.0) == (0.0, 0.0)
    assert castors(1.0).push(0.0, 0.0) == (0.0, 0.0)
    for speed in (0.001, 0.01, 0.1):
        assert speed + castors(0.5 * math.pi).push(speed, 0.0)[0] > 0.0


def test_whatever_the_castors_they_only_take_energy() -> None:
    rng = np.random.default_rng(3)
    for _ in range(300):
        push_v, push_omega = rng.uniform(0.001, 0.2), rng.uniform(0.001, 1.0)
        settings = CastorSettings(push_v=push_v, push_omega=push_omega, start_angle=math.pi)
        made = Castors(settings, int(rng.integers(1000)))
        free = rng.uniform(-0.3, 0.3, 2)
        left = free + made.push(*free)
        np.testing.assert_allclose(left - free, law(settings, made.angles, *left), atol=1e-6)
        stiffness = np.array([2.0 / push_v, settings.ahead / push_omega])
        assert 0.0 < np.sum(stiffness * left**2) <= np.sum(stiffness * left * free) <= np.sum(stiffness * free**2)


def test_start_angles_are_drawn_by_the_seed() -> None:
    angles = [a for seed in range(200) for a in Castors(CastorSettings(start_angle=1.0), seed).angles]
    assert -1.0 <= min(angles) < -0.95 and 0.95 < max(angles) <= 1.0
    assert Castors(CastorSettings(), 3).angles == Castors(CastorSettings(), 3).angles


def turning(angle: float, omega: float, v: float = 0.0, step: int = STEP, seconds: float = 2.0) -> tuple[Array, Array]:
    """Turning rates (n,) and last pose of a chair with stiff castors that is told to move slowly."""
    plant = make(only(castors=STIFF, motor={"lag_omega": 0.2, "lag_v": 0.2}), limits=LIMITS)
    plant.castors.angles = [angle, angle]
    rates = []
    for _ in range(round(seconds * 1e9) // step):
        plant.command(v, omega)
        plant.step(step)
        rates.append(plant.omega)
    return np.array(rates), plant.pose


@pytest.mark.parametrize("angle", [0.0, 0.25 * math.pi, 0.5 * math.pi, math.pi])
@pytest.mark.parametrize(("v", "omega"), [(0.0, 0.1), (0.0, -0.02), (0.03, 0.1), (-0.02, 0.05)])
def test_a_slow_chair_turns_smoothly_at_any_step(angle: float, v: float, omega: float) -> None:
    rates, pose = turning(angle, omega, v)
    assert np.max(np.abs(np.diff(rates))) < 0.012  # the motors alone: 0.005 per step
    halved, quartered = (turning(angle, omega, v, STEP // n)[1] for n in (2, 4))
    assert np.abs(halved - pose).max() < 2e-3
    assert np.abs(quartered - halved).max() < 0.6 * np.abs(halved - pose).max() + 1e-6  # first order: half as much


@pytest.mark.parametrize("angle", [0.0, 0.5 * math.pi, math.pi])
def test_turning_on_the_spot_is_held_back_and_never_reversed(angle: float) -> None:
    rates, _ = turning(angle, 0.1)
    assert np.all(rates > 0.0) and np.all(rates <= 0.1)


def test_a_chair_that_is_asked_to_stand_stands() -> None:
    plant = make(only(castors=STIFF))
    plant.castors.angles = [0.8, -1.2]
    drive(plant, 50, 0.1, 0.2)
    assert set(drive(plant, 50)) == {(0.0, 0.0)}


def test_they_push_the_chair_until_they_trail() -> None:
    keys = {"trail": TRAIL, "ahead": 0.4, "push_v": 0.02, "push_omega": 0.1}
    plant = make(only(castors=keys), limits=LIMITS)
    plant.castors.angles = [0.9, 0.9]
    speeds = drive(plant, 300, 0.2)
    push = [speeds[0][0] - 0.2, speeds[0][1]]  # from the first step on
    np.testing.assert_allclose(push, law(CastorSettings(**keys), [0.9, 0.9], *speeds[0]), atol=1e-7)
    assert push[0] < -0.009 and push[1] > 0.07
    assert speeds[-1] == pytest.approx((0.2, 0.0), abs=2e-4)
    assert plant.pose[2] > 0.02 and plant.time_ns == 300 * STEP
    off = make(only(castors=keys | {"trail": 0.0}))
    assert set(drive(off, 50, 0.2)) == {(0.2, 0.0)}
