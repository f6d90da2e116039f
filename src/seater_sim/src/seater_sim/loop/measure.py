"""How long an image takes to render, and a step without images.

rosrun seater_sim measure_rendering CAMERA_INFO.yaml [IMAGES per case]
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import cv2
import numpy as np
from tabulate import tabulate

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_sim.camera.camera import Camera
from seater_sim.loop.simulator import Simulator
from seater_sim.settings import KINEMATIC, WHEELCHAIR, CameraSettings, PlantSettings, SimulatorSettings

# Where the chair is (x [m], y [m], heading [rad]) and how it moves (v [m/s], omega [rad/s]).
CASES = [
    ("standing far", (-2.5, 0.0, 0.0), 0.0, 0.0),
    ("driving", (-1.5, 0.0, 0.0), 0.3, 0.0),
    ("driving and turning", (-1.5, 0.6, -0.3), 0.3, 0.2),
    ("turning fast", (-1.5, 0.6, -0.3), 0.0, 0.8),
    ("in the bay", (-0.3, 0.0, 0.0), 0.1, 0.0),
    ("docked", (0.0, 0.0, 0.0), 0.0, 0.0),
]


def main() -> int:
    """Prints a table for each encoding; one thread. Raises ParameterError: the camera's file cannot be used."""
    parser = argparse.ArgumentParser(prog="measure_rendering", description="How long an image takes to render.")
    parser.add_argument("camera", type=Path, metavar="CAMERA_INFO.yaml", help="a file like config/cameras/d455.yaml")
    parser.add_argument("images", type=int, nargs="?", default=50, help="of each case (50)")
    options = parser.parse_args()
    if options.images < 1:
        parser.error(f"IMAGES: is {options.images}, must be at least 1")
    cv2.setNumThreads(1)
    images, model = options.images, CameraModel.load(options.camera)
    for encoding in ("mono8", "rgb8"):
        camera = Camera(model, Chair().camera, Dock(), CameraSettings(encoding=encoding))
        rows = []
        for name, pose, v, omega in CASES:
            camera.render(pose, v, omega)  # fills the caches
            times = []
            for index in range(images):
                begin = time.perf_counter()
                camera.render(pose, v, omega, index=index)
                times.append(1e3 * (time.perf_counter() - begin))
            rows.append([name, *np.quantile(times, [0.5, 0.95])])
        print(f"{model.width} x {model.height} {encoding}, ms per image")
        print(tabulate(rows, ["", "median", "95 %"], floatfmt=".1f"))
    for kind in (KINEMATIC, WHEELCHAIR):
        print(f"step of 10 ms without images, plant {kind}: {_step_us(kind):.0f} us on average over 20 s of driving")
    return 0


def _step_us(kind: str) -> float:
    settings = SimulatorSettings(plant=PlantSettings(kind))
    simulator = Simulator(settings, Chair(), Dock(), None, (-2.5, 0.0, 0.0))
    begin = time.perf_counter()
    for _ in range(2000):
        simulator.command(0.1, 0.0)
        simulator.step()
    return (time.perf_counter() - begin) / 2000 * 1e6
