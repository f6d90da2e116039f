"""A sensor that does not see stops the chair, whatever it says instead."""

import math

import numpy as np
import pytest
from scenes import box, scan

from seater_common.geometry import CameraMount, Chair, Dock
from seater_obstacles.depth import DepthImages, cloud_sight
from seater_obstacles.finder import ObstacleFinder
from seater_obstacles.scan import scan_sight
from seater_obstacles.settings import ObstacleSettings, SenseSettings
from seater_obstacles.sight import Sight
from seater_obstacles.watch import SensorFailsError, SensorWatch

ORIGIN = np.zeros(3)
ROOM = [box(3.0, 0.0, 0.1, 3.0)]
K = np.array([[640.0, 0.0, 640.0], [0.0, 640.0, 360.0], [0.0, 0.0, 1.0]])


def watch() -> SensorWatch:
    return SensorWatch(ObstacleSettings().cluster.min_points)


def of_scan(r: np.ndarray, low: float = 0.05, high: float = 8.0) -> Sight:
    return scan_sight(r, -2.0, 0.01, (low, high), np.eye(4), 4.0)


def of_depth(value: float) -> Sight:
    cloud = DepthImages(8).cloud(np.full((720, 1280), value, np.float32), K)
    return cloud_sight(cloud, CameraMount().T_base_optical(), SenseSettings())


@pytest.mark.parametrize(
    "sight",
    [
        of_scan(np.full(401, math.inf)),
        of_scan(np.full(401, math.nan)),
        of_scan(np.zeros(401)),
        of_scan(np.full(401, 9.0)),
        of_scan(np.full(401, 2.0), high=0.1),
        of_scan(np.empty(0)),
        of_depth(0.0),
        of_depth(math.nan),
        cloud_sight(np.empty((0, 3)), np.eye(4), SenseSettings()),
    ],
)
def test_one_that_meets_nothing_at_all_is_not_believed(sight: Sight) -> None:
    with pytest.raises(SensorFailsError, match="nothing at all"):
        watch().check(sight, b"", ORIGIN)


def test_a_depth_camera_in_front_of_the_back_wall_may_meet_nothing() -> None:
    """Docked, the camera is 0.45 m from it."""
    finder, w = ObstacleFinder(ObstacleSettings(), Chair(), Dock()), watch()
    for ahead, near in ((0.0, True), (0.05, True), (0.3, True), (1.2, False)):
        base, sight = np.array([-ahead, 0.0, 0.0]), of_depth(0.0)
        assert finder.near_dock(sight, base, ORIGIN) is near
        if near:
            w.check(sight, b"", base, too_near=True)
    assert not finder.near_dock(of_depth(0.0), ORIGIN, None)


def test_one_that_meets_but_the_dock_or_the_floor_is_believed() -> None:
    watch().check(scan(ORIGIN, ROOM), b"1", ORIGIN)
    watch().check(of_depth(1.5), b"1", ORIGIN)


@pytest.mark.parametrize(
    "moved", [(0.03, 0.0, 0.0), (0.0, -0.03, 0.0), (0.0, 0.0, 0.05), (0.0, 0.0, 2.0 * math.pi - 0.05)]
)
def test_one_that_repeats_itself_while_the_chair_moves_is_not_believed_until_it_changes(
    moved: tuple[float, ...],
) -> None:
    w, sight = watch(), scan(ORIGIN, ROOM)
    for _ in range(20):  # a sensor without noise, of a chair that stands
        w.check(sight, b"1", ORIGIN)
    for _ in range(2):
        with pytest.raises(SensorFailsError, match="repeats"):
            w.check(sight, b"1", moved)
    w.check(sight, b"2", moved)
    w.check(sight, b"2", np.array(moved) + 0.01)


@pytest.mark.parametrize(
    ("begin", "step", "limits"),
    [(-2.0, 0.0, (0.05, 8.0)), (math.nan, 0.01, (0.05, 8.0)), (-2.0, math.inf, (0.05, 8.0)), (-2.0, 0.01, (8.0, 0.05))],
)
def test_a_scan_whose_angles_or_limits_are_none_is_refused(
    begin: float, step: float, limits: tuple[float, float]
) -> None:
    with pytest.raises(ValueError, match="cannot be"):
        scan_sight([1.0, 2.0], begin, step, limits, np.eye(4), 8.0)
