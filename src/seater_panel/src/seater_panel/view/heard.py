"""What was heard last of each topic, as plain values. Times are seconds of one steady clock, of the arrival.

Lengths in metres, angles in radians. A planar pose is (x, y, heading).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Dock

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Gate:
    """seater_msgs/GateState; `state`: the name of its constant."""

    time: float
    state: str
    reason: str


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Odometry: T_odom_base, and the speed along it [m/s]."""

    time: float
    pose: Array
    v: float


@dataclass(frozen=True, kw_only=True)
class Progress:
    """Feedback of the action that runs."""

    time: float
    action: str
    phase: str
    distance: float  # -1: the dock is not known
    elapsed: float
    retries: int
    marker_seen: bool | None  # None: this action does not say


@dataclass(frozen=True, kw_only=True)
class Result:
    """How the last goal has ended. Errors of a docking: ahead, left, heading; None: nothing was verified."""

    time: float
    action: str
    code: int
    name: str
    text: str
    success: bool
    error: tuple[float, float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class Planned:
    """The controller's last plan: base_link in odom, (n, 2)."""

    time: float
    path: Array


@dataclass(frozen=True, kw_only=True)
class Sight:
    """One marker in one image, on the floor: centre (2,) in odom, and its covariance (2, 2) along odom's axes."""

    id: int
    place: Array
    covariance: Array


@dataclass(frozen=True, kw_only=True)
class Sights:
    """All that the last image shows; `candidates`: possible poses of the dock in odom with their weights."""

    time: float
    markers: tuple[Sight, ...]
    candidates: tuple[tuple[Array, float], ...]


@dataclass(frozen=True, kw_only=True)
class Outlines:
    """Obstacles that were told, (n, 2) each; `in_dock`: seen from the dock, else in odom."""

    in_dock: bool
    polygons: tuple[Array, ...]


@dataclass(frozen=True, kw_only=True)
class Points:
    """What a sensor of obstacles sees, (n, 2) in base_link."""

    time: float
    points: Array


@dataclass(frozen=True)
class Heard:
    """Everything; None: never."""

    gate: Gate | None = None
    motion: Motion | None = None
    progress: Progress | None = None
    result: Result | None = None
    planned: Planned | None = None
    sights: Sights | None = None
    outlines: Outlines | None = None
    points: Points | None = None
    dock: Array | None = None  # T_odom_dock
    in_use: Dock | None = None  # the dock that the docking node looks for
    docks: tuple[str, ...] = ()  # the names that a goal may give
    image: float | None = None  # time of the last annotated image
