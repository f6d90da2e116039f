"""The view constraint: which edges count, and plans that keep a marker inside them."""

import math

import casadi as ca
import numpy as np
import pytest

from seater_common.camera_model import CameraModel
from seater_common.field_of_view import FieldOfView
from seater_common.geometry import Bay, CameraMount, Chair, Dock, Marker
from seater_common.sight import Sight
from seater_nmpc.ocp.constraints.interface import Stage
from seater_nmpc.ocp.constraints.view import (
    TURN_RESERVE,
    UNKNOWN_CAMERA,
    ViewConstraint,
    kept_field,
    markers_to_keep,
    sideways_edges,
)
from seater_nmpc.programme import StageProgramme

K = np.array([[910.0, 0.0, 500.0], [0.0, 910.0, 359.5], [0.0, 0.0, 1.0]])
D435 = CameraModel(1280, 720, "plumb_bob", np.zeros(5), K, np.eye(3), np.hstack([K, np.zeros((3, 1))]))
MOUNTS = [
    CameraMount(),
    CameraMount(y=0.25, yaw=-0.4),
    CameraMount(z=1.2, pitch=0.45),
    CameraMount(roll=math.pi / 2),
]


def test_the_field_comes_from_the_camera_and_the_key_only_narrows_it() -> None:
    field = kept_field(D435, 0.0)
    assert math.atan(field.left) == pytest.approx(math.atan(494.0 / 910.0) - TURN_RESERVE)
    assert field.right > field.left  # the principal point is left of the middle
    assert math.atan(kept_field(D435, 0.3).right) == pytest.approx(0.3)
    assert kept_field(D435, 1.4) == field
    assert math.atan(kept_field(None, 0.0).left) == pytest.approx(UNKNOWN_CAMERA)
    assert math.atan(kept_field(None, 0.6).left) == pytest.approx(0.6)


def margins(mount: CameraMount, field: FieldOfView, dock: Dock, poses: np.ndarray) -> np.ndarray:
    """(n, 2): right, left, as the programme has them."""
    programme, view = StageProgramme(), markers_to_keep(dock)
    constraint = ViewConstraint(mount, field, (view.left[2], view.right[2]), programme)
    pose = ca.SX.sym("pose", 3)
    (margin,) = constraint.margins(Stage(0, pose, ca.SX(0.0), ca.SX(4, 2)))
    p = np.zeros(4)
    constraint.set_instance(view, p, p, p)
    f = ca.Function("margin", [pose, ca.vertcat(*programme.parameters)], [margin])
    return np.array([np.array(f(at, p)).ravel() for at in poses])


@pytest.mark.parametrize("mount", MOUNTS)
def test_a_single_flat_marker_is_inside_exactly_when_its_ends_are_in_the_image(mount: CameraMount) -> None:
    """The two planes against projection of the ends, for points that the image's other two edges do not cut."""
    field, dock = FieldOfView.of(D435), Dock(markers=[Marker(0, 0.15, [0.9, 0.1, 0.7], math.pi)])
    poses = np.random.default_rng(4).uniform([-3.0, -1.5, -1.0], [-0.4, 1.5, 1.0], (400, 3))
    inside = np.all(margins(mount, field, dock, poses) >= 0.0, axis=1)
    planes = field.edges(mount)
    chosen = [int(np.argmin(np.abs(planes - edge).sum(axis=1))) for edge in sideways_edges(field, mount)]
    assert sorted(chosen) == ([0, 1] if mount.roll == 0.0 else [2, 3])
    T = np.linalg.inv(mount.T_base_optical())
    expected = []
    for x, y, heading in poses:
        ends = np.array([[0.9, 0.175, 0.7], [0.9, 0.025, 0.7]]) - [x, y, 0.0]
        c, s = math.cos(heading), math.sin(heading)
        base = ends @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        pixels = D435.project(base @ T[:3, :3].T + T[:3, 3])
        axis, size = (0, 1280) if mount.roll == 0.0 else (1, 720)
        expected.append(bool(np.all((pixels[:, axis] >= 6.0) & (pixels[:, axis] <= size - 7.0))))
    assert 20 < sum(expected) < 380
    np.testing.assert_array_equal(inside, expected)


@pytest.mark.parametrize("length", [0.9, 0.0])
def test_one_whole_marker_is_in_view_where_the_margins_hold(length: float) -> None:
    """Ahead of the dock, where the view is wider than the gaps between markers: hidden by side walls or open."""
    field, dock = FieldOfView.of(D435), Dock(bay=Bay(side_wall_length=length))
    poses = np.random.default_rng(5).uniform([-3.0, -0.8, -0.8], [-0.6, 0.8, 0.8], (400, 3))
    kept = np.all(margins(CameraMount(), field, dock, poses) >= 0.0, axis=1)
    seen = np.any(Sight(Chair().camera, dock, field).seen(poses), axis=1)
    assert 50 < np.sum(kept) < 350
    bearing = np.abs(poses[:, 1] + 0.45 * np.sin(poses[:, 2])) / (0.45 - poses[:, 0])
    assert np.all(seen[kept & ((bearing < 0.45) | (length == 0.0))])  # a wall hides the middle from atan(0.45 / 0.9) on


def test_which_markers_are_kept() -> None:
    walls, opened = markers_to_keep(Dock()), markers_to_keep(Dock(bay=Bay(side_wall_length=0.0)))
    assert walls.left == pytest.approx((0.9, -0.05, 0.7)) and walls.right == pytest.approx((0.9, 0.05, 0.7))
    assert opened.left == pytest.approx((0.9, 0.275, 0.7)) and opened.right == pytest.approx((0.9, -0.275, 0.7))
    pair = Dock(markers=Dock().markers[1:])
    assert markers_to_keep(pair).left == opened.left and markers_to_keep(pair).right == opened.right
