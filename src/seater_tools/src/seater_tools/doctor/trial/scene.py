"""An installation as it is and as its files have it; a fault edits it before it is watched."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import CameraMount, Chair, Dock
from seater_common.params import load, read_yaml
from seater_sim.chair.plant_ranges import load_plant_ranges
from seater_sim.settings import SimulatorSettings
from seater_tools.doctor.gather.machine import look_at_files
from seater_tools.doctor.observations import Live, Machine, Traffic
from seater_tools.doctor.setup import FileSeen
from seater_tools.trial.truth import Errors, draw_installation

Array = NDArray[np.float64]

IMAGES_PER_SECOND = 10.0
# What is left of a good installation: measured with a tape and a spirit level, or calibrated.
GOOD = Errors(place=0.0015, turn=0.01, lean=0.0, size=0.003, mount=0.004, mount_turn=0.004)
FILES = {
    "chair": "chair.yaml",
    "dock": "docks/default.yaml",
    "camera": "cameras/d455.yaml",
    "controller": "controller.yaml",
    "perception": "perception.yaml",
    "safety": "safety.yaml",
}
SENDERS = {
    "image": "/camera", "camera_info": "/camera", "odom": "/base", "detections": "/marker_detector",
    "gate_state": "/safety_gate", "cmd_vel": "/safety_gate", "velocity_request": "/docking",
    "user_cmd_vel": "/joystick", "emergency_stop": "/button", "charging_contact": "/charger",
}  # fmt: skip


@dataclass
class Tamper:
    """What becomes of messages and commands on their way; each takes and gives one, None: it is lost."""

    odometry: Callable[[Array], Array | None] = lambda row: row  # stamp, pose, twist (6,)
    image_stamp: Callable[[float], float] = lambda stamp: stamp
    image: Callable[[NDArray[np.uint8]], NDArray[np.uint8] | None] = lambda image: image
    command: Callable[[float, float], tuple[float, float]] = lambda v, omega: (v, omega)
    joystick: Callable[[np.random.Generator], tuple[float, float]] = lambda rng: (0.0, 0.0)
    contact: Callable[[bool], bool] = lambda closed: closed
    gate: Callable[[Any, float], object] = lambda gate, now: None  # at the start: what is done to the gate


@dataclass
class Scene:
    """`files`: what everybody is told, in `told` what the running nodes have. The rest is how things are."""

    seed: int
    files: dict[str, FileSeen]
    chair: Chair
    dock: Dock
    camera: CameraModel
    simulator: SimulatorSettings
    start: Array
    told: dict[str, Any] = field(default_factory=dict)
    info: dict[str, Any] = field(default_factory=dict)  # what camera_info says, as the mapping of a file
    T_base_optical: Array | None = None  # by TF
    machine: Machine = field(default_factory=Machine)
    live: Live = field(default_factory=lambda: Live(duration=0.0))
    traffic: dict[str, Traffic] = field(default_factory=dict)
    tamper: Tamper = field(default_factory=Tamper)
    drive: bool = False  # whether --move is given

    def edit(self, role: str, change: Callable[[Any], object]) -> None:
        """Change the values of a file, and of what the nodes were told of it."""
        for values in (self.files[role].values, self.told[role]):
            change(values)


def draw_scene(config: Path, seed: int) -> Scene:
    """A good installation: another chair, start, camera and dock for each seed, within what measuring leaves.

    Raises ParameterError: a file of `config` is not in order.
    """
    rng = np.random.default_rng([seed, 14])
    files = look_at_files({role: config / name for role, name in FILES.items()})
    base = load(SimulatorSettings, read_yaml(config / "simulator.yaml"), "simulator.yaml")
    simulator = load_plant_ranges(config / "plants" / "indoor_chair.yaml").draw_simulator(rng, base)
    simulator = dataclasses.replace(simulator, camera=dataclasses.replace(simulator.camera, rate=IMAGES_PER_SECOND))
    chair, dock = load(Chair, files["chair"].values, "chair"), load(Dock, files["dock"].values, "dock")
    truth = draw_installation(chair.camera, dock, GOOD, rng)
    start = np.array([rng.uniform(-1.04, -0.94), rng.uniform(-0.08, 0.08), rng.uniform(-0.05, 0.05)])
    return Scene(
        seed=seed,
        files=files,
        chair=dataclasses.replace(chair, camera=truth.mount),
        dock=truth.dock,
        camera=CameraModel.from_mapping(files["camera"].values, "camera"),
        simulator=simulator,
        start=start,
        told={role: copy.deepcopy(file.values) for role, file in files.items()},
        info=copy.deepcopy(files["camera"].values),
        T_base_optical=chair.camera.T_base_optical(),
        machine=Machine(folder="log", free=50e9, busy=float(rng.uniform(0.2, 0.7))),
        traffic={role: Traffic(f"/{role}", (node,), ("/someone",)) for role, node in SENDERS.items()},
    )


def move_camera(scene: Scene, **changes: float) -> None:
    """The camera sits elsewhere than the files say, by so much [m], [rad]."""
    mount = scene.chair.camera
    moved = {name: getattr(mount, name) + change for name, change in changes.items()}
    values = {f.name: getattr(mount, f.name) for f in dataclasses.fields(CameraMount)} | moved
    scene.chair = dataclasses.replace(scene.chair, camera=CameraMount(**values))


def change_marker(scene: Scene, id: int, **changes: Any) -> None:
    """A print that is not what the file says."""
    markers = [dataclasses.replace(m, **changes) if m.id == id else m for m in scene.dock.markers]
    scene.dock = dataclasses.replace(scene.dock, markers=markers)
