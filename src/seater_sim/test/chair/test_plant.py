"""The plant `kinematic` against closed forms."""

import math

import numpy as np
import pytest

from seater_common.geometry import Limits
from seater_sim.chair.plant import KinematicPlant
from seater_sim.settings import KinematicSettings

STEP = 10_000_000  # [ns]
UNLIMITED = Limits(v_max=3.0, v_reverse_max=3.0, omega_max=4.0, a_max=5.0, alpha_max=10.0)


LIMITS = Limits()


def make(limits: Limits = LIMITS, **changes: float) -> KinematicPlant:
    settings = KinematicSettings(**({"command_delay": 0.0, "command_timeout": 100.0} | changes))
    return KinematicPlant(settings, limits, (0.0, 0.0, 0.0))


def run(plant: KinematicPlant, steps: int, v: float, omega: float) -> np.ndarray:
    """Rows of (v, omega) after each step, the command repeated before each."""
    rows = []
    for _ in range(steps):
        plant.command(v, omega)
        plant.step(STEP)
        rows.append((plant.v, plant.omega))
    return np.array(rows)


def test_step_response_of_the_lag_is_exponential() -> None:
    # A command reached within one step of the ramp, so that after it only the lag is left.
    plant = make(UNLIMITED, lag_v=0.2)
    plant.command(0.05, 0.0)
    plant.step(STEP)
    v0, way = plant.v, 0.0
    for k in range(1, 60):
        plant.command(0.05, 0.0)
        plant.step(STEP)
        way += plant.motion.way
        expected = 0.05 + (v0 - 0.05) * math.exp(-0.01 * k / 0.2)
        assert plant.v == pytest.approx(expected, abs=1e-12)
    # Integral of the exponential.
    assert way == pytest.approx(0.05 * 0.59 + (v0 - 0.05) * 0.2 * (1.0 - math.exp(-0.59 / 0.2)), abs=1e-12)


def test_ramp_response_of_the_lag() -> None:
    # While the demand is a t, a first-order lag gives a (t - tau (1 - exp(-t / tau))).
    plant = make(lag_v=0.1)
    speeds = run(plant, 100, 0.6, 0.0)[:, 0]
    t = 0.01 * np.arange(1, 101)
    np.testing.assert_allclose(speeds, 0.5 * (t - 0.1 * (1.0 - np.exp(-t / 0.1))), atol=1e-12)


def test_step_size_does_not_matter() -> None:
    def end(step_ns: int) -> np.ndarray:
        plant = make(command_delay=0.04)
        for k in range(2_000_000_000 // step_ns):
            if k == 0:
                plant.command(0.4, 0.5)
            plant.step(step_ns)
        return plant.pose

    # What is left is the speed's change within a step while turning (3 um/m at 10 ms).
    np.testing.assert_allclose(end(10_000_000), end(1_000_000), atol=2e-5)


def test_without_lag_it_drives_an_arc() -> None:
    plant = make(UNLIMITED, lag_v=0.0, lag_omega=0.0)
    run(plant, 200, 0.5, 0.4)
    before = plant.pose
    run(plant, 100, 0.5, 0.4)
    heading, radius = before[2], 0.5 / 0.4
    expected = before + [
        radius * (math.sin(heading + 0.4) - math.sin(heading)),
        -radius * (math.cos(heading + 0.4) - math.cos(heading)),
        0.4,
    ]
    np.testing.assert_allclose(plant.pose, expected, atol=1e-12)


def test_delay_in_steps() -> None:
    plant = make(lag_v=0.0, command_delay=0.04)
    speeds = run(plant, 8, 0.6, 0.0)[:, 0]
    # Four steps nothing, then the ramp of 0.5 m/s^2.
    np.testing.assert_allclose(speeds, [0, 0, 0, 0, 0.005, 0.010, 0.015, 0.020], atol=1e-12)


def test_each_command_is_delayed_by_itself() -> None:
    plant = make(UNLIMITED, lag_v=0.0, command_delay=0.03)
    seen = []
    for command in (0.01, 0.03, 0.02, 0.0, 0.0, 0.0, 0.0):
        plant.command(command, 0.0)
        plant.step(STEP)
        seen.append(plant.v)
    np.testing.assert_allclose(seen, [0, 0, 0, 0.01, 0.03, 0.02, 0.0], atol=1e-12)


def test_speeds_and_accelerations_stay_within_the_limits() -> None:
    limits = Limits()
    plant = make(limits)
    rows = np.vstack([run(plant, 250, 99.0, -99.0), run(plant, 250, -99.0, 99.0)])
    assert rows[:, 0].max() == pytest.approx(limits.v_max, abs=1e-4)
    assert rows[:, 0].min() == pytest.approx(-limits.v_reverse_max, abs=1e-4)
    assert abs(rows[:, 1]).max() == pytest.approx(limits.omega_max, abs=1e-4)
    changes = abs(np.diff(rows, axis=0)) / 0.01
    assert changes[:, 0].max() == pytest.approx(limits.a_max, rel=1e-3)
    assert changes[:, 1].max() == pytest.approx(limits.alpha_max, rel=1e-3)


def test_timeout_ramps_down_to_a_standstill() -> None:
    plant = make(lag_v=0.0, lag_omega=0.0, command_timeout=0.25)
    run(plant, 150, 0.3, 0.3)
    speeds = []
    for _ in range(120):
        plant.step(STEP)
        speeds.append(plant.v)
    # The last command acts for 25 steps, one of them already made; then 0.5 m/s^2.
    np.testing.assert_allclose(speeds[:24], 0.3, atol=1e-12)
    np.testing.assert_allclose(speeds[24:84], 0.3 - 0.005 * np.arange(1, 61), atol=1e-12)
    assert speeds[-1] == 0.0 and plant.omega == 0.0


def test_no_command_no_motion() -> None:
    plant = make()
    for _ in range(100):
        plant.step(STEP)
    assert plant.v == 0.0 and plant.pose.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("bad", [(math.nan, 0.1), (0.1, math.inf), (-math.inf, math.nan)])
def test_commands_that_are_not_finite_stop_the_chair(bad: tuple[float, float]) -> None:
    plant = make()
    run(plant, 100, 0.3, 0.2)
    assert plant.command(*bad) is False
    for _ in range(300):
        plant.step(STEP)
    assert plant.refused == 1
    assert plant.v == 0.0 and plant.omega == 0.0 and np.all(np.isfinite(plant.pose))


def test_friction_ends_the_exponential() -> None:
    plant = make()
    run(plant, 100, 0.3, 0.0)
    run(plant, 300, 0.0, 0.0)
    assert plant.v == 0.0


def test_halt_stands_at_once_and_forgets() -> None:
    plant = make(command_delay=0.04)
    run(plant, 100, 0.3, 0.1)
    plant.halt()
    pose = plant.pose.copy()
    for _ in range(20):
        plant.step(STEP)
    assert plant.pose.tolist() == pose.tolist()


def test_without_power_it_brakes_within_its_limits() -> None:
    plant = make(lag_v=0.2, command_delay=0.3)
    run(plant, 500, 0.5, 0.2)
    plant.power(False)
    rows = run(plant, 100, 0.5, 0.2)
    slower = 0.01 * np.arange(1, 101)[:, None] * [LIMITS.a_max, LIMITS.alpha_max]
    np.testing.assert_allclose(rows, np.maximum(0.0, [0.5, 0.2] - slower), atol=1e-6)
    plant.power(True)
    assert run(plant, 29, 0.5, 0.0)[-1, 0] == 0.0, "what was asked without power is lost"
    assert run(plant, 50, 0.5, 0.0)[-1, 0] > 0.1
