"""What a sensor of obstacles measures, and who walks about."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from seater_common.params import param

NO_SENSOR, SCAN, DEPTH = "none", "scan", "depth"


@dataclass(frozen=True)
class ScanSettings:
    """A level laser scanner."""

    x: float = param(0.70, "m", "ahead of the driven axle", low=-2.0, high=2.0)
    y: float = param(0.0, "m", "left of the middle", low=-1.0, high=1.0)
    z: float = param(0.25, "m", "above the floor; lower things are not seen", low=0.01, high=2.0)
    yaw: float = param(0.0, "rad", "its middle ray looks left by this", low=-math.pi, high=math.pi)
    half_angle: float = param(2.0, "rad", "its first and last ray are so far from the middle one", low=0.1, high=3.14)
    step: float = param(0.00873, "rad", "between two rays", low=0.001, high=0.1)
    min_range: float = param(0.05, "m", "what is nearer is not measured", low=0.0, high=1.0)
    max_range: float = param(8.0, "m", "what is farther away is not measured", low=0.5, high=100.0)
    noise_sd: float = param(0.01, "m", "of a measured distance", low=0.0, high=0.2)


@dataclass(frozen=True)
class DepthSettings:
    """A depth image with the mount and field of view of the camera."""

    columns: int = param(160, "px", "of the image", low=16, high=1280)
    rows: int = param(90, "px", "of the image", low=16, high=960)
    max_range: float = param(6.0, "m", "what is farther away is not measured (0)", low=0.5, high=100.0)
    noise: float = param(0.005, "1/m", "standard deviation over the square of the depth", low=0.0, high=0.1)


@dataclass(frozen=True)
class RangingSettings:
    """The sensor of obstacles, for the obstacle node."""

    kind: str = param(NO_SENSOR, "", "which one there is", choices=(NO_SENSOR, SCAN, DEPTH))
    period: float = param(0.1, "s", "between two measurements; a multiple of the odometry's", low=0.01, high=2.0)
    latency: float = param(0.04, "s", "from a measurement (its stamp) to its delivery", low=0.0, high=1.0)
    scan: ScanSettings = field(default_factory=ScanSettings)
    depth: DepthSettings = field(default_factory=DepthSettings)


@dataclass(frozen=True)
class Walker:
    """Somebody who walks along a straight line; he waits where he would come too near to the chair.

    Only the sensor of obstacles sees him, the camera does not.
    """

    start: list[float] = param([0.0, 0.0], "m", "where he stands before, in the dock frame", length=2)
    velocity: list[float] = param([0.0, 0.0], "m/s", "in the dock frame", length=2)
    begin: float = param(0.0, "s", "after the start of the run", low=0.0)
    duration: float = param(10.0, "s", "of the walk", low=0.0)
    radius: float = param(0.22, "m", "of him, seen from above", low=0.05, high=1.0)
    height: float = param(1.7, "m", "", low=0.1, high=3.0)
    keeps: float = param(0.1, "m", "he comes no nearer to the chair by himself", low=0.0, high=2.0)

    def position(self, walked: float) -> np.ndarray:
        """(2,) [m] in the dock frame, after he has walked for `walked` [s]."""
        return np.array(self.start) + walked * np.array(self.velocity)

    def polygon(self, walked: float) -> np.ndarray:
        """Corners, (12, 2) [m], anticlockwise, in the dock frame."""
        angles = np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False)
        return self.position(walked) + self.radius * np.column_stack([np.cos(angles), np.sin(angles)])
