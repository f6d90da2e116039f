"""The configuration of one case: the files of config/ with the changes of its variants laid over them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, load, read_yaml
from seater_eval.campaign.setup.campaign_file import Start
from seater_eval.campaign.setup.changes import merged
from seater_nmpc.parameters import NmpcParameters
from seater_sim.settings import SimulatorSettings

_DEFAULTS = {
    "chair": "chair.yaml",
    "dock": "docks/default.yaml",
    "camera": "cameras/d455.yaml",
    "simulator": "simulator.yaml",
    "controller": "controller.yaml",
    "perception": "perception.yaml",
    "safety": "safety.yaml",
}
_FOLDERS = {"dock": "docks/", "camera": "cameras/"}  # of the files that a variant names; others stand in config/ itself


@dataclass(frozen=True)
class Files:
    """Contents of the YAML files below config/, by their path there. Sent with a job, so that it runs anywhere."""

    contents: dict[str, Any]

    @classmethod
    def read(cls, config: Path) -> Files:
        """Raises ParameterError for a file that is no YAML."""
        return cls({path.relative_to(config).as_posix(): read_yaml(path) for path in sorted(config.rglob("*.yaml"))})

    def get(self, name: str, key: str) -> Any:
        """`key` asks for it, in the message of the ParameterError when there is none."""
        if name not in self.contents:
            raise ParameterError(f"{key}: is {name!r}, and there is no such file in the configuration folder")
        return self.contents[name]


@dataclass(frozen=True)
class Configuration:
    """Everything that a docking depends on but the seed and where it starts. `chair`, `dock` and `camera` are what the
    controller, perception and gate are told; the simulated ones may differ."""

    chair: Chair
    dock: Dock
    simulated_chair: Chair
    simulated_dock: Dock
    parameters: NmpcParameters
    simulator: SimulatorSettings
    camera: CameraModel
    simulated_camera: CameraModel
    perception: dict[str, Any]  # config/perception.yaml, for the library
    dock_values: dict[str, Any]  # the dock's file, for the library
    mount_values: dict[str, Any]  # `camera` of the chair's file, for the library
    safety: dict[str, float]
    start: Start


def configuration(files: Files, start: Mapping[str, Any], changes: Sequence[Mapping[str, Any]]) -> Configuration:
    """With the changes of all variants, in their order. Raises ParameterError, naming every wrong key."""
    values = {name: _base(files, name, file, changes) for name, file in _DEFAULTS.items()}
    values["start"] = dict(start)
    for change in changes:
        for section in values:
            if section in change:
                values[section] = merged(values[section], change[section])
    for section in ("chair", "dock"):
        values[f"simulated_{section}"] = values[section]
        for change in changes:
            values[f"simulated_{section}"] = merged(
                values[f"simulated_{section}"], change.get(f"simulated_{section}", {})
            )
    camera = CameraModel.from_mapping(values["camera"])
    return Configuration(
        chair=load(Chair, values["chair"], "chair"),
        dock=load(Dock, values["dock"], "dock"),
        simulated_chair=load(Chair, values["simulated_chair"], "simulated_chair"),
        simulated_dock=load(Dock, values["simulated_dock"], "simulated_dock"),
        parameters=load(NmpcParameters, values["controller"], "controller"),
        simulator=load(SimulatorSettings, values["simulator"], "simulator"),
        camera=camera,
        simulated_camera=camera,
        perception=values["perception"],
        dock_values=values["dock"],
        mount_values=values["chair"]["camera"],
        safety=values["safety"],
        start=load(Start, values["start"], "start"),
    )


def _base(files: Files, section: str, default: str, changes: Sequence[Mapping[str, Any]]) -> Any:
    """The file of a section: the last one that a variant names, else the default."""
    key = f"{section}_file"
    named = [change[key] for change in changes if key in change]
    return files.get(_FOLDERS.get(section, "") + str(named[-1]) if named else default, key)
