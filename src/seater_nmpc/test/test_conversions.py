"""Values of the core in messages."""

import math

import numpy as np
import pytest

rospy = pytest.importorskip("rospy")

from seater_msgs.msg import DockInnovation  # noqa: E402
from seater_nmpc.observe.innovation import Fusion, Innovation, Outcome  # noqa: E402
from seater_nmpc.ros import conversions  # noqa: E402

STAMP = rospy.Time(7, 500000000)


def test_an_innovation_with_its_standard_deviations_and_gate_ratio() -> None:
    innovation = Innovation(
        value=np.array([0.03, -0.02, 0.01]), covariance=np.diag([1e-4, 4e-4, 9e-4]), nis=8.15, gate=16.3, log_det=-24.0
    )
    message = conversions.innovation(STAMP, "odom", Fusion(outcome=Outcome.FUSED, innovation=innovation))
    assert message.header.stamp == STAMP and message.header.frame_id == "odom"
    assert (message.x, message.y, message.yaw) == (0.03, -0.02, 0.01)
    assert (message.sd_x, message.sd_y, message.sd_yaw) == pytest.approx((0.01, 0.02, 0.03))
    assert message.nis == 8.15 and message.gate_ratio == pytest.approx(0.5)
    assert message.accepted and message.outcome == DockInnovation.FUSED and message.outcome_text == "fused"


def test_without_an_estimate_there_is_no_number_but_a_reason() -> None:
    message = conversions.innovation(STAMP, "odom", Fusion(outcome=Outcome.NO_ODOMETRY))
    numbers = (message.x, message.y, message.yaw, message.sd_x, message.sd_y, message.sd_yaw, message.nis)
    assert all(math.isnan(number) for number in (*numbers, message.gate_ratio))
    assert not message.accepted and message.outcome == DockInnovation.NO_ODOMETRY
    assert message.outcome_text == "no odometry"
