"""What is to be judged, made from the files of config/ once in each process."""

from __future__ import annotations

import dataclasses
import functools
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, load_file
from seater_nmpc.control.controller import DockingController
from seater_nmpc.parameters import ControlParameters, NmpcParameters, Prediction
from seater_nmpc.plan.navigator import Navigator


@dataclass(frozen=True)
class Files:
    """Chair, dock and controller of a folder like config/."""

    chair: Chair
    dock: Dock
    parameters: NmpcParameters


@functools.lru_cache(maxsize=4)
def load_files(config: str, markers: int = 0) -> Files:
    """`markers`: so many of the dock's, the first ones; 0: all. Only a dock that is entered forward is judged.

    Raises ParameterError, naming file and key.
    """
    folder = Path(config)
    dock = load_file(Dock, folder / "docks" / "default.yaml")
    if dock.direction != "forward":
        raise ParameterError(f"{config}/docks/default.yaml: direction: is {dock.direction!r}, must be 'forward' here")
    if markers:
        dock = dataclasses.replace(dock, markers=dock.markers[:markers])
    parameters = load_file(NmpcParameters, folder / "controller.yaml")
    return Files(load_file(Chair, folder / "chair.yaml"), dock, parameters)


class Kept:
    """Controllers and navigators, which take a second to make, for later runs of this process with the same parts."""

    def __init__(self, files: Files, camera: CameraModel | None = None) -> None:
        self._files, self._camera = files, camera
        self._controllers: dict[ControlParameters, DockingController] = {}
        self._navigators: dict[NmpcParameters, Navigator] = {}

    def controller(self, control: ControlParameters) -> DockingController:
        """As at the start of a program."""
        if control not in self._controllers:
            self._controllers.clear()  # most runs are told something else: one is enough
            made = DockingController(
                self._files.chair, self._files.dock, control, deterministic=True, camera=self._camera
            )
            made.warm_up()
            self._controllers[control] = made
        controller = self._controllers[control]
        controller.forget_chair()
        controller.pace.limit()
        controller.set_obstacles([])
        return controller

    def navigator(self, parameters: NmpcParameters) -> Navigator:
        """Its search does not depend on the prediction."""
        control = dataclasses.replace(parameters.control, prediction=Prediction())
        key = NmpcParameters(control=control, planner=parameters.planner)
        if key not in self._navigators:
            made = Navigator(self._files.chair, self._files.dock, control, parameters.planner, self._camera)
            made.prepare()
            self._navigators[key] = made
        return self._navigators[key]


@functools.lru_cache(maxsize=4)
def kept(config: str, markers: int = 0, view: float = 0.0) -> Kept:
    """That of this process for these files. `view`: of the camera, as its camera_info tells [rad]; 0: not known."""
    return Kept(load_files(config, markers), pinhole(view) if view > 0.0 else None)


def pinhole(view: float) -> CameraModel:
    """A camera without distortion of this horizontal field of view [rad], 1280 by 800 pixels."""
    width, height = 1280, 800
    focal_length = 0.5 * width / math.tan(0.5 * view)
    K = np.array([[focal_length, 0.0, 0.5 * (width - 1)], [0.0, focal_length, 0.5 * (height - 1)], [0.0, 0.0, 1.0]])
    P = np.column_stack([K, np.zeros(3)])
    return CameraModel(width, height, "plumb_bob", np.zeros(5), K, np.eye(3), P)
