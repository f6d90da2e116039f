import math

import numpy as np
import pytest

from seater_common.geometry import (
    Bay,
    CameraMount,
    Chair,
    Dock,
    Marker,
    clearance,
    planar_pose,
    polygon_distance,
    pose_matrix,
    quaternion_of,
    rotation_matrix,
    rotation_rpy,
)

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def test_optical_frame_looks_forward() -> None:
    T = CameraMount().T_base_optical()
    np.testing.assert_allclose(T @ [0, 0, 1, 1], [1.45, 0, 0.7, 1], atol=1e-15)  # z is ahead
    np.testing.assert_allclose(T @ [1, 0, 0, 1], [0.45, -1, 0.7, 1], atol=1e-15)  # x is to the right
    np.testing.assert_allclose(T @ [0, 1, 0, 1], [0.45, 0, -0.3, 1], atol=1e-15)  # y is down


def test_camera_pitched_down_sees_the_floor() -> None:
    forward = CameraMount(pitch=0.3).T_base_optical()[:3, 2]
    np.testing.assert_allclose(forward, [math.cos(0.3), 0.0, -math.sin(0.3)], atol=1e-15)


def test_marker_faces_the_chair_and_reads_upright() -> None:
    T = Marker(0, 0.1, [0.9, 0.0, 0.7]).T_dock_marker()
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)
    top_left = T @ [-0.05, 0.05, 0.0, 1.0]
    np.testing.assert_allclose(top_left, [0.9, 0.05, 0.75, 1.0], atol=1e-15)  # left of a reader who looks along +x


def test_planar_pose_inverts_pose_matrix() -> None:
    np.testing.assert_allclose(planar_pose(pose_matrix([1.0, -2.0, 3.0])), [1.0, -2.0, 3.0], atol=1e-15)


def test_polygon_distance() -> None:
    assert polygon_distance(SQUARE, SQUARE + [3.0, 0.2]) == pytest.approx(2.0)
    assert polygon_distance(SQUARE, SQUARE + [4.0, 5.0]) == pytest.approx(5.0)  # corner to corner
    assert polygon_distance(SQUARE, SQUARE + [0.9, 0.0]) == pytest.approx(-0.1)


def test_an_open_dock_has_a_back_wall_only() -> None:
    bay = Bay(side_wall_length=0.0)
    assert bay.side_walls() == [] and len(bay.outlines()) == 1
    assert clearance(Chair(), bay, [0, 0.3, 0]) == pytest.approx(0.15)  # nothing at its sides


def test_clearance_of_the_docked_chair() -> None:
    chair, bay = Chair(), Bay()
    assert clearance(chair, bay, [0, 0, 0]) == pytest.approx(0.15)  # front to the back wall
    assert clearance(chair, bay, [0, 0.1, 0]) == pytest.approx(0.075)  # left side to the left wall
    assert clearance(chair, bay, [0.2, 0, 0]) == pytest.approx(-0.05)


def test_rotation_matrix_of_a_quaternion_about_each_axis() -> None:
    half = 0.35
    for axis, rpy in enumerate(np.eye(3) * 2 * half):
        quaternion = [0.0, 0.0, 0.0, math.cos(half)]
        quaternion[axis] = math.sin(half)
        np.testing.assert_allclose(rotation_matrix(*quaternion), rotation_rpy(*rpy), atol=1e-15)


def test_the_quaternion_of_a_rotation_gives_it_back() -> None:
    for rpy in ((0.0, 0.0, 0.0), (0.3, -0.2, 2.5), (-0.5 * math.pi, 0.0, -0.5 * math.pi), (math.pi, 0.0, 0.4)):
        quaternion = quaternion_of(rotation_rpy(*rpy))
        assert quaternion[3] >= 0.0 and np.linalg.norm(quaternion) == pytest.approx(1.0)
        np.testing.assert_allclose(rotation_matrix(*quaternion), rotation_rpy(*rpy), atol=1e-14)


def test_docking_error_is_zero_in_the_docked_pose_of_either_direction() -> None:
    for direction, heading in (("forward", 0.0), ("backward", math.pi)):
        dock = Dock(direction=direction)
        assert dock.docked_pose == pytest.approx([0.0, 0.0, heading])
        assert dock.docking_error([0.1, -0.2, heading + 0.3]) == pytest.approx([0.1, -0.2, 0.3])
        assert dock.docking_error([0.1, -0.2, heading + 0.3 - 2.0 * math.pi]) == pytest.approx([0.1, -0.2, 0.3])
