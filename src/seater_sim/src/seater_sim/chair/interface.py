"""What the simulator asks of a plant and of its odometry: both kinds offer it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """What the last step did, in base_link: way [m], turn [rad], creep to the left [m]."""

    way: float = 0.0
    turn: float = 0.0
    side: float = 0.0


@dataclass(frozen=True)
class OdometrySample:
    """One message. Pose of base_link in odom, twist in base_link."""

    time_ns: int
    pose: Array  # (x [m], y [m], heading [rad])
    v: float  # [m/s]
    omega: float  # [rad/s]
    pose_covariance: Array  # (3, 3) over (x, y, heading), error since the start
    twist_covariance: Array  # (2, 2) over (v, omega)
    frame: str = "base_link"  # whose pose it is


class Plant(Protocol):
    """The moving chair. Time is counted in nanoseconds from the construction; poses are those of base_link in the dock
    frame, (x [m], y [m], heading [rad])."""

    pose: Array
    time_ns: int
    refused: int  # commands that were not finite
    motion: Motion

    @property
    def v(self) -> float:
        """True speed [m/s]."""

    @property
    def omega(self) -> float:
        """True turning rate [rad/s]."""

    def command(self, v: float, omega: float) -> bool:
        """Take a command that arrives now. One that is not finite counts as zero; then False is returned."""

    def step(self, duration_ns: int) -> None:
        """Advance by `duration_ns`. A command takes effect at the step that begins at or after its time."""

    def power(self, on: bool) -> None:
        """The motors' power. Without it the brakes stop the chair, and commands are lost."""

    def halt(self) -> None:
        """Stand still at once and forget all commands."""

    def block(self) -> None:
        """Undo the motion of the last step and stall: something stands in the way."""

    def pose_within(self, fraction: float) -> Array:
        """Pose at a fraction (0..1) of the last step."""


class WheelOdometry(Protocol):
    """Makes the messages of the wheel odometry."""

    def update(self, way: float, turn: float, duration_ns: int, time_ns: int) -> OdometrySample:
        """The message after a true motion of `way` [m] and `turn` [rad] within `duration_ns`."""
