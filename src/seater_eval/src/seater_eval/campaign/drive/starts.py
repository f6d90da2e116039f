"""Where a case begins."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from seater_eval.campaign.drive import tools
from seater_eval.campaign.drive.chain import Perception
from seater_eval.campaign.drive.docking import grey
from seater_eval.campaign.drive.without_images import PoseSensor
from seater_eval.campaign.setup.campaign_file import Start
from seater_eval.campaign.setup.cases import STREAM_START
from seater_eval.campaign.setup.configuration import Configuration
from seater_sim.world.contact import Walls

Array = NDArray[np.float64]

_TRIES = 1000


class NoStartError(ValueError):
    """No pose of the wanted kind was found."""


def draw_start(c: Configuration, seed: int, *, images: bool = True) -> tuple[Array, Array | None]:
    """base_link in the true dock frame, (3,), and the rough pose of the dock there, (3,), if the goal is to carry one.

    `images`: whether the dock is seen is decided by perception on an image, else by the size of its markers. Raises
    NoStartError.
    """
    rng = np.random.default_rng([seed, STREAM_START])
    obstacles = [obstacle.polygon() for obstacle in c.simulator.obstacles]
    walls = Walls(c.simulated_chair, c.simulated_dock.bay, obstacles)
    finds = _eyes(c, seed) if images else PoseSensor(c, seed).finds
    for _ in range(_TRIES):
        pose = _draw(c.start, rng) + np.array([0.0, 0.0, c.simulated_dock.docked_pose[2]])
        if walls.distance(pose) < c.start.clearance:
            continue
        if not c.start.seen or finds(pose):
            return pose, _rough_pose(c.start, rng)
    seen = " and had the dock in view" if c.start.seen else ""
    raise NoStartError(f"start: none of {_TRIES} poses was {c.start.clearance} m clear of the walls{seen}")


def _eyes(c: Configuration, seed: int) -> Callable[[Array], bool]:
    """Whether perception finds the dock in the image from a pose; drawn only where a whole marker is in the image."""
    perception, camera = Perception(c), tools.camera(c)
    high = np.array([camera.model.width, camera.model.height]) - 0.5

    def finds(pose: Array) -> bool:
        inside = (bool(np.all((px >= -0.5) & (px <= high))) for px in camera.marker_corners(pose).values())
        return any(inside) and perception.finds(grey(camera.render(pose, seed=seed)))

    return finds


def _draw(start: Start, rng: np.random.Generator) -> Array:
    x, y, heading = (rng.uniform(low, high) for low, high in (start.x, start.y, start.heading))
    sign = -1.0 if rng.integers(2) and start.mirror else 1.0
    return np.array([x, sign * y, sign * math.radians(heading)])


def _rough_pose(start: Start, rng: np.random.Generator) -> Array | None:
    errors = rng.standard_normal(3)
    sd = np.array([start.rough_position_sd, start.rough_position_sd, math.radians(start.rough_heading_sd)])
    return errors * sd if start.rough_pose else None
