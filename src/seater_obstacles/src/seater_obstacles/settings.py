"""Everything a person tunes about the obstacles (config/obstacles.yaml)."""

from __future__ import annotations

from dataclasses import dataclass, field

from seater_common.params import param


@dataclass(frozen=True)
class SenseSettings:
    """Which measured points count."""

    max_range: float = param(4.0, "m", "from base_link; what is farther away does not count", low=0.5, high=20.0)
    floor: float = param(0.06, "m", "a point of a cloud or depth image lower than this is floor", low=0.01, high=0.3)
    floor_slope: float = param(0.02, "", "and so much more per metre from the sensor: tilt, noise", low=0.0, high=0.2)
    top: float = param(1.5, "m", "a point higher than this is passed below", low=0.3, high=3.0)
    stride: int = param(8, "px", "every so manieth row and column of a depth image is used", low=1, high=64)
    self_margin: float = param(0.03, "m", "points within the footprint and this are the chair", low=0.0, high=0.3)
    dock_margin: float = param(
        0.10, "m", "points so near to the dock's walls and markers are the dock", low=0.0, high=0.5
    )


@dataclass(frozen=True)
class ClusterSettings:
    """How points become outlines."""

    cell: float = param(0.05, "m", "side of the cells that points are put into", low=0.01, high=0.2)
    link: float = param(0.15, "m", "points nearer to each other belong together", low=0.02, high=1.0)
    min_points: int = param(3, "", "measured points that make an obstacle, fewer are noise", low=1, high=100)
    max_length: float = param(
        0.8, "m", "a longer one is cut: the hull of a bent wall would fill a room", low=0.2, high=5.0
    )
    thickness: float = param(0.04, "m", "of an outline at least: one side of a thing is seen", low=0.01, high=0.5)
    max_outlines: int = param(16, "", "the nearest are told to the controller", low=1, high=100)


@dataclass(frozen=True)
class TrackSettings:
    """What moves, and what is remembered."""

    max_size: float = param(1.0, "m", "a larger cluster is not followed: it is a wall", low=0.1, high=3.0)
    max_jump: float = param(0.5, "m", "farthest from where a cluster is expected", low=0.1, high=2.0)
    moving: float = param(0.35, "m/s", "a faster cluster moves", low=0.05, high=2.0)
    prediction: float = param(1.0, "s", "a moving thing may be anywhere on its way of this time", low=0.0, high=3.0)
    memory: float = param(
        60.0, "s", "a thing that stands is remembered so long where it cannot be seen", low=0.0, high=600.0
    )
    lost: float = param(3.0, "s", "the same for the way of a thing that moves", low=0.0, high=60.0)


@dataclass(frozen=True)
class ObstacleSettings:
    """The whole of config/obstacles.yaml."""

    sense: SenseSettings = field(default_factory=SenseSettings)
    cluster: ClusterSettings = field(default_factory=ClusterSettings)
    track: TrackSettings = field(default_factory=TrackSettings)
