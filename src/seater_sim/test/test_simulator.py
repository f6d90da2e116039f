"""The whole simulation, without ROS."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from seater_common.geometry import Bay, Chair, Dock, clearance
from seater_common.params import ParameterError, as_mapping, load
from seater_sim.camera.camera import Camera
from seater_sim.loop.simulator import Due, Simulator
from seater_sim.settings import KINEMATIC, Obstacle, PlantSettings, SimulatorSettings
from seater_sim.world.events import load_events

DEFAULT = SimulatorSettings()
# The ideal chair: these tests are about the loop, and expect where a plain chair is to the millimetre.
SETTINGS = dataclasses.replace(DEFAULT, plant=PlantSettings(KINEMATIC))


def make(
    start: tuple[float, float, float] = (-1.5, 0.0, 0.0),
    events: object = (),
    camera: Camera | None = None,
    seed: int = 1,
) -> Simulator:
    happenings = load_events(list(events), "events", [0, 1, 2])  # type: ignore[call-overload]
    return Simulator(SETTINGS, Chair(), Dock(), None, start, seed=seed, events=happenings, camera=camera)


def drive(simulator: Simulator, seconds: float, v: float = 0.0, omega: float = 0.0) -> list[Due]:
    steps = []
    for _ in range(round(seconds / SETTINGS.step)):
        simulator.command(v, omega)
        steps.append(simulator.step())
    return steps


def test_configuration_file_is_the_default(simulator_values: dict[str, Any]) -> None:
    assert load(SimulatorSettings, simulator_values, "simulator") == DEFAULT


def test_wrong_configuration_is_named() -> None:
    values = as_mapping(SETTINGS)
    values["plant"]["kinematic"]["lag_v"] = -1.0
    values["odometry"]["period"] = 0.025
    values["obstacles"] = [{"outline": [0.0, 0.0, 0.0, 1.0, 1.0, 0.0], "height": 1.0}]
    del values["camera"]["rate"]
    with pytest.raises(ParameterError) as error:
        load(SimulatorSettings, values, "simulator")
    text = str(error.value)
    assert "simulator/plant/kinematic/lag_v: is -1.0, must be >= 0.0 [s]" in text
    assert "simulator/camera/rate: is missing" in text
    assert "simulator/obstacles[0]: outline: [0.0, 0.0, 0.0, 1.0, 1.0, 0.0] is not convex and anticlockwise" in text
    values["plant"]["kinematic"]["lag_v"], values["camera"]["rate"], values["obstacles"] = 0.1, 30.0, []
    with pytest.raises(ParameterError, match=r"odometry/period: is 0\.025, must be a multiple of step"):
        load(SimulatorSettings, values, "simulator")


def test_rates_stamps_and_latency() -> None:
    steps = drive(make(), 2.0)
    assert [d.time_ns for d in steps[:2]] == [10_010_000_000, 10_020_000_000]
    odometry = [d.odometry.time_ns for d in steps if d.odometry]
    assert odometry == [10_000_000_000 + 20_000_000 * k for k in range(1, 101)]
    images = [(d.time_ns, p) for d in steps for p in d.images]
    assert len(images) == 58  # 60, less those on the way during the last 50 ms
    for k, (delivered, image) in enumerate(images, start=1):
        assert image.index == k
        assert image.stamp_ns == 10_000_000_000 + round(k * 1e9 / 30)
        assert 50_000_000 <= delivered - image.stamp_ns < 60_000_000


def test_a_image_shows_the_pose_at_its_stamp() -> None:
    simulator = make((-2.0, 0.3, 0.2))
    steps = drive(simulator, 2.0, 0.4, -0.3)
    times = [10.0] + [1e-9 * d.truth.time_ns for d in steps]
    poses = np.array([[-2.0, 0.3, 0.2]] + [d.truth.pose for d in steps])
    for image in (p for d in steps for p in d.images):
        expected = [np.interp(1e-9 * image.stamp_ns, times, poses[:, i]) for i in range(3)]
        np.testing.assert_allclose(image.pose, expected, atol=1e-5)
        assert image.v <= 0.4 + 1e-9


def test_same_seed_same_run() -> None:
    def run(seed: int) -> list[object]:
        return [
            (d.truth.pose.tolist(), d.odometry.pose.tolist())
            for d in drive(make(seed=seed), 3.0, 0.3, 0.1)
            if d.odometry
        ]

    assert run(3) == run(3)
    assert run(3) != run(4)


def test_driving_straight_in_closes_the_contact() -> None:
    simulator = make((-0.5, 0.0, 0.0))
    assert not simulator.truth.contact
    closed = []
    for _ in range(1500):
        x = simulator.truth.pose[0]
        simulator.command(min(0.15, max(0.0, -x)), 0.0)
        truth = simulator.step().truth
        closed.append((truth.contact, abs(float(truth.pose[0])), truth.v))
    assert closed[-1][0] and closed[-1][1] < 0.01
    first = next(i for i, c in enumerate(closed) if c[0])
    assert closed[first][1] <= 0.020 and closed[first][2] <= 0.02
    drive(simulator, 2.0, -0.2)
    assert not simulator.truth.contact


def test_wall_stops_the_chair_and_counts_once() -> None:
    simulator = make((-0.5, 0.0, 0.0))
    steps = drive(simulator, 8.0, 0.15)
    truth = steps[-1].truth
    # The front is at the back wall: 0.15 m beyond the docking pose, less than one step's way short of it.
    assert 0.15 - 0.0016 < truth.pose[0] <= 0.15 + 1e-9
    assert truth.touching and truth.collisions == 1 and truth.min_clearance == 0.0
    assert steps[-1].odometry is not None and abs(steps[-1].odometry.v) < 0.01  # wheels that are stalled do not turn
    truth = drive(simulator, 2.0, -0.15)[-1].truth
    assert not truth.touching and truth.pose[0] < -0.05
    assert drive(simulator, 4.0, 0.15)[-1].truth.collisions == 2


def test_turning_into_a_side_wall_is_a_collision() -> None:
    simulator = make((-0.2, 0.0, 0.0))
    truth = drive(simulator, 4.0, 0.0, 0.5)[-1].truth
    assert truth.collisions == 1 and 0.1 < truth.pose[2] < 0.6


def test_smallest_clearance_of_a_run_past_the_wall() -> None:
    simulator = make((-2.5, 0.0, 0.0))
    truth = drive(simulator, 10.0, 0.2)[-1].truth  # stops short of touching
    front = 0.5 - 0.5 * Chair().width  # beside the side walls, once inside
    assert truth.pose[0] > -0.74
    assert truth.min_clearance == pytest.approx(front, abs=1e-6)
    assert truth.collisions == 0


def test_smallest_clearance_of_a_run_that_stays_away() -> None:
    simulator = make((-2.5, 0.0, 0.0))
    steps = drive(simulator, 4.0, 0.2) + drive(simulator, 4.0, -0.2)
    exact = min(clearance(Chair(), Dock().bay, due.truth.pose) for due in steps)
    assert 0.3 < exact < 1.5
    assert exact <= steps[-1].truth.min_clearance <= exact + 0.011  # known to 10 mm as long as it is that large


def test_obstacle_stops_the_chair() -> None:
    settings = dataclasses.replace(SETTINGS, obstacles=[Obstacle([-1.0, -0.1, -0.9, -0.1, -0.9, 0.1, -1.0, 0.1], 1.0)])
    simulator = Simulator(settings, Chair(), Dock(), None, (-2.5, 0.0, 0.0))
    truth = drive(simulator, 6.0, 0.3)[-1].truth
    assert truth.collisions == 1 and truth.pose[0] == pytest.approx(-1.75, abs=0.004)


def test_open_dock_stops_the_chair_at_its_back_wall_only() -> None:
    dock = dataclasses.replace(Dock(), bay=Bay(side_wall_length=0.0))
    simulator = Simulator(SETTINGS, Chair(), dock, None, (-1.0, 0.4, 0.0))
    truth = drive(simulator, 8.0, 0.3)[-1].truth
    assert truth.collisions == 1 and truth.pose[0] == pytest.approx(0.15, abs=0.004)


def test_start_in_a_wall_or_nowhere_is_refused() -> None:
    with pytest.raises(ValueError, match="the chair overlaps a wall"):
        make((0.3, 0.0, 0.0))
    with pytest.raises(ValueError, match="must be three finite numbers"):
        make((math.nan, 0.0, 0.0))


def test_commands_that_are_not_finite_are_counted() -> None:
    simulator = make()
    assert simulator.command(0.1, 0.1) is True
    assert simulator.command(math.nan, 0.1) is False
    assert simulator.refused == 1


def test_events_change_the_images(camera: Camera) -> None:
    events = [
        {"at": 0.5, "do": "nan_images"},
        {"at": 1.0, "do": "nan_camera_info"},
        {"at": 1.5, "do": "camera_off"},
        {"at": 2.0, "do": "good_images"},
        {"at": 2.5, "do": "cover", "ids": [0]},
        {"at": 1.0, "do": "odometry_off"},
        {"at": 1.5, "do": "odometry_on"},
    ]
    simulator = make(events=events, camera=camera)
    steps = drive(simulator, 3.0)
    by_time = {round((p.stamp_ns - 10_000_000_000) / 1e9 * 30): p for d in steps for p in d.images}
    assert by_time[10].encoding == "mono8" and by_time[10].camera_info_valid
    nan = by_time[20]
    assert nan.encoding == "32FC1"
    pixels = nan.render()
    assert pixels.shape == (720, 1280) and pixels.dtype == np.float32 and np.all(np.isnan(pixels))
    assert by_time[40].encoding == "mono8" and not by_time[40].camera_info_valid
    assert not any(47 <= k <= 59 for k in by_time)
    assert by_time[70].covered == frozenset() and by_time[80].covered == {0}
    odometry = [round((d.time_ns - 10_000_000_000) / 1e7) for d in steps if d.odometry]
    assert not any(100 <= k < 150 for k in odometry) and {98, 150} <= set(odometry)
    assert all(d.tick == (d.time_ns % 20_000_000 == 0) for d in steps)


def test_event_by_distance() -> None:
    simulator = make((-2.0, 0.0, 0.0), events=[{"distance_below": 1.5, "do": "cover"}])
    for due in drive(simulator, 4.0, 0.3):
        assert (simulator.world.covered != frozenset()) or -due.truth.pose[0] >= 1.5
    assert simulator.world.covered == {0, 1, 2}
    assert -simulator.truth.pose[0] < 1.5


def test_images_are_drawn_only_on_request(model: object, camera: Camera) -> None:
    image = next(p for d in drive(make(camera=camera), 0.2) for p in d.images)
    assert image.render().shape == (720, 1280)
    blind = next(p for d in drive(make(), 0.2) for p in d.images)
    with pytest.raises(RuntimeError, match="has no camera model"):
        blind.render()
