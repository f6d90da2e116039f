"""The node's private parameters."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import rospy

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, load, param
from seater_sim.settings import Obstacle, PlanarPose, SimulatorSettings, Walker
from seater_sim.world.events import Event, load_events

PARTICIPANTS = ("detections", "input_done", "cmd_vel_stamped")
WITH_OBSTACLES = (*PARTICIPANTS, "obstacle_points")


@dataclass(frozen=True)
class CommonSettings:
    """Of every run."""

    seed: int = param(1, "", "of odometry errors and image noise", low=0)
    start: PlanarPose = field(default_factory=PlanarPose)
    publish_obstacles: bool = param(True, "", "tell the docking node what stands in the way, on `obstacles`")
    obstacles: list[Obstacle] = field(default_factory=list)  # of this run, beside those of the simulator's file
    walkers: list[Walker] = field(default_factory=list)  # the same


@dataclass(frozen=True)
class RunSettings(CommonSettings):
    """How a run in simulated time goes."""

    start_paused: bool = param(False, "", "the time stands until the service ~run")
    lock_step: bool = param(True, "", "wait for the answers of perception and controller")
    rate: float = param(0.0, "", "limit of simulated over wall time; 0: none", low=0.0, high=1000.0)
    participants: list[str] = param(
        list(PARTICIPANTS),
        "",
        "topics whose publishers must be connected before the first step",
        choices=WITH_OBSTACLES,
    )
    answer_timeout: float = param(20.0, "s", "wall time after which a missing answer is given up", low=0.1, high=3600.0)


@dataclass(frozen=True)
class World:
    """What there is, as the parameter server has it."""

    chair: Chair = field(default_factory=Chair)  # the one that is there
    told_chair: Chair = field(default_factory=Chair)  # what the other nodes take it for: the camera's transform
    dock: Dock = field(default_factory=Dock)
    simulator: SimulatorSettings = field(default_factory=SimulatorSettings)
    camera: CameraModel | None = None


@dataclass(frozen=True)
class FreeOptions(World, CommonSettings):
    """All that a node which runs freely on the clock on the wall was given."""


@dataclass(frozen=True)
class Options(World, RunSettings):
    """All that the node in simulated time was given."""

    events: list[Event] = field(default_factory=list)


# These few may be left out; everything else is required.
OPTIONAL: dict[str, Any] = {
    "participants": list(PARTICIPANTS),
    "answer_timeout": 20.0,
    "publish_obstacles": True,
    "obstacles": [],
    "walkers": [],
}


def load_options() -> Options:
    """From the parameter server.

    Raises:
        ParameterError: naming full key, value and what is allowed.
    """
    run, world = _load(RunSettings)
    ids = [marker.id for marker in world["dock"].markers]
    events = load_events(rospy.get_param("~events", []), f"{rospy.get_name()}/events", ids)
    return Options(**run, **world, events=events)


def load_free_options() -> FreeOptions:
    """From the parameter server. Raises ParameterError as `load_options` does."""
    run, world = _load(CommonSettings)
    return FreeOptions(**run, **world)


def _load(kind: type[CommonSettings]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The fields of `kind`, and those of World."""
    prefix, given = rospy.get_name(), rospy.get_param("~", {})
    wanted = kind.__dataclass_fields__
    optional = {name: value for name, value in OPTIONAL.items() if name in wanted}
    run = load(kind, optional | {name: given[name] for name in wanted if name in given}, prefix)
    chair = load(Chair, _required("chair"), f"{prefix}/chair")
    simulator = load(SimulatorSettings, _required("simulator"), f"{prefix}/simulator")
    return run.__dict__, {
        "dock": load(Dock, _required("dock"), f"{prefix}/dock"),
        "chair": chair,
        "told_chair": load(Chair, given["told_chair"], f"{prefix}/told_chair") if "told_chair" in given else chair,
        "simulator": replace(
            simulator,
            obstacles=[*simulator.obstacles, *run.obstacles],
            walkers=[*simulator.walkers, *run.walkers],
        ),
        "camera": CameraModel.from_mapping(_required("camera"), f"{prefix}/camera"),
    }


def _required(name: str) -> Any:
    try:
        return rospy.get_param("~" + name)
    except KeyError:
        raise ParameterError(f"{rospy.resolve_name('~' + name)}: is missing") from None
