"""The report of bags as real chairs leave them: no truth, or less than that. Bags are written by rosbag itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rosbag
import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped, Quaternion, TwistStamped
from nav_msgs.msg import Odometry

from seater_common.geometry import Chair, Dock
from seater_common.se2 import compose
from seater_eval.docking.dock_report import describe, write_report
from seater_eval.docking.recording import RecordingError
from seater_msgs.msg import DockActionGoal, DockActionResult

BEGIN, DURATION = 100.0, 10.0
T_ODOM_DOCK = np.array([3.0, -1.0, 0.7])
FINAL = np.array([0.004, -0.003, math.radians(0.3)])  # of the chair, in the dock's frame


def pose(time: float) -> np.ndarray:
    """Straight in from 2 m, it stands for the last second."""
    share = min(1.0, (time - BEGIN) / (DURATION - 1.0))
    return np.array([-2.0, 0.0, 0.0]) * (1.0 - share) + FINAL * share


def stamped(message: Any, time: float) -> Any:
    message.header.stamp = rospy.Time.from_sec(time)
    return message


def set_pose(message: Any, where: np.ndarray) -> None:
    place = message.pose.pose
    place.position.x, place.position.y = float(where[0]), float(where[1])
    place.orientation = Quaternion(z=math.sin(0.5 * where[2]), w=math.cos(0.5 * where[2]))


def odometry(time: float) -> Odometry:
    message = stamped(Odometry(), time)
    set_pose(message, compose(T_ODOM_DOCK, pose(time)))
    message.twist.twist.linear.x = 0.22 if time < BEGIN + DURATION - 1.0 else 0.0
    return message


def estimate(time: float) -> PoseWithCovarianceStamped:
    """15 cm off when the dock is far, right from the middle of the way on."""
    message = stamped(PoseWithCovarianceStamped(), time)
    set_pose(message, T_ODOM_DOCK + (np.array([0.0, 0.15, 0.0]) if time < BEGIN + 5.0 else 0.0))
    return message


STREAMS: dict[str, Callable[[float], Any]] = {
    "odom": odometry,
    "/dock_pose_filtered": estimate,
    "cmd_vel_stamped": lambda time: stamped(TwistStamped(), time),
}


def write_bag(path: Path, *topics: str, code: int = 0) -> Path:
    with rosbag.Bag(str(path), "w") as bag:
        for topic in topics:
            for time in np.arange(BEGIN, BEGIN + DURATION, 0.1):
                bag.write(topic, STREAMS[topic](float(time)), rospy.Time.from_sec(float(time)))
        bag.write("dock/goal", stamped(DockActionGoal(), BEGIN), rospy.Time.from_sec(BEGIN))
        result = stamped(DockActionResult(), BEGIN + 9.5)
        result.result.result_code, result.result.result_text = code, "docked" if code == 0 else "lost"
        bag.write("dock/result", result, rospy.Time.from_sec(BEGIN + 9.5))
    return path


def report(bag: Path) -> tuple[dict[str, Any], str]:
    summary = write_report(bag, Dock(), Chair(), bag.parent / "results")
    assert (bag.parent / "results" / "trajectory.png").stat().st_size > 20_000
    return summary, describe(summary, [])


def test_without_a_truth_the_estimate_is_reported_and_named_so(tmp_path: Path) -> None:
    summary, text = report(write_bag(tmp_path / "a.bag", *STREAMS))
    assert summary["docked"] and summary["judged_by"] == "estimate"
    assert summary["true_error"] is None and summary["estimate_error"] is None
    error = summary["estimated_final_error"]
    assert error["longitudinal_m"] == pytest.approx(FINAL[0], abs=1e-9)
    assert error["lateral_m"] == pytest.approx(FINAL[1], abs=1e-9)
    assert error["heading_deg"] == pytest.approx(0.3, abs=1e-6)
    assert summary["duration_s"] == pytest.approx(9.5)
    # At the begin it believed what it knew then.
    assert summary["start_pose"]["y_m"] == pytest.approx(-0.15 * math.cos(0.7), abs=1e-6)
    assert "DOCKED by its own estimate" in text and "final error AS ESTIMATED" in text
    assert "true" not in text and "simulated" not in text
    assert "not recorded" in text and "controller_status" in text


def test_the_estimate_outside_the_tolerance_is_not_docked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(globals(), "FINAL", np.array([0.012, 0.0, 0.0]))
    assert not report(write_bag(tmp_path / "a.bag", *STREAMS))[0]["docked"]


@pytest.mark.parametrize("topics", [("odom",), ("/dock_pose_filtered",), ("cmd_vel_stamped",)])
def test_what_is_there_is_drawn_and_what_is_not_is_named(tmp_path: Path, topics: tuple[str, ...]) -> None:
    summary, text = report(write_bag(tmp_path / "a.bag", *topics, code=908))
    assert not summary["docked"] and summary["judged_by"] == "nothing"
    missing = {name.lstrip("/") for name in STREAMS} - {name.lstrip("/") for name in topics}
    assert missing <= set(summary["missing"])
    assert "result 908: lost" in text and "odom and dock_pose_filtered are both needed" in text


def test_a_bag_of_something_else_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no messages on any of"):
        report(write_bag(tmp_path / "a.bag"))
