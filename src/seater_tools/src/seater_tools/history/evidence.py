"""What many dockings say of the installation together.

Each docking estimates by how much mount and depths are off (seater_nmpc plausibility/installation/), with the
standard deviation that this estimate has where nothing is wrong; one docking is mostly sure to 10 mm only. The mean,
weighted by the inverse variances, is surer; what all dockings have in common (floors, castors, a slope at this dock) it
does not take away, which FLOOR stands for. The estimates lean to zero, so true values are larger than the mean.

Dockings that arrive alike cannot tell the camera's x from depths: 60 mm look like 1.4 % (measured, commissioning.md).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seater_tools.history.docking import Docking

NAMES = ("mount_x", "mount_y", "mount_yaw", "depth")
# Largest value that is no fault, and what the mean of any number of dockings may be off by: [m], [m], [rad], share.
OFF = {"mount_x": 0.015, "mount_y": 0.015, "mount_yaw": 0.0175, "depth": 0.03}
FLOOR = {"mount_x": 0.004, "mount_y": 0.004, "mount_yaw": 0.002, "depth": 0.004}
CERTAIN = 4.0  # standard deviations
FEWEST = 3  # dockings


@dataclass(frozen=True)
class Evidence:
    """Of one value: weighted mean, its standard deviation, dockings."""

    name: str
    value: float
    sd: float
    count: int

    @property
    def is_off(self) -> bool:
        """Surely beyond what is no fault."""
        return abs(self.value) > OFF[self.name] and abs(self.value) > CERTAIN * self.sd


def added_up(dockings: Sequence[Docking]) -> list[Evidence]:
    """Of the values that FEWEST dockings have."""
    found = []
    for name in NAMES:
        rows = np.array([(getattr(d, name), getattr(d, f"{name}_sd")) for d in dockings], dtype=float).reshape(-1, 2)
        rows = rows[np.all(np.isfinite(rows), axis=1) & (rows[:, 1] > 0.0)]
        if len(rows) < FEWEST:
            continue
        weights = rows[:, 1] ** -2.0
        mean = float(weights @ rows[:, 0] / weights.sum())
        found.append(Evidence(name, mean, math.hypot(float(weights.sum()) ** -0.5, FLOOR[name]), len(rows)))
    return found
