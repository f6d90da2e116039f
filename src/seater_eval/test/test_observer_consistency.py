"""Whether the observer's covariance is that of its errors: 200 approaches, normalised estimation error squared (NEES).

Each run drives a smooth way to the dock, with the drifting odometry of config/simulator.yaml and with images as
pose_noise makes them, late and at times out of order, some runs with a stretch without any. The error is that of the
dock in odom given the odometry's pose: it is what the controller gets, the dock as seen from the chair. If the filter
is consistent, the sum of e' P^-1 e over the runs is chi-square with 3 * RUNS degrees of freedom at every time
(Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section 5.4).
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from seater_common.geometry import clearance
from seater_common.se2 import arc_step, compose, inverse, wrap_angle
from seater_eval.control.campaign_run import draw_start
from seater_eval.control.pose_noise import DockSensor
from seater_eval.run.setup_files import Setup, load_setup
from seater_nmpc.observe.innovation import Outcome
from seater_nmpc.observe.measurement import difference
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.message import Odometry as OdometryMessage
from seater_nmpc.parameters import ObserverParameters
from seater_sim.chair.odometry import Odometry
from seater_sim.settings import NANOSECONDS

CONFIG = Path(__file__).resolve().parents[3] / "config"
RUNS = 200  # a quarter of them always, all with `./seater test --all`; the bounds are those of the number
SEEDS = range(1000, 1000 + RUNS)  # means over other seeds: docs/results/controller.md
STEP = 0.04  # [s] between two odometry messages
STAND = 0.8  # [s] before and after driving
SPEED = 0.45  # [m/s] mean
BLIND_SHARE = 0.5  # of the runs
# Slices: share of the time driven; besides, 0.4 s and 0.8 s after the chair has come to rest, and end of the blind
# stretch.
SHARES = np.linspace(0.0, 1.0, 14)
RESTING = len(SHARES) + 1  # the later one of those at rest


@dataclass(frozen=True)
class Approach:
    """One run, prepared: true poses and motions at every step, and when images are taken and arrive."""

    poses: np.ndarray  # (n, 3) base_link in the dock's frame
    motions: np.ndarray  # (n - 1, 2) way and turn of each step
    images: list[tuple[float, float]]  # (arrival, stamp), in the order of arrival
    slices: np.ndarray  # indices into poses


def smooth_way(start: np.ndarray, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """A cubic from the start to the dock, standing at both ends; poses by exact arcs."""
    length = math.hypot(start[0], start[1])
    steps = math.ceil(length / speed / STEP)
    u = np.linspace(0.0, 1.0, steps + 1)
    u = (u**2 * (3.0 - 2.0 * u))[:, None]
    tangent, p = 1.2 * length * np.array([math.cos(start[2]), math.sin(start[2])]), start[:2]
    end = np.array([1.2 * length, 0.0])
    points = (2 * u**3 - 3 * u**2 + 1) * p + (u**3 - 2 * u**2 + u) * tangent + (u**3 - u**2) * end
    slopes = (6 * u**2 - 6 * u) * p + (3 * u**2 - 4 * u + 1) * tangent + (3 * u**2 - 2 * u) * end
    ways = np.hypot(*np.diff(points, axis=0).T)
    turns = np.diff(np.unwrap(np.arctan2(slopes[:, 1], slopes[:, 0])))
    rest = np.zeros((round(STAND / STEP), 2))
    motions = np.concatenate([rest, np.stack([ways, turns], axis=1), rest])
    poses = [start]
    for way, turn in motions:
        poses.append(arc_step(poses[-1], way, turn, 1.0))
    return np.array(poses), motions


def draw_approach(setup: Setup, sensor: DockSensor, rng: np.random.Generator) -> Approach:
    start = np.array(
        draw_start(setup.chair, setup.dock, sensor, lambda at: clearance(setup.chair, setup.dock.bay, at), rng)
    )
    poses, motions = smooth_way(start, SPEED)
    driving = (len(motions) - 2 * round(STAND / STEP)) * STEP
    blind_from = STAND + driving * rng.uniform(0.3, 0.6)
    blind_to = blind_from + (rng.uniform(0.3, 1.0) if rng.random() < BLIND_SHARE else 0.0)
    stamps = np.arange(0.02, len(motions) * STEP - 0.1, 1.0 / rng.uniform(10.0, 30.0))
    stamps = stamps[(stamps < blind_from) | (stamps > blind_to)]
    latency = setup.simulator.camera.latency + 0.15 * (rng.random(len(stamps)) < 0.1)  # the one or other is overtaken
    slices = [*(STAND + driving * SHARES), STAND + driving + 0.4, STAND + driving + 0.76, blind_to, blind_to + 0.2]
    images = sorted(zip((stamps + latency).tolist(), stamps.tolist(), strict=True))
    return Approach(poses, motions, images, np.round(np.array(slices) / STEP).astype(int))


def nees(setup: Setup, sensor: DockSensor, parameters: ObserverParameters, seed: int, bias: bool) -> np.ndarray:
    """e' P^-1 e at the slices of one run. `bias`: the markers stand where calibration may leave them."""
    rng = np.random.default_rng([5, seed])
    run = draw_approach(setup, sensor, rng)
    sd = [parameters.calibration_position, parameters.calibration_position, parameters.calibration_heading]
    T_dock_seen = rng.standard_normal(3) * sd if bias else np.zeros(3)
    wheels = Odometry(setup.simulator.odometry, seed)
    observer = DockObserver(setup.chair.camera, parameters)
    images, values = iter(run.images), {}
    arrival, stamp = next(images)
    for k, (way, turn) in enumerate(run.motions, start=1):
        now, period = k * STEP, round(STEP * NANOSECONDS)
        sample = wheels.update(way, turn, period, k * period)
        observer.add_odometry(OdometryMessage(now, sample.pose, sample.v, sample.omega))
        while arrival <= now:
            before = math.floor(stamp / STEP)
            at = arc_step(run.poses[before], *run.motions[before], stamp / STEP - before)
            observer.add_detections(stamp, sensor.measure(compose(inverse(T_dock_seen), at), rng))
            arrival, stamp = next(images, (math.inf, 0.0))
        if k in run.slices:
            estimate = observer.estimate(now)
            assert estimate is not None
            error = difference(estimate.pose, compose(sample.pose, inverse(run.poses[k])))
            values[k] = error @ np.linalg.solve(estimate.covariance, error)
    assert observer.images.counts[Outcome.REACQUIRED] == 0, "started again, which would hide how wrong it was"
    return np.array([values[k] for k in run.slices])


def bounds(confidence: float, runs: int) -> tuple[float, float]:
    """Of the mean NEES over the runs."""
    low, high = chi2.interval(confidence, 3 * runs)
    return low / runs, high / runs


def mean_errors(setup: Setup, sensor: DockSensor, parameters: ObserverParameters, runs: int, bias: bool) -> np.ndarray:
    values = [nees(setup, sensor, parameters, seed, bias) for seed in SEEDS[:runs]]
    means = np.mean(values, axis=0)
    print("mean NEES", means.round(2), "95 %", np.round(bounds(0.95, runs), 2))
    return means


@pytest.fixture(scope="module")
def setup() -> Setup:
    return load_setup(CONFIG)


@pytest.fixture(scope="module")
def sensor(setup: Setup) -> DockSensor:
    return DockSensor(setup.chair, setup.dock, setup.camera)


def assert_within(means: np.ndarray, confidence: float, share: float, runs: int) -> None:
    """At least `share` of the slices within the bounds."""
    low, high = bounds(confidence, runs)
    assert np.mean((means > low) & (means < high)) >= share, f"{means.round(2)} outside [{low:.2f}, {high:.2f}]"


def test_ways_end_at_the_dock(setup: Setup, sensor: DockSensor) -> None:
    ends = [draw_approach(setup, sensor, np.random.default_rng([5, seed])).poses[-1] for seed in SEEDS[:20]]
    assert all(math.hypot(x, y) < 0.02 and abs(wrap_angle(heading)) < 0.02 for x, y, heading in ends)


@pytest.mark.parametrize("runs", [RUNS // 4, pytest.param(RUNS, marks=pytest.mark.extensive)])
def test_nees_of_many_approaches(setup: Setup, sensor: DockSensor, runs: int) -> None:
    """Markers exactly where docks/default.yaml says, as in the simulator, so there is nothing left by calibration."""
    parameters = replace(setup.parameters.observer, calibration_position=0.0, calibration_heading=0.0)
    means = mean_errors(setup, sensor, parameters, runs, bias=False)
    assert_within(means, 0.95, 0.95, runs)
    assert_within(means, 0.999, 1.0, runs)


@pytest.mark.extensive  # of the harness itself
def test_a_wrong_covariance_is_noticed(setup: Setup, sensor: DockSensor) -> None:
    """Constant scale errors left out of the filter, or calibration errors counted where there are none."""
    exact = replace(setup.parameters.observer, calibration_position=0.0, calibration_heading=0.0)
    fixed = replace(exact, scale_sd=0.0, heading_scale_sd=0.0, heading_drift_sd=0.0)
    for wrong in (fixed, setup.parameters.observer):
        with pytest.raises(AssertionError, match=r"outside|started again"):
            assert_within(mean_errors(setup, sensor, wrong, 20, bias=False), 0.999, 1.0, 20)


@pytest.mark.parametrize("runs", [20, pytest.param(50, marks=pytest.mark.extensive)])
def test_nees_with_what_calibration_leaves(setup: Setup, sensor: DockSensor, runs: int) -> None:
    """The parameters of controller.yaml as they are; in each run the markers are displaced as these say.

    The displacement is the same in all slices of a run, so they are in or out of their bounds nearly together: the last
    one is judged by the 95 % bounds, all by the 99.9 % bounds.
    """
    means = mean_errors(setup, sensor, setup.parameters.observer, runs, bias=True)
    assert_within(means[RESTING : RESTING + 1], 0.95, 1.0, runs)
    assert_within(means, 0.999, 1.0, runs)
