"""Scans, clouds and depth images, in the conventions of sensor_msgs."""

import math

import numpy as np
import pytest

from seater_common.geometry import CameraMount
from seater_obstacles.depth import DepthImages, cloud_sight
from seater_obstacles.scan import TiltedError, scan_sight
from seater_obstacles.settings import SenseSettings

INCREMENT = math.radians(1.0)
MOUNT = CameraMount()
K = np.array([[640.0, 0.0, 640.0], [0.0, 640.0, 360.0], [0.0, 0.0, 1.0]])


def test_a_scan_is_read_in_the_convention_of_its_message() -> None:
    T = np.eye(4)
    T[:3, 3] = 0.5, 0.1, 0.2
    sight = scan_sight([1.0, math.nan, 0.01, math.inf, 2.0], -0.2, 0.1, (0.1, 10.0), T, 8.0)
    expected = [[0.5 + math.cos(0.2), 0.1 - math.sin(0.2)], [0.5 + 2.0 * math.cos(0.2), 0.1 + 2.0 * math.sin(0.2)]]
    assert sight.points == pytest.approx(np.array(expected))


def test_an_upside_down_scanner_turns_its_bearings() -> None:
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    sight = scan_sight([1.0], 0.5, 0.1, (0.1, 10.0), T, 8.0)
    assert sight.points[0] == pytest.approx([math.cos(0.5), -math.sin(0.5)])
    assert sight.view.sees([[0.5 * math.cos(0.5), -0.5 * math.sin(0.5)]], 0.0) == [True]


def test_a_tilted_scanner_is_refused() -> None:
    T = np.eye(4)
    T[:3, :3] = [[math.cos(0.3), 0.0, math.sin(0.3)], [0.0, 1.0, 0.0], [-math.sin(0.3), 0.0, math.cos(0.3)]]
    with pytest.raises(TiltedError, match="tilted"):
        scan_sight([1.0], 0.0, 0.1, (0.1, 10.0), T, 8.0)


def test_blind_is_what_was_not_measured_is_hidden_or_too_near() -> None:
    r = np.full(181, 3.0)
    r[100:] = math.nan
    view = scan_sight(r, -0.5 * math.pi, INCREMENT, (0.2, 10.0), np.eye(4), 8.0).view
    points = [[2.9, 0.0], [3.05, 0.0], [3.2, 0.0], [0.1, 0.0], [0.0, 2.0], [-2.0, 0.0]]
    assert view.sees(points, 0.1).tolist() == [True, True, False, False, False, False]
    assert view.blind == pytest.approx(1.0 - 100.0 / 360.0, abs=0.02)


def image_of(height: float, distance: float) -> np.ndarray:
    """Depth [m] of a level floor and, from 0.2 m left to right of the axis, a thing of this height."""
    v, u = np.mgrid[0:720, 0:1280].astype(float)
    down = (v - K[1, 2]) / K[1, 1]
    with np.errstate(divide="ignore"):
        floor = np.where(down > 1e-6, MOUNT.z / np.maximum(down, 1e-6), np.nan)
    x, y = distance * (u - K[0, 2]) / K[0, 0], distance * down
    thing = (np.abs(x) <= 0.2) & (MOUNT.z - y <= height) & (distance < np.nan_to_num(floor, nan=np.inf))
    return np.where(thing, distance, floor).astype(np.float32)


@pytest.mark.parametrize("scale", [1.0, 1e3])
def test_a_depth_image_shows_what_stands_and_not_the_floor(scale: float) -> None:
    depth = image_of(0.4, 2.0)
    given = depth if scale == 1.0 else np.nan_to_num(scale * depth).clip(0, 65535).astype(np.uint16)
    sight = cloud_sight(DepthImages(8).cloud(given, K), MOUNT.T_base_optical(), SenseSettings())
    assert len(sight.points) > 100
    assert np.all(np.abs(sight.points[:, 0] - (MOUNT.x + 2.0)) < 2e-3) and np.all(np.abs(sight.points[:, 1]) <= 0.21)


def test_a_tilted_floor_is_floor() -> None:
    """Half a degree of an unknown tilt and 1 % of depth noise."""
    depth = image_of(0.0, 9.0)
    depth *= np.random.default_rng(1).normal(1.0, 0.01, depth.shape).astype(np.float32)
    mount = CameraMount(pitch=math.radians(0.5))
    assert not len(cloud_sight(DepthImages(8).cloud(depth, K), mount.T_base_optical(), SenseSettings()).points)


def test_a_low_thing_near_the_camera_is_in_the_blind_area() -> None:
    """The lowest ray meets the floor 1.24 m from the camera."""
    sight = cloud_sight(DepthImages(8).cloud(image_of(0.4, 2.0), K), MOUNT.T_base_optical(), SenseSettings())
    points = np.array([[MOUNT.x + 0.8, 0.0], [MOUNT.x + 1.6, 0.0], [MOUNT.x + 2.5, 0.0], [0.0, 1.5]])
    assert sight.view.sees(points, 0.1).tolist() == [False, True, False, False]


def test_a_cloud_above_and_below_is_passed() -> None:
    given = [[1.0, 0.0, 1.8], [1.0, 0.1, 0.03], [1.0, 0.2, 0.5], [1.0, 0.3, -0.5], [math.nan, 0.0, 0.5]]
    assert cloud_sight(given, np.eye(4), SenseSettings()).points.tolist() == [[1.0, 0.2]]


@pytest.mark.parametrize("wrong", [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 3), np.float32)])
def test_other_images_are_refused(wrong: np.ndarray) -> None:
    with pytest.raises(ValueError, match="32FC1"):
        DepthImages(2).cloud(wrong, K)


def test_a_camera_matrix_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match="K must be finite"):
        DepthImages(2).cloud(np.zeros((4, 4), np.float32), np.full((3, 3), np.nan))
