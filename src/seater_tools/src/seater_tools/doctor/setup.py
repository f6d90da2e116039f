"""What the files mean, as the nodes load them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, load
from seater_nmpc.parameters import NmpcParameters
from seater_obstacles.settings import ObstacleSettings

KINDS: dict[str, type] = {"chair": Chair, "dock": Dock, "camera": CameraModel, "controller": NmpcParameters}
KINDS_ALONE: dict[str, type] = {"obstacles": ObstacleSettings}  # of which nothing but their order is asked


@dataclass(frozen=True)
class FileSeen:
    """A file of configuration. `error`: why it cannot be read; `refused`: what the program that reads it says."""

    path: str
    text: str = ""
    values: Any = None  # as YAML gives them
    error: str = ""
    refused: str = ""


@dataclass(frozen=True)
class Setup:
    """None where a file is not in order, or not named."""

    chair: Chair | None
    dock: Dock | None
    camera: CameraModel | None
    controller: NmpcParameters | None


def setup_of(files: Mapping[str, FileSeen]) -> Setup:
    """Whatever can be read."""
    return Setup(**{role: parsed(files[role], role)[0] if role in files else None for role in KINDS})


def parsed(file: FileSeen, role: str) -> tuple[Any, str]:
    """What it means (None of a role without a type here), and what is wrong with it (empty: nothing)."""
    if file.error:
        return None, file.error
    kind = KINDS.get(role) or KINDS_ALONE.get(role)
    try:
        if kind is CameraModel:
            return CameraModel.from_mapping(file.values, file.path), file.refused
        return None if kind is None else load(kind, file.values, file.path), file.refused
    except ParameterError as error:
        return None, str(error)
