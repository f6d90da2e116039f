"""The simulated camera that all perception results are measured with (config/cameras/degraded.yaml)."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.params import ParameterError, read_yaml

RANGES = {
    "image_width": (64, 8192),
    "image_height": (64, 8192),
    "focal_length": (10.0, 1e5),
    "blur_sd": (0.0, 10.0),
    "noise_sd": (0.0, 100.0),
    "black": (0.0, 255.0),
    "white": (0.0, 255.0),
    "wall": (0.0, 255.0),
    "quiet_zone": (0.5, 10.0),
}


@dataclass(frozen=True)
class DegradedCamera:
    """Pinhole camera without distortion, principal point in the middle; see the file for each key's meaning."""

    image_width: int  # [px]
    image_height: int  # [px]
    focal_length: float  # [px]
    blur_sd: float  # [px]
    noise_sd: float  # [grey levels]
    black: float  # [grey levels] of ink
    white: float  # [grey levels] of paper
    wall: float  # [grey levels] round the paper
    quiet_zone: float  # [cells] of paper round the print

    @property
    def K(self) -> NDArray[np.float64]:
        """(3, 3) [px]."""
        cx, cy = 0.5 * (self.image_width - 1), 0.5 * (self.image_height - 1)
        return np.array([[self.focal_length, 0.0, cx], [0.0, self.focal_length, cy], [0.0, 0.0, 1.0]])

    @property
    def levels(self) -> tuple[float, float, float]:
        """(ink, paper, wall) [grey levels]."""
        return self.black, self.white, self.wall

    def resized(self, width: int, height: int) -> DegradedCamera:
        """The same view angle (horizontally) at another resolution."""
        focal = self.focal_length * width / self.image_width
        return replace(self, image_width=width, image_height=height, focal_length=focal)


def load_degraded_camera(path: str | Path) -> DegradedCamera:
    """Raises ParameterError naming file, key, value and what is allowed."""
    values = read_yaml(path)
    known = {f.name: f.type for f in fields(DegradedCamera)}
    if not isinstance(values, dict):
        raise ParameterError(f"{path}: is {values!r}, must be a mapping")
    problems = [f"{path}/{key}: unknown key; known are {', '.join(known)}" for key in values if key not in known]
    for key, kind in known.items():
        low, high = RANGES[key]
        value: Any = values.get(key)
        wanted = "a whole number" if kind == "int" else "a number"
        good = isinstance(value, int if kind == "int" else int | float) and not isinstance(value, bool)
        if not good or not low <= value <= high:
            problems.append(f"{path}/{key}: is {value!r}, must be {wanted} from {low} to {high}")
    if problems:
        raise ParameterError("\n".join(problems))
    return DegradedCamera(**values)
