"""Everything a person tunes about the identification (config/identify.yaml)."""

from __future__ import annotations

from dataclasses import dataclass, field

from seater_common.params import param


@dataclass(frozen=True)
class AreaSettings:
    """The free area: a rectangle along the chair's heading at the start, which stands in the middle of its width.

    What the drive does not need of the length is left free at both ends, half and half.
    """

    length: float = param(2.4, "m", "along the chair's heading", low=1.0, high=20.0)
    width: float = param(2.6, "m", "across, half of it to each side", low=1.0, high=20.0)
    tolerance: float = param(0.1, "m", "how far the footprint may leave the area before the drive stops", low=0.0)


@dataclass(frozen=True)
class DriveSettings:
    """The scripted drive. Speeds are cut to the limits of chair.yaml."""

    way: float = param(0.9, "m", "straight there and back; shortened when the area is shorter", low=0.3, high=10.0)
    v: float = param(0.4, "m/s", "speed of the fastest straight", low=0.1, high=1.5)
    omega: float = param(0.6, "rad/s", "rate of the fastest turn", low=0.2, high=3.0)
    creep_v: float = param(0.08, "m/s", "the slow rise of the command ends here", low=0.01, high=0.3)
    creep_omega: float = param(0.16, "rad/s", "the same for turning", low=0.02, high=0.6)
    creep_double: float = param(1.2, "s", "time in which the slow rise doubles the command", low=0.3, high=10.0)
    pause: float = param(0.8, "s", "standing between two moves", low=0.2, high=5.0)
    period: float = param(0.02, "s", "between two commands", low=0.01, high=0.2)
    odometry_timeout: float = param(0.3, "s", "age of the odometry at which the drive stops", low=0.05, high=2.0)


@dataclass(frozen=True)
class IdentifySettings:
    """The whole of config/identify.yaml."""

    area: AreaSettings = field(default_factory=AreaSettings)
    drive: DriveSettings = field(default_factory=DriveSettings)
