"""Somebody drives the simulated chair in front of the dock, by the eye: what the odometry and the camera make of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Limits
from seater_common.se2 import wrap_angle
from seater_sim.chair.make import make_plant
from seater_sim.settings import SimulatorSettings, to_ns

Array = NDArray[np.float64]

START = (-2.4, 0.0, 0.0)  # in the dock frame
PERIOD = 0.02  # [s] between two commands
PAUSE = 1.0  # [s] standing between two moves
LONGEST = 120.0  # [s] of the whole drive
SPEED, RATE = 0.25, 0.35  # [m/s], [rad/s]


@dataclass(frozen=True)
class To:
    """Drive along the dock's axis to x [m], forward or backward, steering towards y [m]."""

    x: float
    y: float = 0.0


@dataclass(frozen=True)
class Face:
    """Turn on the spot to a heading [rad]."""

    heading: float


Script = tuple[To | Face, ...]

# There and back twice, a turn to both sides at three distances: what docs/how-to/calibrate_the_mount.md asks for.
SCRIPT: Script = (
    To(-0.5),
    To(-1.8),
    *(Face(math.radians(angle)) for angle in (30.0, -30.0, 0.0)),
    To(-0.5),
    To(-1.1),
    *(Face(math.radians(angle)) for angle in (25.0, -25.0, 0.0)),
    To(-0.5),
    To(-1.8),
    *(Face(math.radians(angle)) for angle in (-30.0, 30.0, 0.0)),
    To(-0.5),
    To(-2.4),
)


@dataclass(frozen=True)
class Frame:
    """Where the chair truly was when an image was taken, and how fast."""

    stamp: float
    pose: Array
    v: float
    omega: float


def drive_chair(
    simulator: SimulatorSettings,
    limits: Limits,
    seed: int,
    image: Callable[[Frame], None],
    odometry: Callable[[float, Array], None],
    script: Script = SCRIPT,
    image_period: float = 0.1,
) -> None:
    """Calls back for each image and each odometry message, in the order of time. Same arguments, same drive."""
    plant, wheels = make_plant(simulator.plant, simulator.odometry, limits, START, seed)
    step, period = to_ns(simulator.step), to_ns(simulator.odometry.period)
    due = {"odometry": 0, "image": 0, "command": 0}
    way = turn = 0.0
    commands = commands_by_eye(script, lambda: plant.pose)
    while plant.time_ns < to_ns(LONGEST):
        now_ns, now = plant.time_ns, plant.time_ns / 1e9
        if now_ns >= due["odometry"]:
            odometry(now, wheels.update(way, turn, period, now_ns).pose)
            way = turn = 0.0
            due["odometry"] += period
        if now_ns >= due["image"]:
            image(Frame(now, plant.pose.copy(), plant.v, plant.omega))
            due["image"] += to_ns(image_period)
        if now_ns >= due["command"]:
            wanted = next(commands, None)
            if wanted is None:
                return
            plant.command(*wanted)
            due["command"] += to_ns(PERIOD)
        plant.step(step)
        way, turn = way + plant.motion.way, turn + plant.motion.turn


def commands_by_eye(script: Script, pose: Callable[[], Array]) -> Iterator[tuple[float, float]]:
    """One for each PERIOD, from where the chair truly is; ends after the last move."""
    for move in script:
        yield from _driven(move, pose) if isinstance(move, To) else _turned(move, pose)
        for _ in range(round(PAUSE / PERIOD)):
            yield 0.0, 0.0


def _driven(move: To, pose: Callable[[], Array]) -> Iterator[tuple[float, float]]:
    way = math.copysign(1.0, move.x - pose()[0])
    while (left := way * (move.x - pose()[0])) > 0.02:
        _, y, heading = pose()
        steer = -1.0 * heading - 0.8 * way * (y - move.y)
        yield way * min(SPEED, 0.06 + 0.8 * left), max(-0.2, min(0.2, steer))


def _turned(move: Face, pose: Callable[[], Array]) -> Iterator[tuple[float, float]]:
    while abs(left := wrap_angle(move.heading - float(pose()[2]))) > 0.03:
        yield 0.0, math.copysign(min(RATE, 0.1 + abs(left)), left)
