"""The node's private parameters."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import rospy

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, load, param
from seater_sim.settings import Obstacle, PlanarPose, SimulatorSettings
from seater_sim.world.events import Event, load_events

PARTICIPANTS = ("detections", "input_done", "cmd_vel_stamped")


@dataclass(frozen=True)
class RunSettings:
    """How a run goes."""

    seed: int = param(1, "", "of odometry errors and image noise", low=0)
    start_paused: bool = param(False, "", "the time stands until the service ~run")
    lock_step: bool = param(True, "", "wait for the answers of perception and controller")
    rate: float = param(0.0, "", "limit of simulated over wall time; 0: none", low=0.0, high=1000.0)
    start: PlanarPose = field(default_factory=PlanarPose)
    participants: list[str] = param(
        list(PARTICIPANTS), "", "topics whose publishers must be connected before the first step", choices=PARTICIPANTS
    )
    answer_timeout: float = param(20.0, "s", "wall time after which a missing answer is given up", low=0.1, high=3600.0)
    publish_obstacles: bool = param(True, "", "tell the docking node what stands in the way, on `obstacles`")
    obstacles: list[Obstacle] = field(default_factory=list)  # of this run, beside those of the simulator's file


@dataclass(frozen=True)
class Options(RunSettings):
    """All that the node was given."""

    chair: Chair = field(default_factory=Chair)  # the one that is there
    told_chair: Chair = field(default_factory=Chair)  # what the other nodes take it for: the camera's transform
    dock: Dock = field(default_factory=Dock)
    simulator: SimulatorSettings = field(default_factory=SimulatorSettings)
    camera: CameraModel | None = None
    events: list[Event] = field(default_factory=list)


# These few may be left out; everything else is required.
OPTIONAL: dict[str, Any] = {
    "participants": list(PARTICIPANTS),
    "answer_timeout": 20.0,
    "publish_obstacles": True,
    "obstacles": [],
}


def load_options() -> Options:
    """From the parameter server.

    Raises:
        ParameterError: naming full key, value and what is allowed.
    """
    prefix = rospy.get_name()
    given = rospy.get_param("~", {})
    names = [name for name in RunSettings.__dataclass_fields__ if name in given]
    run = load(RunSettings, OPTIONAL | {name: given[name] for name in names}, prefix)
    dock = load(Dock, _required("dock"), f"{prefix}/dock")
    chair = load(Chair, _required("chair"), f"{prefix}/chair")
    simulator = load(SimulatorSettings, _required("simulator"), f"{prefix}/simulator")
    return Options(
        **run.__dict__,
        chair=chair,
        told_chair=load(Chair, given["told_chair"], f"{prefix}/told_chair") if "told_chair" in given else chair,
        dock=dock,
        simulator=replace(simulator, obstacles=[*simulator.obstacles, *run.obstacles]),
        camera=CameraModel.from_mapping(_required("camera"), f"{prefix}/camera"),
        events=load_events(rospy.get_param("~events", []), f"{prefix}/events", [m.id for m in dock.markers]),
    )


def _required(name: str) -> Any:
    try:
        return rospy.get_param("~" + name)
    except KeyError:
        raise ParameterError(f"{rospy.resolve_name('~' + name)}: is missing") from None
