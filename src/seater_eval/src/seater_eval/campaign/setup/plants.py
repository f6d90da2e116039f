"""Random plants: what a variant's `plant: NAME` stands for, from the ranges in config/plants/NAME.yaml."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from seater_common.params import as_mapping
from seater_eval.campaign.setup.changes import merged
from seater_eval.campaign.setup.configuration import Files
from seater_sim.chair.plant_ranges import PlantRanges, load_plant_ranges
from seater_sim.settings import SimulatorSettings

FOLDER = "plants"


def check_plant(config: Path, name: str) -> None:
    """Raises ParameterError, naming file and key."""
    load_plant_ranges(config / FOLDER / f"{name}.yaml")


def drawn_plant(files: Files, name: str, rng: np.random.Generator) -> tuple[dict[str, Any], dict[str, Any]]:
    """Changes of simulator.yaml that make this plant, with the timing of its camera and odometry; and what was drawn,
    by keys `plant/...`: numbers, and texts where there was a choice."""
    ranges = files.get(f"{FOLDER}/{name}.yaml", "plant")
    made = PlantRanges(ranges).draw_simulator(rng, SimulatorSettings())
    drawn = {
        "wheelchair": as_mapping(made.plant.wheelchair),
        "camera": {"rate": made.camera.rate, "latency": made.camera.latency},
        "odometry": {"period": made.odometry.period},
    }
    changes = {
        "plant": {"kind": made.plant.kind, "wheelchair": drawn["wheelchair"]},
        "camera": drawn["camera"],
        "odometry": drawn["odometry"],
    }
    varied: dict[str, Any] = {}
    _collect(ranges, drawn, "plant", varied)
    return changes, varied


def with_plant(changes: Mapping[str, Any], simulator: Mapping[str, Any]) -> dict[str, Any]:
    """A variant's changes with its plant in the place of the name; its own keys of the simulator win."""
    rest = {key: value for key, value in changes.items() if key != "plant"}
    return rest | {"simulator": merged(simulator, rest.get("simulator", {}))}


def _collect(ranges: Any, drawn: Any, key: str, varied: dict[str, Any]) -> None:
    """The values whose range leaves a choice."""
    if isinstance(ranges, Mapping):
        for name, entry in ranges.items():
            _collect(entry, drawn[name], f"{key}/{name}", varied)
    elif len(set(ranges)) > 1:
        varied[key] = drawn
