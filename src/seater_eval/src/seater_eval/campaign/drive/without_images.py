"""Dockings of a campaign without images: the dock's pose with the error that perception would make, at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from seater_eval.campaign.setup.configuration import Configuration
from seater_eval.control.pose_noise import DockSensor
from seater_nmpc.observe.measurement import Hypothesis
from seater_sim.loop.simulator import SimulatedImage

_STREAM = 7  # of the random numbers that follow from a case's seed


class PoseSensor:
    """In the place of rendering and perception. Errors of mount and markers are in it as they are in images; obstacles
    hide nothing."""

    def __init__(self, c: Configuration, seed: int) -> None:
        self._sensor = DockSensor(c.simulated_chair, c.simulated_dock, c.simulated_camera)
        self._rng = np.random.default_rng([seed, _STREAM])

    def finds(self, pose: ArrayLike) -> bool:
        """Whether a marker is found from there (base_link in the true dock frame)."""
        return bool(self._sensor.visible(pose))

    def measure(self, image: SimulatedImage) -> tuple[list[Hypothesis], int]:
        """The dock's pose in the optical frame at the time of the image, and how many markers are seen."""
        return self._sensor.measure(image.pose, self._rng), len(self._sensor.visible(image.pose))
