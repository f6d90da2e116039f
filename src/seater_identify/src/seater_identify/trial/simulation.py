"""The scripted drive on a simulated chair, without ROS: seater_sim's plant and odometry, dock poses with noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair
from seater_identify.drive.driver import Driver, DriveState
from seater_identify.record.recording import Recording
from seater_identify.settings import IdentifySettings
from seater_sim.chair.make import make_plant
from seater_sim.settings import SimulatorSettings, to_ns

Array = NDArray[np.float64]

START = (-2.2, 0.0, 0.0)  # in the dock frame: the markers are in view on the whole straight
LONGEST = 200.0  # [s] after which a drive that does not end is broken off


@dataclass(frozen=True)
class Camera:
    """What the camera makes of the dock: poses of the dock in base_link, within the field of view."""

    rate: float = 15.0  # [Hz]
    position_sd: float = 0.003  # [m]
    heading_sd: float = 0.004  # [rad]
    half_view: float = 0.5  # [rad] of the dock's direction off the chair's x axis
    outliers: float = 0.02  # share of images that are 10 times as wrong as they claim


@dataclass(frozen=True)
class Drive:
    """What came of a simulated drive."""

    recording: Recording
    state: DriveState
    text: str
    truth: Array  # (n, 4) time, true pose of base_link in the dock frame


def simulate(
    settings: IdentifySettings, chair: Chair, simulator: SimulatorSettings, seed: int, camera: Camera | None
) -> Drive:
    """Drive the script. `camera` None: the dock is nowhere to be seen. Same arguments, same drive."""
    plant, odometry = make_plant(simulator.plant, simulator.odometry, chair.limits, START, seed)
    driver, rng = Driver(settings, chair), np.random.default_rng([seed, 77])
    step, due = to_ns(simulator.step), {"odometry": 0, "command": 0, "camera": 0}
    every = {"odometry": to_ns(simulator.odometry.period), "command": to_ns(settings.drive.period)}
    every["camera"] = to_ns(1.0 / camera.rate) if camera else to_ns(LONGEST)
    way = turn = 0.0
    commands: list[list[float]] = []
    odometries: list[list[float]] = []
    seen: list[tuple[list[float], Array]] = []
    truth: list[list[float]] = []
    while plant.time_ns < to_ns(LONGEST) and driver.state in (DriveState.READY, DriveState.DRIVING):
        now_ns, now = plant.time_ns, plant.time_ns / 1e9
        if now_ns >= due["odometry"]:
            sample = odometry.update(way, turn, every["odometry"], now_ns)
            way = turn = 0.0
            odometries.append([now, *sample.pose])
            truth.append([now, *plant.pose])
            driver.odometry(now, sample.pose, now)
            due["odometry"] += every["odometry"]
        if camera and now_ns >= due["camera"]:
            view = observe(camera, plant.pose, rng)
            if view is not None:
                seen.append(([now, *view[0]], view[1]))
            due["camera"] += every["camera"]
        if now_ns >= due["command"]:
            if driver.state is DriveState.READY:
                driver.start(now)
            v, omega = driver.command(now)
            commands.append([now, v, omega])
            plant.command(v, omega)
            due["command"] += every["command"]
        plant.step(step)
        way, turn = way + plant.motion.way, turn + plant.motion.turn
    dock = np.array([row for row, _ in seen]).reshape(-1, 4)
    covariance = np.array([matrix for _, matrix in seen]).reshape(-1, 3, 3)
    recording = Recording(np.array(commands), np.array(odometries), dock, covariance)
    return Drive(recording, driver.state, driver.text, np.array(truth))


def observe(camera: Camera, pose: Array, rng: np.random.Generator) -> tuple[Array, Array] | None:
    """(pose of the dock in base_link (3,), covariance (3, 3)), or None when it is out of view. `pose`: of base_link."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    dock = np.array([-c * pose[0] - s * pose[1], s * pose[0] - c * pose[1], -pose[2]])
    noise, outlier = rng.standard_normal(3), rng.random() < camera.outliers
    marker = dock[:2] + 0.9 * np.array([np.cos(dock[2]), np.sin(dock[2])])
    if marker[0] < 0.3 or abs(np.arctan2(marker[1], marker[0])) > camera.half_view:
        return None
    sd = np.array([camera.position_sd, camera.position_sd, camera.heading_sd])
    return dock + sd * noise * (10.0 if outlier else 1.0), np.diag(sd**2)
