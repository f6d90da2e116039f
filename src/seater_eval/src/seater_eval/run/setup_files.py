"""Everything that the evaluation reads from config/, at once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, load
from seater_eval.run.config_files import load_chair, load_dock
from seater_nmpc.parameters import NmpcParameters
from seater_sim.settings import SimulatorSettings


@dataclass(frozen=True)
class Setup:
    """Chair, dock, controller, simulator and camera of config/."""

    chair: Chair
    dock: Dock
    parameters: NmpcParameters
    simulator: SimulatorSettings
    camera: CameraModel


def load_setup(config: str | Path) -> Setup:
    """From the folder of seater_config. Raises ParameterError, naming file and key; the evaluation docks forward
    only."""
    config = Path(config)
    dock = load_dock(config / "docks" / "default.yaml")
    if dock.direction != "forward":
        raise ParameterError(f"{config}/docks/default.yaml: direction: is {dock.direction!r}, must be 'forward' here")
    return Setup(
        load_chair(config / "chair.yaml"),
        dock,
        load(NmpcParameters, _read(config / "controller.yaml"), "controller"),
        load(SimulatorSettings, _read(config / "simulator.yaml"), "simulator"),
        CameraModel.from_mapping(_read(config / "cameras" / "d455.yaml"), "d455"),
    )


def _read(path: Path) -> Any:
    try:
        return yaml.safe_load(path.read_text())
    except (OSError, yaml.YAMLError) as error:
        raise ParameterError(f"cannot read {path}: {error}") from error
