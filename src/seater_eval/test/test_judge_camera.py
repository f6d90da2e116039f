"""The independent chair's camera: what it sees, and how far off the poses are."""

import math
from pathlib import Path

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock
from seater_common.se2 import inverse
from seater_eval.judge.parts import load_files
from seater_eval.judge.plant.camera import DockCamera, crosses
from seater_eval.judge.plant.effects import Pictures
from seater_nmpc.observe.measurement import difference, project

CONFIG = Path(__file__).resolve().parents[3] / "config"
QUIET = Pictures(outliers=0.0, flips=0.0)
AHEAD = (-2.0, 0.0, 0.0)


def camera(pictures: Pictures = QUIET, seed: int = 1) -> DockCamera:
    return DockCamera(Chair(), Dock(), pictures, np.random.default_rng(seed))


def ids(pose: tuple[float, float, float], pictures: Pictures = QUIET) -> list[int]:
    return [marker.id for marker in camera(pictures).seen(pose)]


def test_what_is_in_the_field_of_view() -> None:
    assert ids(AHEAD) == [0, 1, 2]
    assert ids((-2.0, 0.0, 0.72)) == [1]  # the left edge of the view is 4 degrees right of the axis
    assert ids((-2.0, 0.0, math.pi)) == []
    assert ids((-4.0, 0.0, 0.0)) == [1, 2]  # marker 0 is too small beyond 4 m
    assert ids((0.0, 0.0, 0.0)) == [0, 1, 2]  # docked: the outer ones just fit into 90 degrees
    assert ids((0.0, 0.0, 0.0), Pictures(view=math.radians(80.0))) == [0]


def test_side_walls_hide_markers() -> None:
    beside = (-0.6, 1.3, -0.7)  # outside, left of the left wall: it sees past the wall's end only to the right
    with_walls, without = ids(beside), [marker.id for marker in _without_walls().seen(beside)]
    assert 1 in without and 1 not in with_walls
    assert set(with_walls) < set(without)


def _without_walls() -> DockCamera:
    open_dock = camera()
    open_dock._walls = []
    return open_dock


def test_a_way_crosses_a_box() -> None:
    box = (1.0, 1.0, 2.0, 2.0)
    assert crosses(0.0, 0.0, 3.0, 3.0, box) and crosses(1.5, 0.0, 1.5, 3.0, box) and crosses(0.0, 1.5, 1.2, 1.5, box)
    assert not crosses(0.0, 0.0, 0.9, 0.9, box) and not crosses(0.5, 0.0, 0.5, 3.0, box)
    assert not crosses(0.0, 1.5, 0.9, 1.5, box) and not crosses(0.0, 2.1, 3.0, 2.1, box)


@pytest.mark.parametrize("pose", [AHEAD, (-3.3, 0.9, -0.3), (0.0, 0.0, 0.0), (-1.5, -0.8, 0.5)])
def test_covariances_are_honest(pose: tuple[float, float, float]) -> None:
    one, T = camera(), Chair().camera.T_base_optical()
    squares = []
    for _ in range(800):
        planar = project(T, one.look(pose)[0])
        assert planar is not None and planar.tilt < 0.1
        error = difference(planar.measurement.pose, inverse(pose))
        squares.append(error @ np.linalg.solve(planar.measurement.covariance, error))
    assert np.mean(squares) == pytest.approx(3.0, abs=0.3)  # deviation of the mean: sqrt(6 / 800) = 0.09


def test_noise_grows_with_distance_and_can_be_switched_off() -> None:
    def sd(x: float) -> np.ndarray:
        return np.sqrt(np.diag(camera().look((x, 0.0, 0.0))[0].covariance))

    assert np.all(sd(-3.0) > sd(-1.0)) and 0.001 < sd(-1.0)[2] < 0.01
    exact = camera(Pictures(outliers=0.0, flips=0.0, noise=0.0)).look(AHEAD)[0]
    planar = project(Chair().camera.T_base_optical(), exact)
    assert planar is not None and planar.measurement.pose == pytest.approx(inverse(AHEAD), abs=1e-12)


def test_outliers_come_in_their_share_and_are_far_off() -> None:
    one, T = camera(Pictures(outliers=0.03, flips=0.0)), Chair().camera.T_base_optical()
    off = []
    for _ in range(2000):
        planar = project(T, one.look(AHEAD)[0])
        assert planar is not None
        off.append(math.dist(planar.measurement.pose[:2], inverse(AHEAD)[:2]))
    assert np.mean(np.array(off) > 0.025) == pytest.approx(0.03, abs=0.012)  # three deviations
    assert max(off) > 0.2


def test_flips_are_mirrored_about_the_line_of_sight() -> None:
    pose = (-1.5, -0.8, 0.5)
    one, T = camera(Pictures(outliers=0.0, flips=1.0, noise=0.0)), Chair().camera.T_base_optical()
    looks = [one.look(pose) for _ in range(300)]
    alone = [look for look in looks if len(look) == 1]
    assert len(alone) / 300 == pytest.approx(0.3, abs=0.08)
    right, flipped = next(look for look in looks if len(look) == 2)
    assert right.weight + flipped.weight == pytest.approx(1.0)
    both = [project(T, hypothesis) for hypothesis in (right, flipped)]
    assert both[0] is not None and both[1] is not None
    poses = [planar.measurement.pose for planar in both if planar is not None]
    centres = [p[:2] + 0.9 * np.array([math.cos(p[2]), math.sin(p[2])]) for p in poses]
    assert centres[0] == pytest.approx(centres[1], abs=1e-9)  # the markers stay where they are
    sight = math.atan2(centres[0][1], centres[0][0] - Chair().camera.x)
    assert poses[0][2] - sight == pytest.approx(sight - poses[1][2], abs=1e-9)


def test_a_single_marker_leaves_both_poses_open_in_every_image() -> None:
    dock = load_files(str(CONFIG), markers=1).dock
    assert [marker.id for marker in dock.markers] == [0]
    pictures = Pictures(outliers=0.0, flips=0.0, ambiguous=True)
    means = []
    for seed in range(30):
        one = DockCamera(Chair(), dock, pictures, np.random.default_rng(seed))
        means.append(np.mean([one.look(AHEAD)[0].weight for _ in range(50)]))
        assert len(one.look(AHEAD)) == 2
    assert min(means) < 0.5 < max(means)  # in some runs light and print speak for the flip
