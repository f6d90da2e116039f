"""The independent chair against closed forms; every effect alone."""

import math

import numpy as np
import pytest

from seater_eval.judge.plant.built import TRACK, Built, Patch, draw_built
from seater_eval.judge.plant.castors import _TRAIL, Castors
from seater_eval.judge.plant.chair import STEP, IndependentChair
from seater_eval.judge.plant.drive import Deadband, Motors
from seater_eval.judge.plant.effects import Drive, Effects, Encoders, changed, kinematic
from seater_eval.judge.plant.encoders import WheelOdometry

PLAIN = Built(
    lag_v=0.0,
    lag_omega=0.0,
    slip=(0.0, 0.0),
    radius=(0.0, 0.0),
    track=0.0,
    strength=(1.0, 1.0),
    slope=(0.0, 0.0),
    patches=(),
    castor_side=0.0,
)


def built(**values: object) -> Built:
    return Built(**{**PLAIN.__dict__, **values})  # type: ignore[arg-type]


def chair_with(one: Built, effects: Effects | None = None) -> IndependentChair:
    return IndependentChair(effects or kinematic(), one, (0.0, 0.0, 0.0), np.random.default_rng(0))


def drive(chair: IndependentChair, v: float, omega: float, seconds: float) -> WheelOdometry:
    """And what a wheel odometry without coarse ticks makes of it."""
    odometry = WheelOdometry(Encoders(tick=1e-7), 0.0, (0.0, 0.0, 0.0), np.random.default_rng(0))
    chair.command(0.0, v, omega)
    for k in range(round(seconds / STEP) + 1):
        odometry.look(k * STEP, chair.rolled)
        if k < round(seconds / STEP):
            chair.step(k * STEP)
    return odometry


def motors(one: Built = PLAIN, **settings: object) -> Motors:
    return Motors(Drive(**{**kinematic().drive.__dict__, **settings}), one, np.random.default_rng(3))  # type: ignore[arg-type]


def speeds(of: Motors, seconds: float) -> np.ndarray:
    """At the ends of the steps, (n, 2)."""
    return np.array([of.step(k * STEP, STEP) for k in range(round(seconds / STEP))])


def test_a_command_acts_after_the_delay() -> None:
    late = motors(delay=0.25)
    late.command(0.0, 0.5, 0.2)
    found = speeds(late, 0.4)
    assert np.all(found[:50] == 0.0) and np.all(found[50:] == [0.5, 0.2])


def test_jitter_delays_further_and_keeps_the_order() -> None:
    late = motors(delay=0.1, delay_jitter=0.1)
    for k in range(40):
        late.command(0.01 * k, 0.01 * (k + 1), 0.0)
    found = speeds(late, 0.8)[:, 0]
    assert np.all(np.diff(found) >= 0.0) and found[19] == 0.0 and found[-1] == pytest.approx(0.4)
    assert np.flatnonzero(found)[0] > 20  # the first one was given more than the delay itself


def test_lag_is_of_first_order_for_each_axis() -> None:
    slow = motors(built(lag_v=0.2, lag_omega=0.3))
    slow.command(0.0, 0.5, 1.0)
    found = speeds(slow, 0.6)[-1]
    assert found == pytest.approx([0.5 * (1.0 - math.exp(-3.0)), 1.0 - math.exp(-2.0)], abs=1e-12)


def test_ramp_limits_the_change_of_the_demand() -> None:
    gentle = motors(ramp_v=0.5, ramp_omega=1.0)
    gentle.command(0.0, 0.6, -0.6)
    found = speeds(gentle, 0.4)
    assert found[-1] == pytest.approx([0.2, -0.4], abs=1e-12)
    assert speeds(gentle, 2.0)[-1] == pytest.approx([0.6, -0.6], abs=1e-12)


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ("jump", [0.0, 0.0, 0.021, 0.0, 0.0, -0.03]),
        ("offset", [0.0, 0.0, 0.001, 0.0, 0.0, -0.01]),
        ("stiction", [0.0, 0.0, 0.021, 0.015, 0.0, -0.03]),
    ],
)
def test_deadband(kind: str, expected: list[float]) -> None:
    band = Deadband(0.02, kind)
    assert [band.through(u) for u in (0.0, 0.02, 0.021, 0.015, 0.01, -0.03)] == pytest.approx(expected)


def test_castors_follow_the_tractrix_and_turn_the_chair_by_its_closed_form() -> None:
    castors, v, start = Castors(0.1, 0.02, 0.5 * math.pi), 0.2, 0.5 * math.pi
    pushes = [castors.step(v, 0.0, STEP) for _ in range(100)]  # 0.1 m
    off = 2.0 * math.atan(math.tan(0.5 * start) * math.exp(-0.1 / _TRAIL))
    assert castors.direction == pytest.approx(off, abs=1e-9)
    # Integral of A sin(e) dt with de = -sin(e) v dt / L
    assert STEP * sum(omega for _, omega in pushes) == pytest.approx(0.1 * _TRAIL / v * (start - off), rel=0.02)


def test_castors_that_point_backward_brake_and_swing_to_their_side() -> None:
    castors = Castors(0.1, 0.02, 0.1)
    v, omega = castors.step(-0.2, 0.0, STEP)
    assert v == pytest.approx(0.02, rel=0.01) and abs(omega) == pytest.approx(0.1 * math.sin(0.1), rel=1e-6)
    pushes = [abs(castors.step(-0.2, 0.0, STEP)[1]) for _ in range(600)]
    assert max(pushes) == pytest.approx(0.1, rel=0.01)
    assert pushes[-1] < 1e-3  # in line after 0.6 m: 180 degrees are an equilibrium that it leaves slowly


def test_castors_brake_either_way() -> None:
    assert Castors(0.1, 0.02, math.pi - 0.1).step(0.2, 0.0, STEP)[0] == pytest.approx(-0.02, rel=0.01)


def test_a_standing_chair_is_not_pushed() -> None:
    assert Castors(0.1, 0.02, 2.0).step(0.0, 0.0, STEP) == (0.0, 0.0)


def test_slip_shortens_the_way_and_the_encoders_do_not_see_it() -> None:
    chair = chair_with(built(slip=(0.04, 0.04)))
    odometry = drive(chair, 0.5, 0.0, 2.0)
    assert (chair.x, chair.heading) == pytest.approx((0.96, 0.0), abs=1e-9)
    assert odometry.x == pytest.approx(1.0, abs=1e-6)


def test_a_patch_under_one_wheel_turns_the_chair() -> None:
    right = Patch(0.1, -0.5 * TRACK, 0.2, 0.12)
    chair = chair_with(built(patches=(right,)))
    odometry = drive(chair, 0.2, 0.0, 0.5)
    assert chair.heading == pytest.approx(-0.2 * 0.12 / TRACK * 0.5, rel=1e-3)
    assert odometry.heading == pytest.approx(0.0, abs=1e-6)


def test_slip_follows_the_floor_within_the_relaxation_length() -> None:
    chair = chair_with(built(patches=(Patch(1.0, 0.0, 0.5, 0.1),)))
    entry = 1.0 - math.sqrt(0.25 - 0.25 * TRACK**2)
    chair.command(0.0, 0.5, 0.0)
    for k in range(500):
        chair.step(k * STEP)
        if chair.x > entry + 0.05:
            break
    assert chair.v == pytest.approx(0.5 * (1.0 - 0.1 * (1.0 - math.exp(-1.0))), rel=0.01)


def test_wheels_and_track_that_are_off_turn_the_true_chair() -> None:
    chair = chair_with(built(radius=(0.015, -0.015), track=0.01))
    drive(chair, 0.5, 0.0, 1.0)
    assert chair.heading == pytest.approx(-0.5 * 0.03 / TRACK / 1.01, rel=1e-9)


def test_the_encoders_see_a_weaker_side() -> None:
    chair = chair_with(built(strength=(0.97, 1.0)))
    odometry = drive(chair, 0.5, 0.0, 1.0)
    assert chair.heading == pytest.approx(0.5 * 0.03 / TRACK, rel=1e-9)
    assert odometry.heading == pytest.approx(chair.heading, abs=1e-5)


def test_slope_slows_uphill_turns_across_and_lets_a_standing_chair_stand() -> None:
    steep = math.sin(math.radians(2.0))
    uphill, across = chair_with(built(slope=(steep, 0.0))), chair_with(built(slope=(0.0, steep)))
    drive(uphill, 0.5, 0.0, 1.0)
    drive(across, 0.5, 0.0, 0.1)
    assert uphill.x == pytest.approx(0.5 - 0.05 * 9.81 * steep, rel=1e-6)
    assert across.heading == pytest.approx(-0.1 * 9.81 * steep * 0.05, rel=1e-2)  # uphill to the left: turns right
    backward = chair_with(built(slope=(0.0, steep)))
    drive(backward, -0.5, 0.0, 0.1)
    assert backward.heading == pytest.approx(across.heading, rel=1e-9)
    standing = chair_with(built(slope=(steep, steep)))
    drive(standing, 0.0, 0.0, 1.0)
    assert (standing.x, standing.y, standing.heading) == (0.0, 0.0, 0.0)


def test_the_true_chair_drives_arcs() -> None:
    chair = chair_with(PLAIN)
    odometry = drive(chair, 0.5, 0.5, 2.0)
    expected = (math.sin(1.0), 1.0 - math.cos(1.0), 1.0)
    assert (chair.x, chair.y, chair.heading) == pytest.approx(expected, abs=1e-6)
    assert (odometry.x, odometry.y, odometry.heading) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("rate", [5.0, 50.0, 200.0])
def test_odometry_comes_at_its_rate_with_true_stamps(rate: float) -> None:
    odometry = WheelOdometry(Encoders(rate=rate, jitter=0.03), 0.0, (0.0, 0.0, 0.0), np.random.default_rng(1))
    arrived = []
    for k in range(401):
        odometry.look(k * STEP, [0.1 * k * STEP] * 2)
        arrived += [(k * STEP, message) for message in odometry.messages(k * STEP)]
    stamps = [message.stamp for _, message in arrived]
    assert np.allclose(np.diff(stamps), 1.0 / rate) and len(stamps) >= round(2.0 * rate) - round(0.03 * rate)
    late = [at - message.stamp for at, message in arrived]
    assert min(late) >= 0.0 and 0.01 < max(late) <= 0.03 + STEP
    assert arrived[-1][1].v == pytest.approx(0.1, abs=1e-4 / min(1.0 / rate + 1e-9, 0.02))  # a tick over the window
    assert abs(arrived[-1][1].pose[0] - 0.1 * arrived[-1][1].stamp) <= 1.01e-4  # one tick


def test_messages_overtake_each_other_only_where_they_may() -> None:
    def stamps(ordered: bool) -> list[float]:
        odometry = WheelOdometry(Encoders(jitter=0.05, ordered=ordered), 0.0, (0.0, 0.0, 0.0), np.random.default_rng(1))
        arrived = []
        for k in range(401):
            odometry.look(k * STEP, [0.0, 0.0])
            arrived += [message.stamp for message in odometry.messages(k * STEP)]
        return arrived

    assert stamps(True) == sorted(stamps(True))
    assert stamps(False) != sorted(stamps(False)) and len(stamps(False)) > 90


def test_biases_and_zero_twist_of_odometry() -> None:
    def last(**settings: object) -> object:
        odometry = WheelOdometry(Encoders(**settings), 0.0, (0.0, 0.0, 0.0), np.random.default_rng(1))  # type: ignore[arg-type]
        for k in range(201):
            odometry.look(k * STEP, [0.1 * k * STEP] * 2)
        return odometry.messages(1.0)[-1]

    biased, drifting, silent = last(gyro_bias=0.03), last(gyro_bias=0.03, gyro_in_pose=True), last(zero_twist=True)
    assert biased.omega == pytest.approx(0.03) and biased.pose[2] == 0.0
    assert drifting.omega == pytest.approx(0.03) and drifting.pose[2] == pytest.approx(0.03)
    assert (silent.v, silent.omega) == (0.0, 0.0) and silent.pose[0] == pytest.approx(0.1, abs=1e-3)


def test_draws_stay_in_their_ranges_and_one_effect_does_not_change_another() -> None:
    whole = [draw_built(Effects(), np.random.default_rng(k)) for k in range(200)]
    assert all(0.15 <= one.lag_v <= 0.3 and 0.15 <= one.lag_omega <= 0.3 for one in whole)
    assert all(0.01 <= abs(radius) <= 0.015 for one in whole for radius in (*one.radius, one.track))
    assert all(0.0 <= slip <= 0.044 for one in whole for slip in one.slip) and max(o.slip[0] for o in whole) > 0.035
    assert all(min(one.strength) >= 0.97 and max(one.strength) == 1.0 for one in whole)
    assert all(0.06 <= patch.slip <= 0.12 for one in whole for patch in one.patches)
    steady = draw_built(changed(Effects(), "floor", slip=0.0, slope=0.0), np.random.default_rng(7))
    assert steady.radius == whole[7].radius and steady.strength == whole[7].strength and steady.slip == (0.0, 0.0)


def test_everything_is_off_in_a_kinematic_chair() -> None:
    assert draw_built(kinematic(), np.random.default_rng(1)) == built(
        castor_side=draw_built(kinematic(), np.random.default_rng(1)).castor_side
    )


def test_a_wrong_kind_of_deadband_is_refused() -> None:
    with pytest.raises(ValueError, match="deadband_kind: is 'soft', must be one of jump"):
        Drive(deadband_kind="soft")
