"""A drive at the hidden installation, recorded as record.launch does it while perception runs."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

import seater_perception as sp
from seater_common.camera_model import CameraModel
from seater_sim.loop.simulator import Simulator
from seater_tools.commissioning.hidden import Hidden
from seater_tools.commissioning.pilots import Pilot
from seater_tools.ros.bag_writer import BagWriter
from seater_tools.trial.drive import PERIOD

Array = NDArray[np.float64]

RATE = 8.0  # [Hz] of images at most: the fewest that the doctor accepts, as on a slow computer


def record(
    hidden: Hidden,
    tracker: sp.DockTracker,
    told: CameraModel,
    pilot: Pilot,
    start: ArrayLike,
    bag: Path,
    *,
    drive: int,
    longest: float,
    stands: float = 0.0,
) -> tuple[float, Array]:
    """Duration [s] and true pose (3,) at the end.

    Args:
        tracker, told: perception, and the lens of camera_info, as the files have them.
        start: base_link in the true dock frame.
        drive: number of the drive: each meets other patches of floor and other noise.
        longest: [s] after which it is broken off.
        stands: [s] for which the chair stands at the end, still recorded.

    Raises ValueError: the start overlaps a wall.
    """
    camera = dataclasses.replace(hidden.simulator.camera, rate=min(RATE, hidden.simulator.camera.rate))
    settings = dataclasses.replace(hidden.simulator, camera=camera)
    seed = 1_000_003 * drive + hidden.seed
    simulator = Simulator(settings, hidden.chair, hidden.dock, hidden.lens, start, seed=seed)
    begin, due = simulator.time_ns, 0.0
    with BagWriter(bag) as writer:
        writer.camera_info(begin, told)
        writer.odometry(begin, simulator.first_odometry())
        while (elapsed := (simulator.time_ns - begin) / 1e9) < longest:
            if elapsed >= due - 1e-9:
                command = pilot.command(simulator.time_ns / 1e9, simulator.truth.pose)
                if command is None:
                    break
                writer.command(simulator.time_ns, *command)
                simulator.command(*command)
                due += PERIOD
            _step(simulator, tracker, pilot, writer)
        end = simulator.time_ns + round(1e9 * stands)
        while simulator.time_ns < end:
            simulator.command(0.0, 0.0)
            _step(simulator, tracker, pilot, writer)
    return elapsed, simulator.truth.pose


def _step(simulator: Simulator, tracker: sp.DockTracker, pilot: Pilot, writer: BagWriter) -> None:
    due = simulator.step()
    if due.odometry is not None:
        sample = due.odometry
        pilot.odometry(sample.time_ns / 1e9, sample.pose, due.time_ns / 1e9)
        writer.odometry(due.time_ns, sample)
    for image in due.images:
        writer.detections(due.time_ns, image.stamp_ns, tracker.detect(np.asarray(image.render(), dtype=np.uint8)))
