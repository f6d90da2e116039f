"""The plant `wheelchair`, one effect at a time, against closed forms."""

import math

import numpy as np
import pytest
from wheelchairs import LIMITS, SECONDS, START, STEP, TRACK, drive, make, only

from seater_common.geometry import Limits
from seater_common.se2 import arc_step
from seater_sim.settings import WheelchairSettings

RADIAN = math.pi / 180.0


def test_without_effects_it_drives_what_it_is_told() -> None:
    plant = make(only())
    assert drive(plant, 100, 0.4, 0.3)[0] == pytest.approx((0.4, 0.3))
    np.testing.assert_allclose(plant.pose, arc_step(START, 0.4, 0.3, 1.0), atol=1e-12)
    assert drive(plant, 1)[0] == (0.0, 0.0)


def test_delay() -> None:
    speeds = drive(make(only(command={"delay": 0.04})), 8, 0.3)
    assert [v for v, _ in speeds] == pytest.approx([0.0] * 4 + [0.3] * 4)


def test_jitter_delays_within_its_bounds_and_never_reorders() -> None:
    plant = make(only(command={"delay": 0.02, "delay_jitter": 0.10, "timeout": 1000.0}))
    seen = []
    for k in range(1, 400):
        plant.command(0.001 * k, 0.0)
        plant.step(STEP)
        seen.append(round(plant.v / 0.001))
    late = [k - number for k, number in enumerate(seen, start=1) if number]
    assert seen == sorted(seen)
    assert min(late) >= 2 and max(late) <= 13  # 0.12 s, rounded up to a step
    assert max(late) - min(late) >= 4


def test_jitter_does_not_depend_on_how_many_commands_came_before() -> None:
    """How long a gate publishes zeros before a goal begins depends on the machine."""

    def speeds(zeros: int) -> list[float]:
        plant = make(only(command={"delay": 0.02, "delay_jitter": 0.10, "timeout": 1000.0}))
        seen = []
        for k in range(1, 60):
            for _ in range(zeros if k < 10 else 1):
                plant.command(0.0 if k < 10 else 0.01 * k, 0.0)
            plant.step(STEP)
            seen.append(plant.v)
        return seen

    assert speeds(1) == speeds(3)


def test_timeout() -> None:
    plant = make(only(command={"timeout": 0.25}))
    plant.command(0.3, 0.0)
    speeds = []
    for _ in range(30):
        plant.step(STEP)
        speeds.append(plant.v)
    assert speeds == pytest.approx([0.3] * 25 + [0.0] * 5)


@pytest.mark.parametrize(
    ("kind", "asked", "given"),
    [
        ("jump", (0.02, 0.05), (0.0, 0.0)),
        ("jump", (0.021, -0.051), (0.021, -0.051)),
        ("offset", (-0.02, 0.05), (0.0, 0.0)),
        ("offset", (-0.05, 0.15), (-0.03, 0.10)),
    ],
)
def test_deadband(kind: str, asked: tuple[float, float], given: tuple[float, float]) -> None:
    command = {"deadband_kind": kind, "deadband_v": 0.02, "deadband_omega": 0.05}
    assert drive(make(only(command=command)), 1, *asked)[0] == pytest.approx(given, abs=1e-12)


def test_gain_of_each_axis() -> None:
    assert drive(make(only(command={"gain_v": 0.9, "gain_omega": 1.2})), 1, 0.5, 0.5)[0] == pytest.approx((0.45, 0.6))


def test_commands_are_cut_to_the_chairs_limits() -> None:
    plant = make(only(), limits=Limits())
    assert drive(plant, 1, 9.0, -9.0)[0] == pytest.approx((0.6, -0.8))
    assert drive(plant, 1, -9.0, 9.0)[0] == pytest.approx((-0.3, 0.8))


def test_motor_controller_ramps_up_and_down_differently() -> None:
    plant = make(only(motor={"acceleration": 0.5, "deceleration": 1.0, "turn_acceleration": 2.0}))
    rows = np.array(drive(plant, 50, 0.2, 0.4))
    # Means of the steps: half a step behind the ramp's ends.
    np.testing.assert_allclose(rows[:40, 0], 0.5 * SECONDS * (np.arange(40) + 0.5), atol=1e-12)
    np.testing.assert_allclose(rows[:20, 1], 2.0 * SECONDS * (np.arange(20) + 0.5), atol=1e-12)
    rows = np.array(drive(plant, 30))
    np.testing.assert_allclose(rows[:20, 0], 0.2 - 1.0 * SECONDS * (np.arange(20) + 0.5), atol=1e-12)
    assert rows[0, 1] == 0.0  # this axis has no ramp when turning less


@pytest.mark.parametrize("axis", [0, 1])
def test_lag_of_each_axis_is_first_order(axis: int) -> None:
    plant = make(only(motor={"lag_v": 0.2, "lag_omega": 0.3}))
    lag = (0.2, 0.3)[axis]
    rows = np.array(drive(plant, 60, 0.4, 0.5))[:, axis]
    # The mean of (1 - exp(-t / lag)) over each step.
    t = SECONDS * np.arange(61)
    mean = 1.0 + lag * np.diff(np.exp(-t / lag)) / SECONDS
    np.testing.assert_allclose(rows, (0.4, 0.5)[axis] * mean, atol=1e-12)


def test_a_weak_side_turns_the_chair() -> None:
    v, omega = drive(make(only(motor={"weak_left": 0.03})), 1, 0.4)[0]
    assert (v, omega) == pytest.approx((0.4 * (1.0 - 0.015), 0.4 * 0.03 / TRACK))


def test_battery_droops_over_time_and_under_load() -> None:
    plant = make(only(motor={"droop_time": 0.001}))
    assert drive(plant, 1001, 0.4)[-1][0] == pytest.approx(0.4 * 0.99)
    plant = make(only(motor={"droop_load": 0.02, "acceleration": 0.5}))
    speeds = [v for v, _ in drive(plant, 60, 0.2)]
    assert speeds[9] == pytest.approx(0.5 * 0.095 * (1.0 - 0.02 * 0.5))
    assert speeds[-1] == pytest.approx(0.2)


def test_constant_slip_of_each_wheel() -> None:
    plant = make(only(floor={"slip_left": 0.04, "slip_right": 0.02}))
    assert drive(plant, 1, 0.5)[0] == pytest.approx((0.5 * 0.97, 0.5 * 0.02 / TRACK))
    assert (plant.encoders.left, plant.encoders.right) == pytest.approx((0.005, 0.005))  # the wheels have turned


def test_slip_grows_with_acceleration_and_a_braking_wheel_gains_way() -> None:
    plant = make(only(floor={"slip_load": 0.05}, motor={"acceleration": 0.5, "deceleration": 1.0}))
    assert drive(plant, 10, 0.2)[-1][0] == pytest.approx(0.5 * 0.095 * (1.0 - 0.05 * 0.5))
    assert drive(plant, 60, 0.2)[-1][0] == pytest.approx(0.2)
    assert drive(plant, 1)[-1][0] == pytest.approx(0.195 * (1.0 + 0.05 * 1.0))


@pytest.mark.parametrize("one_sided", [0.0, 1.0])
def test_patches_have_their_mean_length_gap_and_slip(one_sided: float) -> None:
    floor = {"patch_slip": 0.12, "patch_length": 0.3, "patch_gap": 0.7, "patch_one_sided": one_sided}
    plant = make(only(floor=floor))
    slips = np.array([(2.0 * 1.0 - 2.0 * v, omega * TRACK) for v, omega in drive(plant, 40000, 1.0)])
    on_patch = slips[:, 0] > 1e-9
    # 400 m: some 400 patches; the share of way on them is 0.3 / (0.7 + 0.3), its standard deviation below 0.012.
    assert np.mean(on_patch) == pytest.approx(0.3, abs=0.045)
    slip = slips[on_patch, 0] / (2.0 - one_sided)
    assert 0.06 - 1e-9 <= slip.min() < 0.065 and 0.115 < slip.max() <= 0.12 + 1e-9
    if one_sided:
        np.testing.assert_allclose(abs(slips[on_patch, 1]), slips[on_patch, 0], atol=1e-9)
        assert 0.4 < np.mean(slips[on_patch, 1] > 0.0) < 0.6
    else:
        np.testing.assert_allclose(slips[:, 1], 0.0, atol=1e-9)


def test_patches_are_placed_by_the_seed() -> None:
    def way(seed: int) -> float:
        plant = make(only(floor={"patch_slip": 0.12}), seed=seed)
        drive(plant, 500, 0.5)
        return float(plant.pose[0])

    assert way(1) == way(1) and way(1) != way(2)


def test_a_chair_that_turns_on_the_spot_rolls_off_its_patch() -> None:
    """Wheels roll while the middle of the axle rests: 10 m in a minute at 0.6 rad/s, some patches."""
    plant = make(only(floor={"patch_slip": 0.12, "patch_one_sided": 0.0}))
    slippery = [rate < 0.59 for _, rate in drive(plant, round(60.0 / SECONDS), 0.0, 0.6)]
    assert 6 <= np.count_nonzero(np.diff(slippery)) <= 40


def test_slope_takes_speed_by_the_motors_compliance() -> None:
    floor = {"slope": 2.0 * RADIAN, "compliance": 0.1}
    loss = 0.1 * 9.81 * math.sin(2.0 * RADIAN)  # 34 mm/s
    assert drive(make(only(floor=floor)), 1, 0.3)[0] == pytest.approx((0.3 - loss, 0.0))
    assert drive(make(only(floor=floor), (0.0, 0.0, math.pi)), 1, 0.3)[0] == pytest.approx((0.3 + loss, 0.0))
    across = make(only(floor=floor | {"uphill": 0.5 * math.pi}))
    assert drive(across, 1, 0.3)[0] == pytest.approx((0.3, 0.0))


def test_a_cross_slope_turns_the_chair_downhill_and_lets_it_creep() -> None:
    floor = {"slope": 2.0 * RADIAN, "uphill": 0.5 * math.pi, "downhill_turn": 0.1, "side_slip": 0.02}
    plant = make(only(floor=floor))
    pull = 9.81 * math.sin(2.0 * RADIAN)
    assert drive(plant, 1, 0.3)[0] == pytest.approx((0.3, -0.1 * pull))  # uphill is to the left
    assert plant.motion.side == pytest.approx(-0.003 * 0.02 * pull)
    assert plant.pose[1] == pytest.approx(-0.003 * 0.02 * pull - 0.003 * 0.5 * 0.001 * pull, rel=1e-3)
    halfway = plant.pose_within(0.5)
    assert halfway == pytest.approx(plant.pose / 2.0, rel=0.3, abs=1e-9)
    assert plant.pose_within(1.0) == pytest.approx(plant.pose, abs=1e-15)


def test_a_standing_chair_stays_on_the_slope() -> None:
    plant = make(only(floor={"slope": 0.1, "compliance": 0.1, "downhill_turn": 0.1}))
    assert set(drive(plant, 100)) == {(0.0, 0.0)}


def test_brakes_end_the_creep_of_the_lag() -> None:
    floor, motor = {"slope": 2.0 * RADIAN, "compliance": 0.1}, {"lag_v": 0.5, "brake_delay": 0.2}
    plant = make(only(floor=floor, motor=motor))
    drive(plant, 300, 0.3)
    speeds = [v for v, _ in drive(plant, 25)]
    assert speeds[18] != 0.0 and speeds[20:] == [0.0] * 5
    loose = make(only(floor=floor, motor=motor | {"brake_delay": 0.0}))
    drive(loose, 300, 0.3)
    assert drive(loose, 300)[-1][0] < -0.03  # rolls back while the lag fades


def test_wheel_errors_change_what_is_driven() -> None:
    plant = make(only(wheels={"radius_error_left": 0.01, "radius_error_right": -0.005, "track_error": 0.015}))
    v, omega = drive(plant, 1, 0.4, 0.3)[0]
    left, right = 1.01 * (0.4 - 0.15 * TRACK), 0.995 * (0.4 + 0.15 * TRACK)
    assert (v, omega) == pytest.approx((0.5 * (left + right), (right - left) / (1.015 * TRACK)))


@pytest.mark.parametrize("bad", [(math.nan, 0.1), (0.1, math.inf)])
def test_commands_that_are_not_finite_stop_the_chair(bad: tuple[float, float]) -> None:
    plant = make(WheelchairSettings())
    drive(plant, 100, 0.3, 0.2)
    assert plant.command(*bad) is False and plant.refused == 1
    for _ in range(300):
        plant.step(STEP)
    assert (plant.v, plant.omega) == (0.0, 0.0) and np.all(np.isfinite(plant.pose))


def test_halt_and_block() -> None:
    plant = make(WheelchairSettings())
    drive(plant, 100, 0.3, 0.1)
    before, ticks = plant.pose.copy(), plant.encoders.left
    plant.step(STEP)
    plant.block()
    assert plant.pose.tolist() == before.tolist() and plant.encoders.left == pytest.approx(ticks, abs=1e-12)
    assert (plant.v, plant.motion.way) == (0.0, 0.0)
    plant.halt()
    for _ in range(30):
        plant.step(STEP)
    assert plant.pose.tolist() == before.tolist()


def test_a_pose_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ValueError, match="must be three finite numbers"):
        make(only(), (0.0, math.nan, 0.0))


def test_with_all_effects_the_same_seed_gives_the_same_bits() -> None:
    def run(seed: int) -> list[float]:
        plant = make(WheelchairSettings(), seed=seed, limits=LIMITS)
        for k in range(500):
            plant.command(0.3, 0.3 * math.sin(0.02 * k))
            plant.step(STEP)
        return [*plant.pose.tolist(), plant.encoders.left, *plant.castors.angles]

    assert run(4) == run(4)
    assert run(4) != run(5)


def test_without_power_the_brakes_stop_it_whatever_is_asked() -> None:
    """After 0.1 s, by the ramp's deceleration, without delay and lag; commands meanwhile are lost."""
    motor = {"deceleration": 1.5, "turn_deceleration": 3.0, "lag_v": 0.2, "lag_omega": 0.2}
    plant = make(only(command={"delay": 0.3}, motor=motor))
    before = drive(plant, 500, 0.6, 0.3)[-1]
    assert before == pytest.approx((0.6, 0.3), abs=1e-6)
    plant.power(False)
    speeds = drive(plant, 60, 0.6, 0.3)
    np.testing.assert_allclose(speeds[:10], [before] * 10, atol=1e-6)
    slowing = [max(0.0, 0.6 - 1.5 * SECONDS * (k + 0.5)) for k in range(40)]  # means of each step
    assert [v for v, _ in speeds[10:50]] == pytest.approx(slowing, abs=1e-6)
    assert speeds[20] == pytest.approx((0.6 - 1.5 * 0.105, 0.0), abs=1e-6), "3 rad/s^2 take 0.1 s"
    assert speeds[-1] == (0.0, 0.0)
    plant.power(True)
    assert plant.v == 0.0 and drive(plant, 29, 0.6)[-1] == (0.0, 0.0), "what was asked without power is lost"
    assert drive(plant, 50, 0.6)[-1][0] > 0.3


def test_the_next_loss_of_power_begins_anew() -> None:
    plant = make(only(motor={"deceleration": 1.5}))
    for _ in range(2):
        drive(plant, 20, 0.3)
        plant.power(False)
        assert [v for v, _ in drive(plant, 10)] == pytest.approx([0.3] * 10)
        drive(plant, 30)
        plant.power(True)
