"""Transforms out of messages, here of anything with their fields."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from seater_common.camera_model import CameraModel
from seater_common.messages import camera_info_of, matrix_of_pose, matrix_of_transform, names_of


def pose(quaternion: tuple[float, float, float, float]) -> SimpleNamespace:
    x, y, z, w = quaternion
    return SimpleNamespace(
        position=SimpleNamespace(x=1.0, y=2.0, z=3.0), orientation=SimpleNamespace(x=x, y=y, z=z, w=w)
    )


def test_place_and_rotation_of_a_pose_and_of_a_transform() -> None:
    """A quarter turn about z, whose quaternion is 5 % too long."""
    given = pose((0.0, 0.0, 1.05 * math.sqrt(0.5), 1.05 * math.sqrt(0.5)))
    expected = [[0.0, -1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0], [0.0, 0.0, 0.0, 1.0]]
    assert matrix_of_pose(given) == pytest.approx(np.array(expected), abs=1e-12)
    transform = SimpleNamespace(translation=given.position, rotation=given.orientation)
    assert np.array_equal(matrix_of_transform(transform), matrix_of_pose(given))


@pytest.mark.parametrize("quaternion", [(0.0,) * 4, (0.0, 0.0, 0.0, 2.0), (math.nan, 0.0, 0.0, 1.0)])
def test_what_is_no_rotation_is_nan(quaternion) -> None:
    assert np.isnan(matrix_of_pose(pose(quaternion))).all()


def test_names_are_those_of_the_constants_alone() -> None:
    """The doctor's own list of the gate's states knew nothing of the newest one."""

    class Message:
        STOPPED, CHARGING = 0, 10
        TEXT = "no number"
        state = 3

    assert names_of(Message) == {0: "STOPPED", 10: "CHARGING"}


def test_the_fields_of_a_camera_info() -> None:
    camera = CameraModel(64, 48, "plumb_bob", np.arange(5.0), np.arange(9.0).reshape(3, 3), np.eye(3), np.ones((3, 4)))
    fields = camera_info_of(camera)
    assert (fields["width"], fields["height"], fields["distortion_model"]) == (64, 48, "plumb_bob")
    assert fields["D"] == [0.0, 1.0, 2.0, 3.0, 4.0] and fields["K"] == [float(i) for i in range(9)]
    assert fields["R"] == [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0] and fields["P"] == [1.0] * 12
