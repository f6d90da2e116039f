"""The bay's speed limit put over a feedback law that knows of none."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from seater_common.geometry import Chair, Dock
from seater_eval.baselines.interface import PoseController


class SlowInBay:
    """Scales the law's speeds down, curvature kept, so that the chair can brake to the bay's limit ahead of the bay."""

    def __init__(self, law: PoseController, chair: Chair, dock: Dock) -> None:
        self._law, self._chair, self._entrance = law, chair, dock.bay.entrance_x
        self.name, self.period = law.name, law.period

    def reset(self) -> None:
        """See PoseController."""
        self._law.reset()

    def command(self, T_dock_base: ArrayLike, velocity: tuple[float, float]) -> tuple[float, float]:
        """See PoseController."""
        v, omega = self._law.command(T_dock_base, velocity)
        limits = self._chair.limits
        reach = float(np.max(self._chair.corners_at(T_dock_base)[:, 0]))
        left = max(0.0, self._entrance - reach - self.period * limits.v_max)
        allowed = math.sqrt(limits.v_bay_max**2 + 2.0 * limits.a_max * left)
        factor = min(1.0, allowed / abs(v)) if v != 0.0 else 1.0
        return factor * v, factor * omega
