"""What the controller is told of the chair: nothing, delay and lag, or everything that identification could find."""

from __future__ import annotations

import dataclasses
import math
from typing import TypeVar

from seater_eval.judge.plant.built import TRACK, Built
from seater_eval.judge.plant.effects import Effects
from seater_nmpc.parameters import NmpcParameters

T = TypeVar("T")

TOLD = ("nothing", "delay_lag", "all")
_UNIFORM = 1.0 / math.sqrt(3.0)  # standard deviation over largest value, of what is drawn evenly from -max to max
_PATCH_SHARE, _PATCH_LENGTH = 0.25, 0.4  # of the way; [m]
_REST = 0.003  # [-] what identification leaves of a constant error


def told_parameters(parameters: NmpcParameters, told: str, effects: Effects, built: Built) -> NmpcParameters:
    """The same with what `told` (of TOLD) names. Keys that this version of the parameters has not are left out."""
    if told not in TOLD:
        raise ValueError(f"told: is {told!r}, must be one of {', '.join(TOLD)}")
    if told == "nothing":
        return parameters
    drive = effects.drive
    values: dict[str, float] = {
        "command_delay": drive.delay + 0.5 * drive.delay_jitter,
        "motor_lag": round(built.lag_v, 3),
        "motor_lag_turning": round(built.lag_omega, 3),
    }
    if told == "all":
        values |= {"deadband_v": drive.deadband_v, "deadband_omega": drive.deadband_omega}
        values |= {"gain_v": _gain_v(built), "gain_omega": _gain_omega(built)}
    prediction = set_known(parameters.control.prediction, values)
    control = dataclasses.replace(parameters.control, prediction=prediction)
    observer = parameters.observer
    if told == "all":
        observer = set_known(observer, odometry_errors(effects, built, "odometry_scale" in _names(observer)))
    return dataclasses.replace(parameters, control=control, observer=observer)


def odometry_errors(effects: Effects, built: Built, means: bool) -> dict[str, float]:
    """Keys of the observer. `means`: the constant errors are told as such, and deviations are of what changes on the
    way; else the deviations cover both.

    Patches are a random walk as well: of those with half the largest slip that cover a share of the way, a length each,
    the way is off by slip * sqrt(share * length) after a metre; as much between the wheels turns the chair.
    """
    floor = effects.floor
    patches = 0.5 * floor.patch_slip
    constant = (floor.slip * _UNIFORM, floor.radius)
    scale_sd = math.hypot(_REST, patches) if means else math.hypot(patches, *constant)
    turn_sd = math.hypot(_REST, patches) if means else math.hypot(patches, floor.track, *constant)
    drift = 0.5 * patches / TRACK  # one wheel on a patch now and then
    drift_sd = math.hypot(_REST, drift) if means else math.hypot(0.005, drift, math.sqrt(2.0) * floor.radius / TRACK)
    walk = patches * math.sqrt(_PATCH_SHARE * _PATCH_LENGTH)
    left, right = (
        (1.0 + radius) * (1.0 - slip) for radius, slip in zip(built.radius, built.slip, strict=True)
    )  # ground speed over what the encoder says
    return {
        "scale_sd": scale_sd,
        "heading_scale_sd": turn_sd,
        "heading_drift_sd": drift_sd,
        "distance_noise": math.hypot(0.002, walk),
        "heading_noise": math.hypot(0.002, walk / TRACK),
        "turn_noise": math.hypot(0.004, walk),
        "odometry_scale": 2.0 / (left + right) - 1.0,
        "odometry_heading_scale": 2.0 * (1.0 + built.track) / (left + right) - 1.0,
        "odometry_heading_drift": -(right - left) / (0.5 * (left + right)) / TRACK,
    }


def _gain_v(built: Built) -> float:
    ground = zip(built.strength, built.radius, built.slip, strict=True)
    return 0.5 * sum(strength * (1.0 + radius) * (1.0 - slip) for strength, radius, slip in ground)


def _gain_omega(built: Built) -> float:
    return _gain_v(built) / (1.0 + built.track)


def set_known(group: T, values: dict[str, float]) -> T:
    """The dataclass with those of the values for which it has a field."""
    known = {name: value for name, value in values.items() if name in _names(group)}
    return dataclasses.replace(group, **known)  # type: ignore[type-var]


def _names(group: object) -> set[str]:
    return {field.name for field in dataclasses.fields(group)}  # type: ignore[arg-type]
