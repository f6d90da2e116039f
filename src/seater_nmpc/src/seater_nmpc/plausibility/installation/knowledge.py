"""What dockings have shown of the installation, and whether that is a wrong one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NAMES = ("the camera's x", "the camera's y", "the camera's yaw", "focal length or print size")
KEYS = ("mount_x", "mount_y", "mount_yaw", "depth")  # the same, short
PLACES = (0, 1)  # indices into NAMES
PRIOR = np.array([0.03, 0.03, 0.03, 0.05])  # standard deviations before anything was measured
SLIPS = (0.15, 0.4, 1.0, 4.0)  # of tyres, times what the observer reckons with: a filter for each
# Over dockings, what patches of floor and castors did in one of them is no longer taken for the installation: of 64 in
# series of 8 without a fault none was beyond 2.3 standard deviations, so from the fourth docking on fewer are certain.
SERIES, _SURER = 4, 0.8
# [m, m, rad] What many dockings without turns leave unknown of where the docked chair stands: castors and slip do the
# same in each of them, so it does not average out. With a camera 30 mm ahead (25 mm aside), eight dockings of each of
# three chairs found what was up to 22 mm (20 mm) off, with standard deviations of 8 to 9 mm (4 to 5 mm).
_TOGETHER = np.array([0.02, 0.02, 0.0])


@dataclass(frozen=True)
class Knowledge:
    """What dockings so far have shown of the installation, by each filter."""

    dockings: int
    values: Array  # (k, 4) of NAMES
    covariances: Array  # (k, 4, 4)
    turned: bool = False  # for it, at two places: CHECK_INSTALLATION


def without_turns(spread: Array) -> Array:
    """What is unknown (3, 3) of where the docked chair stands, by dockings none of which has turned to see."""
    return np.asarray(spread + np.diag(np.maximum(np.square(_TOGETHER) - np.diag(spread), 0.0)))


def nothing_known() -> Knowledge:
    """Before the first docking."""
    k = len(SLIPS)
    return Knowledge(0, np.zeros((k, 4)), np.tile(np.diag(PRIOR**2), (k, 1, 1)))


@dataclass(frozen=True)
class InstallationError:
    """What the docking, and those before it, found."""

    values: Array  # (4,) of NAMES
    noise: Array  # (4, 4) covariance that these values have where the installation is right
    effects: Array  # (3, 4) of each on where the docked chair stands, or the dock is: x, y [m], heading [rad]
    spread: Array  # (3, 3) covariance of that by what is still unknown
    dockings: int = 0  # before this one

    @property
    def final(self) -> Array:
        """By which the docked chair is off because of all of them, x, y [m], heading [rad] (3,)."""
        return np.asarray(self.effects.sum(axis=1))

    @property
    def suspect(self) -> int:
        """Index into NAMES of the value that is farthest from right, in standard deviations."""
        return int(np.argmax(self._sure))

    def is_wrong(self, limits: Array, certainty: float) -> bool:
        """Whether one value, or all together, surely lead to a final error beyond the limits (3,) [m, m, rad].

        `certainty`: standard deviations that the value, or the error, is from zero, in a first docking.
        """
        certainty *= _SURER if self.dockings + 1 >= SERIES else 1.0
        alone = (np.abs(self.effects) > limits[:, None]) & (self._sure > certainty)
        per_value = self.effects / np.where(self.values == 0.0, 1.0, self.values)
        sds = np.sqrt(np.diag(per_value @ self.noise @ per_value.T)) + 1e-9
        together = (np.abs(self.final) > limits) & (np.abs(self.final) > certainty * sds)
        return bool(np.any(alone) or np.any(together))

    @property
    def certainty(self) -> float:
        """Of the value that is farthest from right, in standard deviations."""
        return float(np.max(self._sure))

    @property
    def _sure(self) -> Array:
        return np.asarray(np.abs(self.values) / np.sqrt(np.diag(self.noise) + 1e-12))
