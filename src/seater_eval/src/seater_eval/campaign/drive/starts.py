"""Where a case begins."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_eval.campaign.drive import tools
from seater_eval.campaign.drive.chain import Perception
from seater_eval.campaign.drive.docking import grey
from seater_eval.campaign.setup.campaign_file import Start
from seater_eval.campaign.setup.cases import STREAM_START
from seater_eval.campaign.setup.configuration import Configuration
from seater_sim.camera.camera import Camera
from seater_sim.world.contact import Walls

Array = NDArray[np.float64]

_TRIES = 1000


class NoStartError(ValueError):
    """No pose of the wanted kind was found."""


def draw_start(c: Configuration, seed: int) -> tuple[Array, Array | None]:
    """base_link in the true dock frame, (3,), and the rough pose of the dock there, (3,), if the goal is to carry one.

    Raises NoStartError.
    """
    rng = np.random.default_rng([seed, STREAM_START])
    obstacles = [obstacle.polygon() for obstacle in c.simulator.obstacles]
    walls = Walls(c.simulated_chair, c.simulated_dock.bay, obstacles)
    perception, camera = Perception(c), tools.camera(c)
    for _ in range(_TRIES):
        pose = _draw(c.start, rng) + np.array([0.0, 0.0, c.simulated_dock.docked_pose[2]])
        if walls.distance(pose) < c.start.clearance:
            continue
        if not c.start.seen or _finds(perception, camera, pose, seed):
            return pose, _rough_pose(c.start, rng)
    seen = " and had the dock in view" if c.start.seen else ""
    raise NoStartError(f"start: none of {_TRIES} poses was {c.start.clearance} m clear of the walls{seen}")


def _finds(perception: Perception, camera: Camera, pose: Array, seed: int) -> bool:
    """Whether perception finds the dock in the image from there; drawn only where a whole marker is in the image."""
    high = np.array([camera.model.width, camera.model.height]) - 0.5
    inside = (bool(np.all((px >= -0.5) & (px <= high))) for px in camera.marker_corners(pose).values())
    return any(inside) and perception.finds(grey(camera.render(pose, seed=seed)))


def _draw(start: Start, rng: np.random.Generator) -> Array:
    x, y, heading = (rng.uniform(low, high) for low, high in (start.x, start.y, start.heading))
    sign = -1.0 if rng.integers(2) and start.mirror else 1.0
    return np.array([x, sign * y, sign * math.radians(heading)])


def _rough_pose(start: Start, rng: np.random.Generator) -> Array | None:
    errors = rng.standard_normal(3)
    sd = np.array([start.rough_position_sd, start.rough_position_sd, math.radians(start.rough_heading_sd)])
    return errors * sd if start.rough_pose else None
