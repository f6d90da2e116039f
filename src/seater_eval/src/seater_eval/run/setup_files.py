"""Everything that the evaluation reads from config/, at once."""

from __future__ import annotations

import dataclasses
import logging
from dataclasses import dataclass
from pathlib import Path

import seater_perception as sp
from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, load_file, read_yaml
from seater_nmpc.checks.setup import check_setup
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.sequence.vehicle import Vehicle
from seater_sim.settings import SimulatorSettings


@dataclass(frozen=True)
class Setup:
    """Chair, dock, controller, simulator and camera of config/."""

    chair: Chair
    dock: Dock
    parameters: NmpcParameters
    simulator: SimulatorSettings
    camera: CameraModel


@dataclass(frozen=True)
class SetupFiles:
    """Where each part of a set-up is read from."""

    chair: Path
    dock: Path
    controller: Path
    simulator: Path
    camera: Path
    perception: Path

    @classmethod
    def of(cls, config: str | Path) -> SetupFiles:
        """The default ones in a folder like config/."""
        folder = Path(config)
        names = {"dock": "docks/default.yaml", "camera": "cameras/d455.yaml"}
        return cls(**{key: folder / names.get(key, f"{key}.yaml") for key in cls.__dataclass_fields__})

    def paths(self) -> dict[str, Path]:
        """By what they hold: chair, dock, ..."""
        return dataclasses.asdict(self)

    def checked(self) -> dict[str, Path]:
        """Those behind the checks across files, by the name that these give them."""
        return {"chair": self.chair, "dock": self.dock, "controller": self.controller, "camera": self.camera}


def load_setup(config: str | Path) -> Setup:
    """From the folder of seater_config, made to fit together (see check_setup); warnings go to the log.

    Raises ParameterError, naming file and key; the evaluation docks forward only.
    """
    files = SetupFiles.of(config)
    setup, warnings = load_files(files)
    if setup.dock.direction != "forward":
        raise ParameterError(f"{files.dock}: direction: is {setup.dock.direction!r}, must be 'forward' here")
    for text in warnings:
        logging.getLogger(__name__).warning(text)
    return setup


def load_files(files: SetupFiles) -> tuple[Setup, list[str]]:
    """The set-up, its parameters adjusted to chair and dock, and warnings about that.

    Raises:
        ParameterError: a file cannot be read, a key is wrong, or they do not fit together; names file and keys.
    """
    chair, dock = load_file(Chair, files.chair), load_file(Dock, files.dock)
    parameters = load_file(NmpcParameters, files.controller)
    simulator = load_file(SimulatorSettings, files.simulator)
    camera = CameraModel.load(files.camera)
    _check_perception(files, camera)
    try:
        driven = Vehicle(chair, dock).chair
    except ValueError as error:
        raise ParameterError(f"{files.chair}: {error}") from error
    parameters, warnings = check_setup(driven, dock, parameters, camera, files.checked())
    return Setup(chair, dock, parameters, simulator, camera), warnings


def _check_perception(files: SetupFiles, camera: CameraModel) -> None:
    """By the perception library itself, as the nodelet does when it starts."""
    K, D, P = ([float(value) for value in matrix.ravel()] for matrix in (camera.K, camera.D, camera.P))
    values = read_yaml(files.perception)
    if not isinstance(values, dict):
        raise ParameterError(f"{files.perception}: must be a mapping like config/perception.yaml")
    try:
        layout = sp.load_dock_layout(read_yaml(files.dock))
        raw = sp.CameraModel.raw(sp.Calibration(camera.width, camera.height, K, D, camera.distortion_model, P))
        sp.DockDetector(raw, layout, values)
    except ValueError as error:  # the library's own errors
        raise ParameterError(f"{files.perception}, with {files.dock} and {files.camera}: {error}") from error
