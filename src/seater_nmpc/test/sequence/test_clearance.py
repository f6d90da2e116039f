"""What keeps clear of walls and obstacles, beside the distances of single footprints."""

from __future__ import annotations

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock, polygon_distance
from seater_common.se2 import transform_points
from seater_nmpc.sequence.phases.clearance import keeps_clear

CHAIR = Chair()
AREAS = [*Dock().bay.outlines(), np.array([[-2.0, 0.9], [-1.4, 0.9], [-1.7, 1.5]])]
MARGINS = [0.3] * (len(AREAS) - 1) + [0.1]


def test_many_poses_at_once_are_as_each_by_itself() -> None:
    rng, ended = np.random.default_rng(1), []
    for _ in range(300):
        here = rng.uniform([-3.0, -1.2, -3.1], [-0.4, 1.2, 3.1])
        poses = here + rng.normal(size=(5, 3)) * [0.1, 0.1, 0.3]
        now = transform_points(here, CHAIR.corners())
        each = [
            polygon_distance(transform_points(pose, CHAIR.corners()), area)
            >= min(margin, polygon_distance(now, area) - 1e-3)
            for pose in poses
            for area, margin in zip(AREAS, MARGINS, strict=True)
        ]
        ended.append(all(each))
        assert keeps_clear(CHAIR, here, poses, AREAS, MARGINS) is ended[-1]
    assert 50 < sum(ended) < 250


@pytest.mark.parametrize(("turn", "clear"), [(-0.2, True), (0.2, False), (0.0, True)])
def test_who_stands_too_near_may_turn_away(turn: float, clear: bool) -> None:
    """Its left front corner 5 cm from a wall along x."""
    here = np.array([0.0, 0.0, 0.1])
    y = CHAIR.corners_at(here)[:, 1].max() + 0.05
    wall = np.array([[-1.0, y], [2.0, y], [2.0, y + 0.1], [-1.0, y + 0.1]])
    assert keeps_clear(CHAIR, here, [here + [0.0, 0.0, turn]], [wall], 0.1) is clear
