"""What the controller is told about the plant that it drives."""

from __future__ import annotations

import importlib.util
from dataclasses import replace

from seater_common.params import ParameterError
from seater_nmpc.parameters import NmpcParameters
from seater_sim.settings import SimulatorSettings

DEFAULTS, TRUTH, IDENTIFIED = "defaults", "truth", "identified"
CHOICES = (DEFAULTS, TRUTH, IDENTIFIED)


def check_told(told: str) -> None:
    """Raises ParameterError when the parameters cannot be had in this way."""
    if told not in CHOICES:
        raise ParameterError(f"--told: is {told!r}, must be one of {', '.join(CHOICES)}")
    if told == IDENTIFIED and importlib.util.find_spec("seater_identify") is None:
        raise ParameterError("--told identified: needs the package seater_identify, which is not installed here")


def told_parameters(parameters: NmpcParameters, simulator: SimulatorSettings, told: str) -> NmpcParameters:
    """`defaults`: those of controller.yaml; `truth`: the plant's own delay and lag in their place."""
    if told == DEFAULTS:
        return parameters
    plant = simulator.plant.kinematic
    prediction = replace(
        parameters.control.prediction, command_delay=plant.command_delay, solve_latency=0.0, motor_lag=plant.lag_v
    )
    return replace(parameters, control=replace(parameters.control, prediction=prediction))
