"""Everything a person sets about the base (config/base.yaml)."""

from __future__ import annotations

from dataclasses import dataclass, field

from seater_common.params import param


@dataclass(frozen=True)
class WheelSettings:
    """The driven wheels and their encoders."""

    separation: float = param(0.56, "m", "between the wheels' middles", low=0.1, high=2.0)
    left_counts: float = param(20000.0, "1/m", "encoder counts per metre; < 0: they fall forward", low=-1e7, high=1e7)
    right_counts: float = param(20000.0, "1/m", "the same on the right", low=-1e7, high=1e7)
    fastest: float = param(3.0, "m/s", "a wheel cannot be faster: such counts are none", low=0.1, high=20.0)

    def __post_init__(self) -> None:
        for name in ("left_counts", "right_counts"):
            if abs(getattr(self, name)) < 1.0:
                raise ValueError(f"{name} is {getattr(self, name)}, must be at least 1 per metre, or -1")


@dataclass(frozen=True)
class NoiseSettings:
    """Random errors of the odometry, for its covariance."""

    distance: float = param(0.002, "m/sqrt(m)", "of a way after 1 m, standard deviation", low=1e-5, high=1.0)
    turn: float = param(0.004, "rad/sqrt(rad)", "of a turn after 1 rad", low=1e-5, high=1.0)
    heading: float = param(0.002, "rad/sqrt(m)", "of the heading after 1 m", low=1e-5, high=1.0)


@dataclass(frozen=True)
class BaseSettings:
    """The whole of config/base.yaml."""

    port: str = param("/dev/ttyACM0", "", "serial port of the microcontroller")
    baud: int = param(115200, "1/s", "its speed", choices=(57600, 115200, 230400, 460800, 921600))
    rate: int = param(50, "Hz", "commands per second", low=20, high=200)
    silence: float = param(0.3, "s", "cmd_vel or motor_enable silent for so long: stop", low=0.05, high=0.5)
    v_max: float = param(0.6, "m/s", "what is beyond is cut off, both ways", low=0.01, high=3.0)
    omega_max: float = param(0.8, "rad/s", "the same for turning", low=0.01, high=4.0)
    brake: float = param(
        1.5, "m/s^2", "slowing down when cmd_vel is silent, as a_stop of safety.yaml", low=0.1, high=5.0
    )
    wheels: WheelSettings = field(default_factory=WheelSettings)
    noise: NoiseSettings = field(default_factory=NoiseSettings)
