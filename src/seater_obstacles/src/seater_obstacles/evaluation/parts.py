"""Chair, dock, controller and gate of a folder like config/, made once in each process."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import seater_safety
from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import load, read_yaml
from seater_nmpc.control.controller import DockingController
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.plan.navigator import Navigator
from seater_obstacles.settings import ObstacleSettings
from seater_sim.settings import SimulatorSettings


@dataclass(frozen=True)
class Parts:
    """Of one process; controller and navigator are used by one run after another."""

    chair: Chair
    dock: Dock
    camera: CameraModel
    parameters: NmpcParameters
    obstacles: ObstacleSettings
    simulator: SimulatorSettings
    safety: dict[str, float]
    controller: DockingController
    navigator: Navigator

    def gate(self) -> Any:
        """The safety gate that the node runs."""
        return seater_safety.VelocityGate(**self.safety)


@functools.lru_cache(maxsize=1)
def load_parts(config: str) -> Parts:
    """Raises ParameterError, naming file and key."""
    folder = Path(config)
    chair = load(Chair, read_yaml(folder / "chair.yaml"), "chair")
    dock = load(Dock, read_yaml(folder / "docks" / "default.yaml"), "dock")
    camera = CameraModel.load(folder / "cameras" / "d455.yaml")
    parameters = load(NmpcParameters, read_yaml(folder / "controller.yaml"), "controller")
    controller = DockingController(chair, dock, parameters.control, deterministic=True, camera=camera)
    controller.warm_up()
    navigator = Navigator(chair, dock, parameters.control, parameters.planner, camera)
    navigator.prepare()
    return Parts(
        chair=chair,
        dock=dock,
        camera=camera,
        parameters=parameters,
        obstacles=load(ObstacleSettings, read_yaml(folder / "obstacles.yaml"), "obstacles"),
        simulator=load(SimulatorSettings, read_yaml(folder / "simulator.yaml"), "simulator"),
        safety=_safety(chair, read_yaml(folder / "safety.yaml")),
        controller=controller,
        navigator=navigator,
    )


def _safety(chair: Chair, values: dict[str, float]) -> dict[str, float]:
    """All parameters of the gate by name."""
    described = seater_safety.describe_parameters()
    limits = {e["key"]: getattr(chair.limits, e["key"]) for e in described if e["file"] == "chair/limits"}
    footprint = {e["key"]: getattr(chair, e["key"]) for e in described if e["file"] == "chair"}
    return {key: float(value) for key, value in values.items()} | limits | footprint
