"""Scan and depth image against geometry; who walks."""

import dataclasses
import math

import numpy as np
import pytest

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_sim.loop.simulator import Simulator
from seater_sim.ranging.sensor import RangeSensor
from seater_sim.settings import (
    DEPTH,
    SCAN,
    DepthSettings,
    Obstacle,
    PlantSettings,
    RangingSettings,
    ScanSettings,
    SimulatorSettings,
    Walker,
)

BOX = Obstacle([-1.1, -0.2, -0.8, -0.2, -0.8, 0.2, -1.1, 0.2], 0.4)
EXACT = RangingSettings(SCAN, scan=ScanSettings(noise_sd=0.0), depth=DepthSettings(noise=0.0))
PLANT = PlantSettings("kinematic")


def settings(ranging: RangingSettings = EXACT, **changes: object) -> SimulatorSettings:
    return dataclasses.replace(SimulatorSettings(plant=PLANT), ranging=ranging, **changes)


Scan = tuple[RangeSensor, np.ndarray]
NOBODY = np.empty((0, 2))


def scanned(pose: tuple[float, float, float], there: np.ndarray = NOBODY, **changes: object) -> Scan:
    sensor = RangeSensor(settings(**changes), Chair().camera, Dock(), None)
    return sensor, sensor.measure(pose, there, 1, 1)


def ahead(sensor: RangeSensor, ranges: np.ndarray, bearing: float = 0.0) -> float:
    return float(ranges[np.argmin(np.abs(sensor.angles - bearing))])


def test_a_scan_meets_the_nearest_wall_on_each_ray() -> None:
    sensor, ranges = scanned((-2.0, 0.0, 0.0))
    assert ahead(sensor, ranges) == pytest.approx(0.9 + 2.0 - 0.7, abs=1e-4)
    assert ahead(sensor, ranges, math.atan2(0.55, 1.3)) == pytest.approx(math.hypot(1.3, 0.55), abs=0.01)
    sensor, ranges = scanned((-2.0, 0.0, 0.0), obstacles=[BOX])
    assert ahead(sensor, ranges) == pytest.approx(2.0 - 1.1 - 0.7, abs=1e-4)
    sensor, ranges = scanned((-2.0, 0.0, 0.0), obstacles=[dataclasses.replace(BOX, height=0.2)])
    assert ahead(sensor, ranges) > 2.0  # the scanner looks over it
    sensor, ranges = scanned((-2.0, 0.0, 0.5 * math.pi))
    assert ahead(sensor, ranges) == pytest.approx(6.0 - 0.7, abs=1e-4)  # the room


def test_what_is_too_near_or_too_far_is_said_as_in_a_laser_scan() -> None:
    sensor, ranges = scanned((-1.84, 0.0, 0.0), obstacles=[BOX])
    assert math.isnan(ahead(sensor, ranges))
    sensor, ranges = scanned((-2.0, 0.0, math.pi))
    assert math.isinf(ahead(sensor, ranges))


def test_a_depth_image_has_floor_and_things_at_their_depth(model: CameraModel) -> None:
    sensor = RangeSensor(
        settings(dataclasses.replace(EXACT, kind=DEPTH), obstacles=[BOX]), Chair().camera, Dock(), model
    )
    depth = sensor.measure((-3.0, 0.0, 0.0), NOBODY, 1, 1)
    v = np.arange(90) - sensor.K[1, 2]
    middle = depth[:, 80]
    box = 3.0 - 1.1 - 0.45
    floor = 0.7 * sensor.K[1, 1] / np.maximum(v, 1e-6)
    down = 0.7 - 0.4  # [m] of its upper edge below the camera
    expected = np.where(v * box / sensor.K[1, 1] > down, np.minimum(box, floor), 0.0)
    seen = (v * 0.7 > 0.0) & (expected > 0.0)
    assert seen.sum() > 20 and middle[seen] == pytest.approx(expected[seen], abs=1e-6)
    assert np.all(np.isfinite(depth))


def test_a_depth_image_needs_a_calibration() -> None:
    with pytest.raises(ValueError, match="needs the camera's calibration"):
        RangeSensor(settings(dataclasses.replace(EXACT, kind=DEPTH)), Chair().camera, Dock(), None)


def test_noise_depends_on_seed_and_index_only() -> None:
    sensor = RangeSensor(settings(RangingSettings(SCAN)), Chair().camera, Dock(), None)
    one, same, other = (sensor.measure((-2.0, 0.0, 0.0), NOBODY, 1, i) for i in (1, 1, 2))
    assert np.array_equal(one, same, equal_nan=True) and not np.array_equal(one, other, equal_nan=True)
    both = np.isfinite(one) & np.isfinite(other)
    assert np.std(one[both] - other[both]) == pytest.approx(math.sqrt(2.0) * 0.01, rel=0.2)


def test_the_simulator_delivers_at_its_pace_after_the_latency() -> None:
    simulator = Simulator(settings(), Chair(), Dock(), None, (-2.5, 0.0, 0.0), seed=1)
    got = [(due.time_ns, taken.stamp_ns) for due in (simulator.step() for _ in range(50)) for taken in due.ranges]
    start = simulator.time_ns - 500_000_000
    assert got == [(start + 100_000_000 * i + 40_000_000, start + 100_000_000 * i) for i in (1, 2, 3, 4)]


def test_without_a_sensor_there_is_nothing() -> None:
    simulator = Simulator(SimulatorSettings(plant=PLANT), Chair(), Dock(), None, (-2.5, 0.0, 0.0))
    assert not any(simulator.step().ranges for _ in range(50))


def test_who_walks_is_seen_where_he_is() -> None:
    walker = Walker([-0.5, -1.2], [0.0, 1.2], begin=1.0, duration=2.0, radius=0.2)
    simulator = Simulator(settings(walkers=[walker]), Chair(), Dock(), None, (-2.0, 0.0, 0.0))
    places = []
    for _ in range(400):
        simulator.step()
        places.append(float(simulator.walkers[0, 1]))
    assert places[49] == -1.2 and places[199] == pytest.approx(0.0) and places[399] == pytest.approx(1.2)
    sensor, ranges = scanned((-2.0, 0.0, 0.0), np.array([[-0.5, 0.0]]), walkers=[walker])
    assert ahead(sensor, ranges) == pytest.approx(2.0 - 0.5 - 0.7 - 0.2, abs=0.005)


@pytest.mark.parametrize(("v", "touches"), [(0.3, 1), (0.0, 0)])
def test_the_chair_touches_who_stands_ahead_and_nobody_walks_into_it(v: float, touches: int) -> None:
    stops_ahead = Walker([-1.0, -1.5], [0.0, 1.5], begin=0.0, duration=1.0)
    comes_aside = Walker([-2.2, -2.4], [0.0, 1.2], begin=0.5, duration=9.0)
    simulator = Simulator(settings(walkers=[stops_ahead, comes_aside]), Chair(), Dock(), None, (-2.2, 0.0, 0.0))
    for _ in range(400):
        simulator.command(v, 0.0)
        due = simulator.step()
    assert due.truth.collisions == touches
    if not v:
        assert simulator.walkers[0, 1] == pytest.approx(0.0)
        assert simulator.walkers[1, 1] == pytest.approx(-0.325 - 0.22 - 0.1, abs=0.02)  # he waits


def test_a_period_that_no_odometry_has_is_refused() -> None:
    with pytest.raises(ValueError, match="ranging/period"):
        settings(
            RangingSettings(SCAN, period=0.05, latency=0.0),
            odometry=dataclasses.replace(SimulatorSettings().odometry, period=0.04),
        )
