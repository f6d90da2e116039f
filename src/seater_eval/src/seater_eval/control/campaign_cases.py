"""The cases of a campaign: starts from which a marker is seen, and obstacles."""

from __future__ import annotations

import math

import numpy as np

from seater_common.geometry import clearance, polygon_distance
from seater_eval.control.campaign_run import Case, draw_start
from seater_eval.control.pose_noise import DockSensor, NoiseModel
from seater_eval.run.parallel import job_seed
from seater_eval.run.setup_files import Setup


def draw_cases(setup: Setup, runs: int, seed: int, noise: NoiseModel, obstacles: bool) -> list[Case]:
    """The same for the same seed, whatever `runs` is beyond them."""
    sensor = DockSensor(setup.chair, setup.dock, setup.camera, noise)
    cases = []
    for index in range(runs):
        rng = np.random.default_rng([seed, index])
        start = draw_start(
            setup.chair, setup.dock, sensor, lambda pose: clearance(setup.chair, setup.dock.bay, pose), rng
        )
        outlines = _draw_obstacles(setup, start, rng) if obstacles else ()
        cases.append(Case(index, start, job_seed(seed, index), outlines))
    return cases


def _draw_obstacles(
    setup: Setup, start: tuple[float, float, float], rng: np.random.Generator
) -> tuple[tuple[float, ...], ...]:
    """Up to two convex polygons, clear of the start, of the bay and of the straight way into it."""
    reach, half = setup.dock.predock_x - setup.chair.length_rear - 0.6, 0.5 * setup.dock.bay.width + 0.25
    lane = np.array(
        [[reach, -half], [setup.dock.bay.back_wall_x, -half], [setup.dock.bay.back_wall_x, half], [reach, half]]
    )
    chair, found = setup.chair.corners_at(start), []
    for _ in range(int(rng.integers(0, 3))):
        corners, size = int(rng.integers(3, 7)), rng.uniform(0.1, 0.3)
        turn, middle = rng.uniform(0.0, 2.0 * math.pi), rng.uniform([-3.5, -2.2], [-0.3, 2.2])
        angles = turn + 2.0 * math.pi * np.arange(corners) / corners
        outline = middle + size * np.column_stack([np.cos(angles), np.sin(angles)])
        if polygon_distance(outline, chair) >= 0.4 and polygon_distance(outline, lane) >= 0.05:
            found.append(tuple(float(value) for value in outline.ravel()))
    return tuple(found)
