"""The scripted drive: limits, area, and zero velocity on every exit."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from seater_common.geometry import Chair, Limits
from seater_identify.drive.driver import ASTRAY, TURN_BACK, Driver, DriveState
from seater_identify.drive.moves import OMEGA, Travel, TurnBack, V
from seater_identify.drive.script import AreaError, make_script, straight_way
from seater_identify.settings import AreaSettings, IdentifySettings
from seater_identify.trial.simulation import simulate
from seater_sim.chair.plant_ranges import load_plant_ranges
from seater_sim.settings import (
    CommandSettings,
    KinematicSettings,
    PlantSettings,
    SimulatorSettings,
    WheelchairSettings,
)

CONFIG = Path(__file__).resolve().parents[3] / "config"
SETTINGS, CHAIR = IdentifySettings(), Chair()
SIMULATOR = SimulatorSettings(plant=PlantSettings(kind="kinematic", kinematic=KinematicSettings()))


def started(pose: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Driver:
    driver = Driver(SETTINGS, CHAIR)
    driver.odometry(0.0, pose, 0.0)
    assert driver.start(0.0)
    return driver


@pytest.mark.parametrize("limits", [Limits(), Limits(v_max=0.25, v_reverse_max=0.15, omega_max=0.4, a_max=0.3)])
def test_a_whole_drive_keeps_limits_and_area_and_ends_at_rest(limits: Limits) -> None:
    chair = Chair(limits=limits)
    drive = simulate(SETTINGS, chair, SIMULATOR, 1, None)
    assert drive.state is DriveState.DONE
    time, v, omega = drive.recording.commands.T
    assert v.max() <= limits.v_max and v.min() >= -limits.v_reverse_max and np.abs(omega).max() <= limits.omega_max
    assert np.abs(np.diff(v)).max() <= limits.a_max * SETTINGS.drive.period + 1e-9
    assert np.abs(np.diff(omega)).max() <= limits.alpha_max * SETTINGS.drive.period + 1e-9
    assert v[-1] == omega[-1] == 0.0
    assert time[-1] < 140.0
    corners = np.concatenate([chair.corners_at(pose) for pose in drive.truth[::10, 1:]])
    assert np.ptp(corners[:, 0]) < SETTINGS.area.length + 0.1 and np.ptp(corners[:, 1]) < SETTINGS.area.width


def test_a_chair_that_slides_on_a_slope_comes_back() -> None:
    """It slides while it turns; the last straight ends where the first began all the same, within the area."""
    ranges = load_plant_ranges(CONFIG / "plants" / "worn_chair.yaml")
    drive = simulate(SETTINGS, CHAIR, ranges.draw_simulator(np.random.default_rng(503), SimulatorSettings()), 503, None)
    assert drive.state is DriveState.DONE, drive.text
    assert abs(drive.truth[-1, 1] - drive.truth[0, 1]) < 0.1  # 0.18 m and more when it drives the planned way only


def test_nothing_moves_before_the_start_nor_without_odometry() -> None:
    driver = Driver(SETTINGS, CHAIR)
    assert driver.command(0.0) == (0.0, 0.0)
    assert not driver.start(0.0) and "no odometry" in driver.text
    driver.odometry(0.0, (0.0, 0.0, 0.0), 0.0)
    assert not driver.start(1.0) and "no odometry" in driver.text


def drive_on(driver: Driver, now: float, until: float) -> float:
    """With odometry that stands still; the time."""
    while now < until:
        now += 0.02
        driver.odometry(now, (0.0, 0.0, 0.0), now)
        driver.command(now)
    return now


def test_old_odometry_stops_at_once() -> None:
    driver = started()
    now = drive_on(driver, 0.0, 4.0)
    assert driver.command(now + 0.29) != (0.0, 0.0)
    assert driver.command(now + 0.31) == (0.0, 0.0)
    assert driver.state is DriveState.STOPPED and "odometry" in driver.text


@pytest.mark.parametrize("chair", [CHAIR, Chair(length_front=0.35, length_rear=0.7)], ids=["rear", "front-wheel drive"])
def test_it_turns_at_two_places_far_apart_and_needs_no_more_area_for_it(chair: Chair) -> None:
    way = straight_way(SETTINGS, chair)
    places, at = [], 0.0
    for move in make_script(SETTINGS, chair):
        if isinstance(move, Travel) and move.axis == V:
            at += move.amount
        elif isinstance(move, Travel):
            places.append((math.copysign(1.0, move.amount), at))
    assert at == pytest.approx(0.0) and len(places) == 4
    (left,), (right,) = ({round(place, 9) for sign, place in places if sign == turn} for turn in (1.0, -1.0))
    assert right - left > 0.3
    radius = math.hypot(max(chair.length_front, chair.length_rear), 0.5 * chair.width)
    in_the_middle = max(chair.length_rear, radius - 0.5 * way), max(way + chair.length_front, 0.5 * way + radius)
    assert radius - left <= in_the_middle[0] + 1e-9 and right + radius <= in_the_middle[1] + 1e-9


def test_leaving_the_area_stops_at_once() -> None:
    driver = started((1.0, 2.0, 0.5))
    now = drive_on(driver, 0.0, 0.02)
    driver.odometry(now + 0.02, (3.5, 2.0, 0.5), now + 0.02)
    assert driver.command(now + 0.02) == (0.0, 0.0)
    assert driver.state is DriveState.STOPPED and "area" in driver.text


def test_cancel_stops_at_once() -> None:
    driver = started()
    now = drive_on(driver, 0.0, 4.0)
    driver.stop("cancelled")
    assert driver.command(now + 0.02) == (0.0, 0.0)
    assert (driver.state, driver.text) == (DriveState.STOPPED, "cancelled")


def test_an_area_that_is_too_small_is_refused_with_the_size_that_would_do() -> None:
    with pytest.raises(AreaError, match=r"must be at least 1\.\d\d m x 1\.74 m"):
        Driver(IdentifySettings(area=AreaSettings(length=2.2, width=1.5)), CHAIR)


def test_a_chair_that_ignores_small_turns_ends_its_drive() -> None:
    """Turns back that do not move it are given up: the drive goes on, and ends."""
    command = CommandSettings(deadband_omega=0.1, deadband_kind="offset")
    plant = PlantSettings(kind="wheelchair", wheelchair=WheelchairSettings(command=command))
    drive = simulate(SETTINGS, CHAIR, SimulatorSettings(plant=plant), 3, None)
    assert drive.state is DriveState.DONE, drive.text
    assert drive.recording.duration < 130.0


def test_a_small_turn_back_moves_the_chair() -> None:
    """It is slow enough not to be over before it began."""
    off = 1.2 * ASTRAY
    driver = started()
    driver._moves[1:1] = [TurnBack(OMEGA, off, min(TURN_BACK, 2.0 * off))]
    driver._planned[OMEGA] = off
    now, heading = 0.0, 0.0
    for _ in range(300):
        now += 0.02
        heading += 0.02 * driver.command(now)[1]
        driver.odometry(now, (0.0, 0.0, heading), now)
    assert 0.4 * off < heading < 1.1 * off  # REACTION is left for a chair that stops late
