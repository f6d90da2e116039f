"""The plant `wheelchair`: one dataclass per part of the chair, in the order in which a command passes them.

Defaults are a typical indoor chair with every effect on (config/simulator.yaml says how they follow from the ranges in
config/plants/indoor_chair.yaml). An effect is off when its value is zero (gains: one). docs/explanation/simulator.md
has the formulas.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from seater_common.params import param

JUMP, OFFSET = "jump", "offset"
ENCODERS, GYRO = "encoders", "gyro"


@dataclass(frozen=True)
class CommandSettings:
    """The way of a command into the motor controller."""

    delay: float = param(0.16, "s", "from a command's arrival to its effect", low=0.0, high=1.0)
    delay_jitter: float = param(0.015, "s", "up to so much more, at random; never reorders", low=0.0, high=0.5)
    timeout: float = param(0.375, "s", "without a new command for so long, the demand goes to zero", low=0.01)
    deadband_kind: str = param(JUMP, "", "above the deadband: unchanged, or less by it", choices=(JUMP, OFFSET))
    deadband_v: float = param(0.01, "m/s", "a speed up to this does not move the chair", low=0.0, high=0.2)
    deadband_omega: float = param(0.025, "rad/s", "the same for turning", low=0.0, high=0.5)
    gain_v: float = param(1.025, "", "steady speed of the wheels over the command", low=0.3, high=2.0)
    gain_omega: float = param(0.985, "", "the same for turning", low=0.3, high=2.0)


@dataclass(frozen=True)
class MotorSettings:
    """Motor controller, two motors, battery and brakes."""

    acceleration: float = param(1.1, "m/s^2", "ramp of the motor controller; 0: none", low=0.0, high=10.0)
    deceleration: float = param(1.5, "m/s^2", "the same when slowing down", low=0.0, high=10.0)
    turn_acceleration: float = param(2.7, "rad/s^2", "ramp of the turning rate; 0: none", low=0.0, high=20.0)
    turn_deceleration: float = param(3.2, "rad/s^2", "the same when turning less", low=0.0, high=20.0)
    lag_v: float = param(0.18, "s", "time constant of the speed behind the ramp", low=0.0, high=2.0)
    lag_omega: float = param(0.18, "s", "time constant of the turning rate", low=0.0, high=2.0)
    weak_left: float = param(0.013, "", "the left motor is so much slower than asked", low=0.0, high=0.3)
    weak_right: float = param(0.007, "", "the right motor", low=0.0, high=0.3)
    droop_time: float = param(5e-6, "1/s", "speed lost per second as the battery empties", low=0.0, high=0.01)
    droop_load: float = param(0.01, "1/(m/s^2)", "speed lost per acceleration incl. slope", low=0.0, high=0.3)
    brake_delay: float = param(0.6, "s", "brakes hold after zero demand for so long; 0: none", low=0.0, high=5.0)


@dataclass(frozen=True)
class CastorSettings:
    """Two front castors: they swing round with the way driven, and push until they trail."""

    trail: float = param(0.05, "m", "contact point behind the pivot; 0: no castors", low=0.0, high=0.3)
    ahead: float = param(0.45, "m", "pivots ahead of the driven axle", low=0.05, high=1.5)
    spread: float = param(0.48, "m", "between the two pivots", low=0.0, high=1.5)
    push_v: float = param(0.01, "m/s", "speed lost while both lie across", low=0.0, high=0.2)
    push_omega: float = param(0.05, "rad/s", "turning while both lie at 45 deg", low=0.0, high=1.0)
    start_angle: float = param(3.1416, "rad", "at the start at random within +- this", low=0.0, high=3.1416)


@dataclass(frozen=True)
class FloorSettings:
    """Slip of the driven wheels, patches of slippery floor, slope."""

    slip_left: float = param(0.01, "", "of the left wheel's way is lost", low=0.0, high=0.5)
    slip_right: float = param(0.02, "", "of the right wheel's", low=0.0, high=0.5)
    slip_load: float = param(0.005, "1/(m/s^2)", "further slip per acceleration incl. slope", low=0.0, high=0.2)
    patch_slip: float = param(0.04, "", "largest slip on a patch, half of it the smallest", low=0.0, high=0.9)
    patch_length: float = param(0.35, "m", "mean length of a patch, drawn within +-50 %", low=0.01, high=10.0)
    patch_gap: float = param(1.9, "m", "mean way between patches (exponential)", low=0.01, high=100.0)
    patch_one_sided: float = param(0.55, "", "part of the patches under one wheel only", low=0.0, high=1.0)
    slope: float = param(0.0105, "rad", "inclination of the floor", low=0.0, high=0.25)
    uphill: float = param(0.8, "rad", "direction of the rise in the dock frame", low=-3.1416, high=3.1416)
    compliance: float = param(0.035, "s", "speed lost per acceleration of gravity along the chair", low=0.0, high=1.0)
    downhill_turn: float = param(0.02, "rad*s/m", "turning per acceleration of gravity across", low=0.0, high=1.0)
    side_slip: float = param(0.005, "rad/(m/s^2)", "angle of the tyres' sideways creep", low=0.0, high=0.2)


@dataclass(frozen=True)
class WheelSettings:
    """The driven wheels: nominal size, which odometry and motor controller believe in, and how far it is off."""

    radius: float = param(0.168, "m", "nominal radius of the wheels", low=0.01, high=0.5)
    track: float = param(0.56, "m", "nominal distance between them", low=0.05, high=1.5)
    radius_error_left: float = param(0.003, "", "the left wheel is so much larger than nominal", low=-0.2, high=0.2)
    radius_error_right: float = param(-0.003, "", "the right wheel", low=-0.2, high=0.2)
    track_error: float = param(0.005, "", "the track is so much wider", low=-0.2, high=0.2)
    ticks: int = param(4096, "", "of an encoder per turn of its wheel; 0: continuous", low=0, high=10_000_000)


@dataclass(frozen=True)
class WheelOdometrySettings:
    """How odometry comes from the encoders; period, origin and the covariance it claims are those of `odometry`."""

    yaw: str = param(ENCODERS, "", "what measures turns", choices=(ENCODERS, GYRO))
    gyro_bias: float = param(0.008, "rad/s", "at rest, too", low=-0.5, high=0.5)
    gyro_scale: float = param(0.005, "", "relative error of turns", low=-0.2, high=0.2)
    gyro_noise: float = param(2.5e-4, "rad/sqrt(s)", "angle random walk", low=0.0, high=0.1)
    zero_twist: bool = param(False, "", "the twist of the message is always zero, as of some drivers")
    arrival_jitter: float = param(0.0, "s", "arrives up to so much after its stamp; never reorders", low=0.0, high=0.5)


@dataclass(frozen=True)
class WheelchairSettings:
    """A chair as it is."""

    command: CommandSettings = field(default_factory=CommandSettings)
    motor: MotorSettings = field(default_factory=MotorSettings)
    castors: CastorSettings = field(default_factory=CastorSettings)
    floor: FloorSettings = field(default_factory=FloorSettings)
    wheels: WheelSettings = field(default_factory=WheelSettings)
    odometry: WheelOdometrySettings = field(default_factory=WheelOdometrySettings)


def without_effects() -> WheelchairSettings:
    """The same wheels, and every effect off: commands act at once and exactly. To switch on single effects from."""
    return WheelchairSettings(
        CommandSettings(delay=0.0, delay_jitter=0.0, deadband_v=0.0, deadband_omega=0.0, gain_v=1.0, gain_omega=1.0),
        MotorSettings(*([0.0] * 11)),
        CastorSettings(trail=0.0, push_v=0.0, push_omega=0.0, start_angle=0.0),
        FloorSettings(0.0, 0.0, 0.0, 0.0, slope=0.0, uphill=0.0, compliance=0.0, downhill_turn=0.0, side_slip=0.0),
        WheelSettings(radius_error_left=0.0, radius_error_right=0.0, track_error=0.0, ticks=0),
        WheelOdometrySettings(gyro_bias=0.0, gyro_scale=0.0, gyro_noise=0.0, arrival_jitter=0.0),
    )
