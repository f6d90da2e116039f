"""How large each effect of the independent chair is, each switched off by its own zero; the defaults are the whole
plant of the table that this evaluation reproduces (delay 0.25 s, deadband 0.02 m/s and 0.05 rad/s, slip 0-4 %, ...)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

DEADBANDS = ("jump", "offset", "stiction")


@dataclass(frozen=True)
class Drive:
    """From a command to the speeds of the wheels."""

    delay: float = 0.25  # [s] from sending a command to its effect
    delay_jitter: float = 0.0  # [s] up to so much more, drawn for each command; commands keep their order
    lag: tuple[float, float] = (0.15, 0.3)  # [s] range of the first-order time constants, drawn for speed and turning
    ramp_v: float = 0.8  # [m/s^2] largest change of the demanded speed; 0: any
    ramp_omega: float = 2.0  # [rad/s^2] the same for turning
    deadband_v: float = 0.02  # [m/s] commands up to this do not move the chair
    deadband_omega: float = 0.05  # [rad/s] nor do these turn it
    deadband_kind: str = "jump"  # of DEADBANDS

    def __post_init__(self) -> None:
        if self.deadband_kind not in DEADBANDS:
            raise ValueError(f"deadband_kind: is {self.deadband_kind!r}, must be one of {', '.join(DEADBANDS)}")
        if not 0.0 <= self.lag[0] <= self.lag[1]:
            raise ValueError(f"lag: is {self.lag}, must be two numbers >= 0 [s], the smaller one first")


@dataclass(frozen=True)
class Floor:
    """Wheels, castors and what they roll on."""

    slip: float = 0.04  # largest constant slip of both wheels: ground speed / rolling speed = 1 - slip
    patch_slip: float = 0.12  # largest slip of a wheel on a slippery patch; patches are smaller than the track
    radius: float = 0.015  # each wheel's radius is off by 2/3 of this up to this, to either side
    track: float = 0.015  # the same for the track
    weaker: float = 0.03  # one side turns slower than asked for by up to this
    castor_omega: float = 0.1  # [rad/s] turning of a chair whose castors stand across the direction of travel
    castor_v: float = 0.02  # [m/s] braking of one whose castors point the wrong way
    slope: float = math.radians(2.0)  # [rad] the floor's inclination, in a random direction


@dataclass(frozen=True)
class Encoders:
    """Odometry from the wheels' encoders."""

    rate: float = 50.0  # [Hz]
    jitter: float = 0.0  # [s] each message comes later by up to this; its stamp is true
    ordered: bool = True  # false: messages may overtake each other
    tick: float = 1e-4  # [m] of rolling per encoder step (a geared motor's encoder)
    zero_twist: bool = False  # the messages say nothing of speeds
    gyro_bias: float = 0.0  # [rad/s] added to the turning rate that is told
    gyro_in_pose: bool = False  # the heading told drifts with the bias, too


@dataclass(frozen=True)
class Pictures:
    """Camera and perception."""

    rate: float = 10.0  # [Hz]
    latency: float = 0.12  # [s] from exposure (the stamp) to the pose's arrival
    view: float = math.radians(90.0)  # [rad] horizontal field of view
    outliers: float = 0.03  # share of images whose pose is far off
    flips: float = 0.05  # share of images that offer the pose mirrored about the line of sight
    ambiguous: bool = False  # every image leaves both poses open, as a single marker's may
    noise: float = 1.0  # times the standard deviations of camera.py; 0: exact, but told as at 1


@dataclass(frozen=True)
class Effects:
    """All of it."""

    drive: Drive = field(default_factory=Drive)
    floor: Floor = field(default_factory=Floor)
    encoders: Encoders = field(default_factory=Encoders)
    pictures: Pictures = field(default_factory=Pictures)


def kinematic() -> Effects:
    """Everything off: commands are speeds, and the camera sends 30 images a second, 50 ms late."""
    drive = Drive(delay=0.0, lag=(0.0, 0.0), ramp_v=0.0, ramp_omega=0.0, deadband_v=0.0, deadband_omega=0.0)
    floor = Floor(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return Effects(drive, floor, Encoders(), Pictures(rate=30.0, latency=0.05, outliers=0.0, flips=0.0))


def changed(effects: Effects, group: str, **values: object) -> Effects:
    """The same with other values in one group. Raises TypeError for a name that the group has not."""
    return replace(effects, **{group: replace(getattr(effects, group), **values)})
