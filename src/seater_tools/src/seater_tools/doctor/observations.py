"""All that the checks know. Who gathers it (a running system, the simulator) makes no difference to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_nmpc.observe.measurement import Hypothesis
from seater_tools.doctor.setup import FileSeen, Setup, setup_of
from seater_tools.drive.drive import Drive

Array = NDArray[np.float64]

NOT_RUNNING = "no ROS master"  # why a check of a running system says nothing
# Files by their role: the names of the programs' options, and of the parameters that the running nodes are given.
ROLES = ("chair", "dock", "camera", "controller", "perception", "safety", "obstacles")
# Topics by their role; the adapter knows what they are called.
TOPICS = (
    "image", "camera_info", "odom", "detections", "gate_state", "cmd_vel", "velocity_request", "user_cmd_vel",
    "emergency_stop", "charging_contact", "hold_to_run",
)  # fmt: skip


@dataclass(frozen=True)
class Machine:
    """The computer. Shares are of 1."""

    missing: tuple[str, ...] = ()  # ROS packages and Python modules that are not found
    folder: str = ""  # where logs and bags go
    free: float = np.inf  # [byte] there
    busy: float | None = None  # share of all processors' time while it was watched; None: not watched
    versions: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Traffic:
    """A topic. stamps, arrivals: (n,) [s] of each message, both of the ROS clock; stamps are NaN without a header."""

    name: str
    publishers: tuple[str, ...] = ()
    listeners: tuple[str, ...] = ()
    stamps: Array = field(default_factory=lambda: np.zeros(0))
    arrivals: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True, eq=False)
class MarkerSeen:
    """As seater_msgs/MarkerDetection: corners (4, 2) [px], T (4, 4) in the optical frame, covariance (6, 6)."""

    id: int
    size: float
    corners: Array
    T: Array
    covariance: Array


@dataclass(frozen=True, eq=False)
class Sight:
    """One image worked through by perception."""

    stamp: float
    markers: tuple[MarkerSeen, ...]
    docks: tuple[Hypothesis, ...]


@dataclass(frozen=True, eq=False)
class Pictures:
    """What the camera sends. Values are None where nothing came."""

    size: tuple[int, int] | None = None  # width, height [px] of the images
    frame: str = ""  # of the images
    info: CameraModel | None = None  # as camera_info says, of the raw image
    info_error: str = ""  # why camera_info is no calibration
    cut_off: float | None = None  # share of the markers' white that is cut off at the sensor's limit
    contrast: float | None = None  # [grey levels] between the markers' white and black
    other: tuple[str, tuple[int, ...]] | None = None  # marker family and ids in the image, where none of the dock's is

    @property
    def sizes_agree(self) -> bool:
        """Whether camera_info is of images of this size, as far as both are known."""
        return self.info is None or self.size in (None, (self.info.width, self.info.height))


@dataclass(frozen=True)
class GateSeen:
    """The newest gate_state."""

    state: str
    reason: str
    emergency_stop: bool


@dataclass(frozen=True, eq=False)
class ObstaclesSeen:
    """What obstacle_finder makes of its sensor. arrivals: (n,) [s] of its answers, one for each measurement."""

    kind: str  # scan, cloud, depth
    topics: tuple[Traffic, ...] = ()  # that it listens to for measurements
    arrivals: Array = field(default_factory=lambda: np.zeros(0))
    blocked: str = ""  # why the newest measurement tells nothing


@dataclass(frozen=True, eq=False)
class Leg:
    """A piece of the drive between two stands: asked for, measured by the odometry, shown by the images; each (3,)
    x, y [m], heading [rad] of the end as seen from the begin. images: None where the dock was not seen at both."""

    asked: Array
    odometry: Array
    images: Array | None


@dataclass(frozen=True, eq=False)
class Move:
    """The drive of `--move`. `stopped`: why it ended early. `refused`: why the gate did not let it begin."""

    legs: tuple[Leg, ...]
    drive: Drive | None = None
    stopped: str = ""
    refused: str = ""


@dataclass(frozen=True, eq=False)
class Live:
    """A running system, watched for `duration` [s] while the chair stood. Odometry: (n, 6) stamp, x, y [m], heading
    [rad], v [m/s], omega [rad/s]. joystick: (n, 2) v, omega."""

    duration: float
    simulated_time: bool = False
    lock_step: bool = False  # of a simulation, which may have simulated time
    require_contact: bool = False
    asks_to_drive: bool = False  # --move: then the docking node must not run
    topics: Mapping[str, Traffic] = field(default_factory=dict)
    told: Mapping[str, Any] = field(default_factory=dict)  # by role: what the running nodes were given
    frames: tuple[str, str] = ("", "")  # of the odometry message: its frame and its child's
    T_base_optical: Array | None = None  # (4, 4) by TF
    pictures: Pictures = field(default_factory=Pictures)
    sights: tuple[Sight, ...] = ()
    odometry: Array = field(default_factory=lambda: np.zeros((0, 6)))
    gate: GateSeen | None = None
    obstacles: ObstaclesSeen | None = None  # None: there is no sensor
    emergency_stop: bool | None = None
    joystick: Array = field(default_factory=lambda: np.zeros((0, 2)))
    contact: bool | None = None
    complaints: tuple[tuple[str, str], ...] = ()  # node and text of each error on /diagnostics
    move: Move | None = None


@dataclass(frozen=True)
class Observations:
    """`live` None: no ROS master, only files and computer are looked at."""

    files: Mapping[str, FileSeen]
    machine: Machine = field(default_factory=Machine)
    live: Live | None = None

    @cached_property
    def setup(self) -> Setup:
        """What the files mean."""
        return setup_of(self.files)
