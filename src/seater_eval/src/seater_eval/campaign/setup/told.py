"""What the controller is told about the plant that it drives."""

from __future__ import annotations

import dataclasses
import importlib
import importlib.util
from typing import Any, TypeVar

from seater_common.geometry import Chair
from seater_common.params import ParameterError
from seater_nmpc.parameters import NmpcParameters
from seater_sim.settings import KINEMATIC, SimulatorSettings, WheelchairSettings
from seater_sim.settings.wheelchair import GYRO

T = TypeVar("T")

DEFAULTS, TRUTH, IDENTIFIED = "defaults", "truth", "identified"
CHOICES = (DEFAULTS, TRUTH, IDENTIFIED)

# identified_parameters(parameters, simulator, chair, seed) -> NmpcParameters drives the plant and identifies it.
_IDENTIFIER = "seater_identify.simulated"


def check_told(told: str) -> None:
    """Raises ParameterError when the parameters cannot be had in this way."""
    if told not in CHOICES:
        raise ParameterError(f"--told: is {told!r}, must be one of {', '.join(CHOICES)}")
    if told == IDENTIFIED:
        package = _IDENTIFIER.partition(".")[0]
        if importlib.util.find_spec(package) is None or importlib.util.find_spec(_IDENTIFIER) is None:
            raise ParameterError(f"--told identified: needs {_IDENTIFIER}, which is not installed here")


def told_parameters(
    parameters: NmpcParameters, simulator: SimulatorSettings, chair: Chair, told: str, seed: int
) -> NmpcParameters:
    """`defaults`: those of controller.yaml. `truth`: what the controller has parameters for, as it is. `identified`:
    what an identification finds on this plant; `seed`: of its drive."""
    if told == DEFAULTS:
        return parameters
    if told == IDENTIFIED:
        found: NmpcParameters = importlib.import_module(_IDENTIFIER).identified_parameters(
            parameters, simulator, chair, seed
        )
        return found
    if simulator.plant.kind == KINEMATIC:
        plant = simulator.plant.kinematic
        motors = {"command_delay": plant.command_delay, "motor_lag": plant.lag_v, "motor_lag_turning": plant.lag_omega}
        odometry: dict[str, float] = {}
    else:
        motors, odometry = _motors(simulator.plant.wheelchair), _odometry(simulator.plant.wheelchair)
    control = parameters.control
    return dataclasses.replace(
        parameters,
        control=dataclasses.replace(control, prediction=_with(control.prediction, motors | {"solve_latency": 0.0})),
        observer=_with(parameters.observer, odometry),
    )


def _motors(chair: WheelchairSettings) -> dict[str, float]:
    """The mean delay; a side that is weaker makes both axes slower."""
    command, motor = chair.command, chair.motor
    strength = 1.0 - 0.5 * (motor.weak_left + motor.weak_right)
    return {
        "command_delay": command.delay + 0.5 * command.delay_jitter,
        "motor_lag": motor.lag_v,
        "motor_lag_turning": motor.lag_omega,
        "gain_v": command.gain_v * strength,
        "gain_omega": command.gain_omega * strength,
        "deadband_v": command.deadband_v,
        "deadband_omega": command.deadband_omega,
    }


def _odometry(chair: WheelchairSettings) -> dict[str, float]:
    """The constant errors way' = (1 + e_s) way, turn' = (1 + e_t) turn + e_d way of encoder odometry.

    A wheel that is larger than nominal by r and slips by s moves the chair by (1 + r) (1 - s) for each metre that is
    counted. What patches of floor and load change is left to the observer.
    """
    wheels, floor, source = chair.wheels, chair.floor, chair.odometry
    left = 1.0 / ((1.0 + wheels.radius_error_left) * (1.0 - floor.slip_left))
    right = 1.0 / ((1.0 + wheels.radius_error_right) * (1.0 - floor.slip_right))
    mean, gyro = 0.5 * (left + right), source.yaw == GYRO
    return {
        "odometry_scale": mean - 1.0,
        "odometry_heading_scale": source.gyro_scale if gyro else (1.0 + wheels.track_error) * mean - 1.0,
        "odometry_heading_drift": 0.0 if gyro else (right - left) / wheels.track,
    }


def _with(parameters: T, values: dict[str, float]) -> T:
    """With those of the values that there are parameters for: nothing else can be told."""
    known: Any = {field.name for field in dataclasses.fields(parameters)}  # type: ignore[arg-type]
    told: Any = {name: value for name, value in values.items() if name in known}
    return dataclasses.replace(parameters, **told)  # type: ignore[type-var]
