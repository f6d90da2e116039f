"""The whole of config/simulator.yaml, and the parts of it that do not move."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from seater_common.params import param
from seater_sim.settings.plant import PlantSettings
from seater_sim.settings.ranging import NO_SENSOR, RangingSettings, Walker
from seater_sim.settings.time import to_ns


@dataclass(frozen=True)
class PlanarPose:
    """A pose on the floor."""

    x: float = param(0.0, "m", "", low=-100.0, high=100.0)
    y: float = param(0.0, "m", "", low=-100.0, high=100.0)
    heading: float = param(0.0, "rad", "", low=-2.0 * math.pi, high=2.0 * math.pi)

    def as_array(self) -> np.ndarray:
        """(x [m], y [m], heading [rad])."""
        return np.array([self.x, self.y, self.heading])


@dataclass(frozen=True)
class OdometrySettings:
    """Wheel odometry. Errors are drawn once per seed with these standard deviations (`wheelchair`: only claimed)."""

    period: float = param(0.02, "s", "between two messages; a multiple of the step", low=0.001, high=1.0)
    scale_sd: float = param(0.01, "", "relative error of distances (wheel diameter)", low=0.0, high=0.2)
    heading_scale_sd: float = param(0.01, "", "relative error of turns (track width)", low=0.0, high=0.2)
    heading_drift_sd: float = param(0.005, "rad/m", "turn per metre (unequal wheels)", low=0.0, high=0.5)
    distance_noise: float = param(0.002, "m/sqrt(m)", "random error of distances", low=0.0, high=0.2)
    heading_noise: float = param(0.002, "rad/sqrt(m)", "random turn while driving", low=0.0, high=0.2)
    turn_noise: float = param(0.004, "rad/sqrt(rad)", "random error of turns", low=0.0, high=0.2)
    origin: PlanarPose = field(default_factory=lambda: PlanarPose(3.0, -1.5, 0.6))


@dataclass(frozen=True)
class CameraSettings:
    """How an image comes about; its geometry is that of the camera_info file."""

    rate: float = param(30.0, "Hz", "images per second of simulated time", low=0.1, high=120.0)
    latency: float = param(0.05, "s", "from the middle of the exposure to delivery", low=0.0, high=1.0)
    encoding: str = param("mono8", "", "of the images", choices=("mono8", "rgb8"))
    blur_sd: float = param(0.7, "px", "standard deviation of the point spread function", low=0.0, high=10.0)
    noise_sd: float = param(2.0, "grey levels", "white noise of each pixel", low=0.0, high=40.0)
    exposure: float = param(0.008, "s", "exposure time; motion during it blurs the image", low=0.0, high=0.1)
    gain: float = param(1.0, "", "brightness; 1: white paper is at 225 grey levels", low=0.05, high=5.0)
    vignetting: float = param(0.2, "", "loss of brightness in the corners of the image", low=0.0, high=0.95)
    compressed_format: str = param("png", "", "of image_raw/compressed", choices=("png", "jpeg"))
    jpeg_quality: int = param(90, "", "of image_raw/compressed, if jpeg", low=1, high=100)


@dataclass(frozen=True)
class SceneSettings:
    """What the camera sees besides the dock's markers."""

    quiet_zone: float = param(0.2, "", "white margin of a marker's sheet / side of the marker", low=0.0, high=1.0)
    white: float = param(225.0, "grey levels", "white paper", low=10.0, high=255.0)
    ink: float = param(0.13, "", "reflectance of the print's black relative to the paper", low=0.0, high=0.95)


@dataclass(frozen=True)
class ContactSettings:
    """The charging contact; where it closes is the dock's contact_tolerance."""

    max_speed: float = param(0.02, "m/s", "closes only below this speed", low=0.0, high=1.0)
    max_omega: float = param(0.05, "rad/s", "closes only below this turning rate", low=0.0, high=1.0)


@dataclass(frozen=True)
class Obstacle:
    """A further thing in the way: a vertical prism on the floor."""

    outline: list[float] = param([], "m", "x1, y1, x2, y2, ... convex, anticlockwise, in the dock frame")
    height: float = param(1.0, "m", "", low=0.01, high=4.0)

    def __post_init__(self) -> None:
        if len(self.outline) < 6 or len(self.outline) % 2:
            raise ValueError(f"outline: is {self.outline!r}, must list x and y of at least 3 points")
        edges = np.roll(self.polygon(), -1, axis=0) - self.polygon()
        following = np.roll(edges, -1, axis=0)
        if np.any(edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0] <= 0.0):
            raise ValueError(f"outline: {self.outline!r} is not convex and anticlockwise")

    def polygon(self) -> np.ndarray:
        """Corners in the dock frame, (n, 2) [m]."""
        return np.array(self.outline, dtype=float).reshape(-1, 2)


@dataclass(frozen=True)
class SimulatorSettings:
    """The whole of config/simulator.yaml."""

    start_time: float = param(10.0, "s", "the clock before the first step; not 0, which ROS takes for unset", low=0.001)
    step: float = param(0.01, "s", "time step", low=0.001, high=0.05)
    plant: PlantSettings = field(default_factory=PlantSettings)
    odometry: OdometrySettings = field(default_factory=OdometrySettings)
    camera: CameraSettings = field(default_factory=CameraSettings)
    scene: SceneSettings = field(default_factory=SceneSettings)
    contact: ContactSettings = field(default_factory=ContactSettings)
    ranging: RangingSettings = field(default_factory=RangingSettings)
    obstacles: list[Obstacle] = field(default_factory=list)
    walkers: list[Walker] = field(default_factory=list)

    def __post_init__(self) -> None:
        if self.ranging.kind != NO_SENSOR and to_ns(self.ranging.period) % to_ns(self.odometry.period):
            allowed = f"a multiple of odometry/period ({self.odometry.period} s)"
            raise ValueError(f"ranging/period: is {self.ranging.period}, must be {allowed}")
        if to_ns(self.odometry.period) % to_ns(self.step):
            raise ValueError(f"odometry/period: is {self.odometry.period}, must be a multiple of step ({self.step} s)")
