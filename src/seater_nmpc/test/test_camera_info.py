"""The camera of a camera_info message, as drivers fill it."""

import math

import numpy as np
import pytest

pytest.importorskip("rospy")
from sensor_msgs.msg import CameraInfo

from seater_common.field_of_view import FieldOfView
from seater_common.params import ParameterError
from seater_nmpc.ros.camera import from_message

F = 640.0


def info(model: str, D: list[float]) -> CameraInfo:
    K = [F, 0.0, 639.5, 0.0, F, 359.5, 0.0, 0.0, 1.0]
    P = [F, 0.0, 639.5, 0.0, 0.0, F, 359.5, 0.0, 0.0, 0.0, 1.0, 0.0]
    R = np.eye(3).ravel().tolist()
    return CameraInfo(width=1280, height=720, distortion_model=model, D=D, K=K, R=R, P=P)


@pytest.mark.parametrize("model", ["", "plumb_bob", "Inverse Brown Conrady", "distortion.brown_conrady"])
@pytest.mark.parametrize("D", [[], [0.0] * 5])
def test_no_coefficients_are_no_distortion(model: str, D: list[float]) -> None:
    camera = from_message(info(model, D))
    assert not camera.distorted
    assert FieldOfView.of(camera, border=0.0).right == pytest.approx(639.5 / F)


def test_a_fisheye_sees_farther_to_the_side() -> None:
    field = FieldOfView.of(from_message(info("equidistant", [0.0] * 4)), border=0.0)
    assert field.right == pytest.approx(math.tan(639.5 / F), rel=1e-6)
    assert field.down == pytest.approx(math.tan(359.5 / F), rel=1e-6)


def test_what_is_not_known_is_refused() -> None:
    for model, D in (("Inverse Brown Conrady", [0.1, 0.0, 0.0, 0.0, 0.0]), ("Ftheta", [0.0] * 5)):
        with pytest.raises(ParameterError, match=f"camera_info/distortion_model: is '{model}' with D"):
            from_message(info(model, D))
