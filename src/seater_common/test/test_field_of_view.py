"""What cameras see: angles against arithmetic and OpenCV's lens, mounts, walls in between."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from seater_common.camera_model import CameraModel
from seater_common.field_of_view import FieldOfView
from seater_common.geometry import Bay, CameraMount, Dock, Marker
from seater_common.occlusion import Prism, blocked
from seater_common.sight import Sight, marker_edges


def camera(width=1280, height=720, f=640.0, cx=None, D=(0.0, 0.0, 0.0, 0.0, 0.0)) -> CameraModel:
    K = np.array([[f, 0.0, 0.5 * (width - 1) if cx is None else cx], [0.0, f, 0.5 * (height - 1)], [0.0, 0.0, 1.0]])
    return CameraModel(width, height, "plumb_bob", np.array(D), K, np.eye(3), np.hstack([K, np.zeros((3, 1))]))


def test_edges_of_a_pinhole_are_pixels_over_focal_length() -> None:
    field = FieldOfView.of(camera(cx=500.0), border=10.0)
    assert field.left == pytest.approx((500.0 - 10.0) / 640.0) and field.right == pytest.approx(769.0 / 640.0)
    assert field.up == field.down == pytest.approx((359.5 - 10.0) / 640.0)


@pytest.mark.parametrize("k1", [-0.1, 0.3])
def test_a_rectangle_within_a_bent_image_is_inside_everywhere(k1: float) -> None:
    """Every point of its rim is projected into the image, and one of each edge near to the image's edge."""
    model = camera(D=(k1, 0.02, 0.001, -0.001, 0.0))
    field = FieldOfView.of(model, border=0.0)
    s = np.linspace(-1.0, 1.0, 41)
    x = np.where(s < 0.0, s * field.left, s * field.right)
    y = np.where(s < 0.0, s * field.up, s * field.down)
    sides = [
        np.column_stack([np.full(41, -field.left), y]),
        np.column_stack([np.full(41, field.right), y]),
        np.column_stack([x, np.full(41, -field.up)]),
        np.column_stack([x, np.full(41, field.down)]),
    ]
    for side, (axis, edge) in zip(sides, ((0, 0.0), (0, 1279.0), (1, 0.0), (1, 719.0)), strict=True):
        points = np.column_stack([side, np.ones(41)])
        pixels = cv2.projectPoints(points, np.zeros(3), np.zeros(3), model.K, model.D)[0].reshape(-1, 2)
        assert np.all(pixels >= -0.51) and np.all(pixels <= [1279.51, 719.51])
        assert np.min(np.abs(pixels[:, axis] - edge)) < 0.03 * 1280


def test_a_lens_without_inverse_at_the_edge_is_cut_where_it_has_one() -> None:
    model = camera(D=(-0.6, 0.0, 0.0, 0.0, 0.0))  # r (1 - 0.6 r^2) turns back at r = 0.75, half the image is 1.0 wide
    field = FieldOfView.of(model)
    assert 0.3 < field.left < 0.75


def test_a_principal_point_at_the_edge_is_refused() -> None:
    with pytest.raises(ValueError, match="principal point"):
        FieldOfView.of(camera(cx=2.0))


def test_a_lens_without_inverse_anywhere_is_refused() -> None:
    """Found by 24 000 hostile camera_info messages: three edges were not a number."""
    with pytest.raises(ValueError, match="distortion_coefficients"):
        FieldOfView.of(camera(D=(0.0, 0.0, 0.0, -0.59, 0.0)))


def test_narrowing_and_limits() -> None:
    field = FieldOfView(1.0, 0.5, 0.4, 0.4)
    assert math.atan(field.narrowed(0.1).left) == pytest.approx(math.pi / 4 - 0.1)
    assert field.narrowed(2.0).right > 0.0
    assert field.limited(0.6) == replace(field, left=math.tan(0.6))
    assert FieldOfView.symmetric(0.45).up == math.inf


@pytest.mark.parametrize(
    "mount",
    [
        CameraMount(),
        CameraMount(y=0.2, yaw=-0.3),
        CameraMount(z=1.1, pitch=0.4),
        CameraMount(roll=math.pi / 2, pitch=-0.1),
        CameraMount(x=-0.2, yaw=math.pi, pitch=0.2),
    ],
)
def test_planes_agree_with_projection(mount: CameraMount) -> None:
    """A point is on the seen side of all four planes exactly when it is projected into the image."""
    model = camera(800, 600, 500.0, cx=350.0)
    edges = FieldOfView.of(model, border=0.0).edges(mount)
    points = np.random.default_rng(3).uniform([-3.0, -3.0, -1.0], [3.0, 3.0, 3.0], (4000, 3))
    T = np.linalg.inv(mount.T_base_optical())
    optical = points @ T[:3, :3].T + T[:3, 3]
    ahead = optical[:, 2] > 0.05
    pixels = model.project(optical[ahead])
    inside = np.all((pixels >= 0.0) & (pixels <= [799.0, 599.0]), axis=1)
    assert np.sum(inside) > 50
    np.testing.assert_array_equal(np.all(points[ahead] @ edges[:, :3].T + edges[:, 3] >= 0.0, axis=1), inside)


def test_a_wall_blocks_what_is_behind_it_and_not_what_is_above_or_before() -> None:
    wall = Prism(np.array([[0.0, -1.0], [0.1, -1.0], [0.1, 1.0], [0.0, 1.0]]), 1.0)
    eyes = np.array([[-1.0, 0.0, 0.5], [-1.0, 0.0, 2.0], [-1.0, 3.0, 0.5]])
    points = np.array([[1.0, 0.0, 0.5], [-0.5, 0.0, 0.5], [0.0, 0.0, 0.5], [1.0, 0.0, 1.5]])
    assert blocked(eyes, points, [wall]).tolist() == [
        [True, False, False, False],  # behind it; before it; on its face; over its top at half the way
        [False, False, False, False],
        [False, False, False, False],
    ]
    assert blocked(eyes[:1], points[:1], []).tolist() == [[False]]


def test_markers_in_sight_from_ahead_beside_and_behind() -> None:
    sight = Sight(CameraMount(), Dock(), FieldOfView.of(camera()))
    poses = [(-2.0, 0.0, 0.0), (-2.0, 0.0, 0.7), (2.0, 0.0, math.pi), (-1.2, 1.2, -0.6)]
    assert sight.seen(np.array(poses)).tolist() == [
        [True, True, True],
        [False, True, False],
        [False, False, False],  # behind the dock: the print faces away
        [False, False, True],  # beside the bay: its left wall hides the others
    ]
    opened = Sight(CameraMount(), replace(Dock(), bay=Bay(side_wall_length=0.0)), FieldOfView.of(camera()))
    assert opened.seen(np.array(poses))[3].tolist() == [True, True, True]


def test_a_marker_that_is_too_high_leaves_the_image_near_the_dock() -> None:
    dock = replace(Dock(), markers=[Marker(0, 0.1, [0.9, 0.0, 1.1], math.pi)])
    level = Sight(CameraMount(), dock, FieldOfView.of(camera()))
    assert level.seen(np.array([(-1.0, 0.0, 0.0), (0.0, 0.0, 0.0)])).ravel().tolist() == [True, False]
    looking_up = Sight(CameraMount(pitch=-0.6), dock, FieldOfView.of(camera()))
    assert looking_up.seen(np.array([(0.0, 0.0, 0.0)])).tolist() == [[True]]


def test_ends_of_a_marker() -> None:
    left, right = marker_edges(replace(Dock(), markers=[Marker(0, 0.2, [0.9, 0.3, 0.7], math.pi)]), 0)
    assert left == pytest.approx([0.9, 0.4, 0.7]) and right == pytest.approx([0.9, 0.2, 0.7])
