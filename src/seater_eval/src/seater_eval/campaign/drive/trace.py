"""What is written down while a docking runs: the truth at every step, every control cycle, every image."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TRUTH = ("time", "x", "y", "heading", "v", "omega")
CYCLE = ("time", "phase", "asked_v", "asked_omega", "v", "omega", "error_x", "error_y", "error_heading", "age")
IMAGE = ("time", "markers", "outcome")


@dataclass
class Trace:
    """Rows of numbers; times [s] since the goal, poses in the true dock frame [m, m, rad], speeds [m/s, rad/s].

    A cycle has what the docking node asked for, what the gate passed on, and how far the estimated pose of the chair is
    from the true one (NaN while the dock is not known); an image the number of markers found and what the observer made
    of it (seater_nmpc's Outcome).
    """

    truth_rows: list[tuple[float, ...]] = field(default_factory=list)
    cycle_rows: list[tuple[float, ...]] = field(default_factory=list)
    image_rows: list[tuple[float, ...]] = field(default_factory=list)

    @property
    def truth(self) -> Array:
        """Columns TRUTH."""
        return np.array(self.truth_rows).reshape(-1, len(TRUTH))

    @property
    def cycles(self) -> Array:
        """Columns CYCLE."""
        return np.array(self.cycle_rows).reshape(-1, len(CYCLE))

    @property
    def images(self) -> Array:
        """Columns IMAGE."""
        return np.array(self.image_rows).reshape(-1, len(IMAGE))


@dataclass
class Clock:
    """Processor time [s] that each part of a run has taken."""

    seconds: dict[str, float] = field(default_factory=dict)

    def add(self, part: str, seconds: float) -> None:
        """So much more."""
        self.seconds[part] = self.seconds.get(part, 0.0) + seconds
