"""Random chairs: config/plants/*.yaml gives a range for every parameter of the plant `wheelchair`.

A number has the range [low, high] (both the same: fixed), a choice the list of what is drawn from. With the chair comes
the timing of its camera and odometry.
"""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from seater_common.params import ParameterError, load, param, read_yaml
from seater_sim.settings import WHEELCHAIR, SimulatorSettings, WheelchairSettings


@dataclass(frozen=True)
class CameraTiming:
    """As in the simulator's `camera`."""

    rate: float = param(30.0, "Hz", "images per second", low=0.1, high=120.0)
    latency: float = param(0.05, "s", "from the middle of the exposure to delivery", low=0.0, high=1.0)


@dataclass(frozen=True)
class OdometryTiming:
    """As in the simulator's `odometry`."""

    period: float = param(0.02, "s", "between two messages", low=0.001, high=1.0)


@dataclass(frozen=True)
class _Drawn:
    """One draw: the form of the file, with a value in place of each range."""

    wheelchair: WheelchairSettings = field(default_factory=WheelchairSettings)
    camera: CameraTiming = field(default_factory=CameraTiming)
    odometry: OdometryTiming = field(default_factory=OdometryTiming)


@dataclass(frozen=True)
class PlantRanges:
    """Ranges of one kind of chair, checked. Same generator, same draw, whatever the order of the file."""

    ranges: Mapping[str, Any]  # nested as the file

    def draw(self, rng: np.random.Generator) -> WheelchairSettings:
        """A chair, each parameter uniform in its range and independent of the others."""
        drawn: WheelchairSettings = _draw(WheelchairSettings, self.ranges["wheelchair"], rng)
        return drawn

    def draw_simulator(self, rng: np.random.Generator, settings: SimulatorSettings) -> SimulatorSettings:
        """`settings` with a chair as by `draw`, which is driven, and the timing of its camera and odometry; the
        odometry's period is rounded to whole steps."""
        plant = dataclasses.replace(settings.plant, kind=WHEELCHAIR, wheelchair=self.draw(rng))
        camera: CameraTiming = _draw(CameraTiming, self.ranges["camera"], rng)
        odometry: OdometryTiming = _draw(OdometryTiming, self.ranges["odometry"], rng)
        steps = max(1, round(odometry.period / settings.step))
        return dataclasses.replace(
            settings,
            plant=plant,
            camera=dataclasses.replace(settings.camera, rate=camera.rate, latency=camera.latency),
            odometry=dataclasses.replace(settings.odometry, period=round(steps * settings.step, 9)),
        )


def load_plant_ranges(path: str | Path) -> PlantRanges:
    """From config/plants/NAME.yaml.

    Raises:
        ParameterError: naming file and key of all that is missing, unknown, no range, or beyond what the parameter may
            be.
    """
    values = read_yaml(path)
    problems: list[str] = []
    longest = _check_leaves(values, str(path), problems)
    if problems:
        raise ParameterError("wrong ranges:\n  " + "\n  ".join(problems))
    for index in range(longest):  # low ends, high ends and every choice are possible values of their parameters
        load(_Drawn, _pick(values, index), str(path))
    return PlantRanges(values)


def _check_leaves(values: Any, key: str, problems: list[str]) -> int:
    """Complain about leaves that are no ranges; the length of the longest."""
    if isinstance(values, Mapping):
        return max((_check_leaves(v, f"{key}/{name}", problems) for name, v in values.items()), default=1)
    if not isinstance(values, list) or not values:
        problems.append(f"{key}: is {values!r}, must be a range [low, high] or a list of choices")
        return 1
    if any(isinstance(v, int | float) and not isinstance(v, bool) for v in values):
        numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
        if not numbers or len(values) != 2 or not values[0] <= values[1]:
            problems.append(f"{key}: is {values!r}, must be [low, high] with low <= high")
    return len(values)


def _pick(values: Any, index: int) -> Any:
    """The file's form with the entry number `index` of each leaf, or its last one."""
    if isinstance(values, Mapping):
        return {name: _pick(v, index) for name, v in values.items()}
    return values[min(index, len(values) - 1)]


def _draw(cls: type, ranges: Mapping[str, Any], rng: np.random.Generator) -> Any:
    """An instance of the dataclass `cls`; one random number for each field, in the order of the fields."""
    hints, drawn = typing.get_type_hints(cls), {}
    for entry in dataclasses.fields(cls):
        kind, values = hints[entry.name], ranges[entry.name]
        if dataclasses.is_dataclass(kind):
            drawn[entry.name] = _draw(typing.cast(type, kind), values, rng)
        elif kind is float:
            drawn[entry.name] = float(values[0] + (values[1] - values[0]) * rng.random())
        elif kind is int:
            drawn[entry.name] = int(rng.integers(values[0], values[1], endpoint=True))
        else:
            drawn[entry.name] = values[int(rng.integers(len(values)))]
    return cls(**drawn)
