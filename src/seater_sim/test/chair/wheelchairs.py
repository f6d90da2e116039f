"""Chairs with single effects, for the tests of the plant `wheelchair`."""

import dataclasses

from seater_common.geometry import Limits
from seater_sim.chair.wheelchair import WheelchairPlant
from seater_sim.settings import WheelchairSettings, without_effects

STEP, SECONDS = 10_000_000, 0.01  # of a step
TRACK = WheelchairSettings().wheels.track
LIMITS = Limits(v_max=3.0, v_reverse_max=3.0, omega_max=4.0)
START = (0.0, 0.0, 0.0)


def only(**parts: dict[str, float | int | str]) -> WheelchairSettings:
    """Settings with every effect off but those given, such as motor={"lag_v": 0.2}."""
    off = without_effects()
    parts = {"command": {"timeout": 1000.0}} | parts
    return dataclasses.replace(
        off, **{name: dataclasses.replace(getattr(off, name), **keys) for name, keys in parts.items()}
    )


def make(
    settings: WheelchairSettings, pose: tuple[float, float, float] = START, seed: int = 1, limits: Limits = LIMITS
) -> WheelchairPlant:
    return WheelchairPlant(settings, limits, pose, seed)


def drive(plant: WheelchairPlant, steps: int, v: float = 0.0, omega: float = 0.0) -> list[tuple[float, float]]:
    """(v, omega) of each step; the command is repeated before each."""
    speeds = []
    for _ in range(steps):
        plant.command(v, omega)
        plant.step(STEP)
        speeds.append((plant.v, plant.omega))
    return speeds
