"""What a source of images is."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel


class SourceError(Exception):
    """No image can be had now; opening anew may help. The text says why, and what to do."""


class EndOfStreamError(SourceError):
    """A recording is over: opening anew is of no use."""


class Clock(Enum):
    """Which clock a frame's time is of."""

    MONOTONIC = "the kernel's steady clock"
    WALL = "the host's wall clock"
    DEVICE = "the camera's own clock"
    ARRIVAL = "none: the time of arrival"


@dataclass(frozen=True, eq=False)
class Frame:
    """One image as it came."""

    image: NDArray[np.uint8]  # (height, width) grey, or (height, width, 3) BGR
    time: float  # [s] by `clock`; not used with ARRIVAL
    clock: Clock
    arrival: float  # [s] by the steady clock, when the image was there


class Source(Protocol):
    """A camera, or a recording. One thread calls it; `read` returns within a few seconds, with a frame or an error."""

    name: str  # for people
    clock_period: float  # [s] after which the device's clock begins anew at 0; inf: never

    def open(self) -> CameraModel | None:
        """Begin; returns the lens as the device knows it. Raises SourceError."""

    def read(self) -> Frame:
        """The next frame. Raises SourceError: unplugged, stalled, or at its end (EndOfStreamError)."""

    def close(self) -> None:
        """End, whatever the state; never raises."""

    def set_exposure(self, seconds: float | None) -> bool:
        """Exposure time [s], None: the device's own automatic. False: the device cannot. Raises SourceError."""
