import math

import numpy as np
import pytest

from seater_common.geometry import Bay, Chair, clearance, polygon_distance
from seater_common.se2 import arc_step
from seater_common.way_clearance import smallest_clearance

CHAIR, BAY = Chair(), Bay()
BOX = np.array([[-2.0, 0.2], [-1.7, 0.2], [-1.7, 0.5], [-2.0, 0.5]])


def way(seed: int) -> list[np.ndarray]:
    """Arcs from in front of the bay, forward and backward; some end in a wall."""
    rng = np.random.default_rng(seed)
    poses = [np.array([rng.uniform(-3.0, -0.8), rng.uniform(-0.6, 0.6), rng.uniform(-math.pi, math.pi)])]
    for _ in range(20):
        v, omega = rng.uniform(-0.3, 0.5), rng.uniform(-0.6, 0.6)
        for _ in range(20):
            poses.append(arc_step(poses[-1], v, omega, 0.02))
    return poses


@pytest.mark.parametrize("obstacles", [[], [BOX]], ids=["walls", "walls and a box"])
def test_it_is_the_smallest_of_all_poses(obstacles: list[np.ndarray]) -> None:
    found = []
    for seed in range(12):
        poses = way(seed)
        boxes = [polygon_distance(CHAIR.corners_at(pose), box) for pose in poses for box in obstacles]
        found.append(smallest_clearance(CHAIR, BAY, poses, obstacles))
        assert found[-1] == min([*(clearance(CHAIR, BAY, pose) for pose in poses), *boxes])
    assert min(found) < 0.0 < max(found)


def test_an_array_of_one_pose_counts() -> None:
    pose = np.array([[-1.0, 0.1, 0.2]])
    assert smallest_clearance(CHAIR, BAY, pose) == clearance(CHAIR, BAY, pose[0])
