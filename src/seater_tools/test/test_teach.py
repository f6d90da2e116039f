"""Teaching: only a standing chair that is seen with certainty is taught, and the dock file moves with it."""

from __future__ import annotations

import datetime
import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from as_typed import run
from printed import DEFAULT_DOCK

from seater_common.geometry import Dock
from seater_common.params import load, read_yaml
from seater_common.se2 import compose, inverse, transform_points
from seater_tools.correct.sizes import CORRECTED
from seater_tools.teach.dock import remarks, taught_text, teaching_of
from seater_tools.teach.measure import Measurement, Standing, TeachError

rosbag = pytest.importorskip("rosbag")

NOW = datetime.datetime(2026, 11, 27, 16, 5, 9, tzinfo=datetime.UTC)
POSE = np.array([0.012, -0.008, 0.02])  # base_link in the dock frame
SURE = np.diag([1e-3, 1e-3, 2e-3]) ** 2
MEASURED = Measurement(POSE, np.array([0.0004, 0.0003, 0.0002]), 60, 3.1)


def drive_in(
    standing: Standing,
    stood: float = 4.0,
    covariance: np.ndarray = SURE,
    weight: float = 1.0,
    outliers: bool = False,
    noise: float = 0.0005,
    gyro: float = 0.0,
) -> None:
    """Two seconds of driving to POSE, then standing there; odometry at 50 Hz in a frame of its own, images at 10 Hz."""
    rng = np.random.default_rng(2)
    for i in range(round(50 * (2.0 + stood)) + 1):
        now = 0.02 * i
        true = compose(POSE, [-0.1 * max(0.0, 2.0 - now), 0.0, 0.0])
        odom = compose([3.0, 1.0, 0.7], true) + [0.0, 0.0, gyro * now]
        standing.odometry(now, odom)
        if i % 5 == 0:
            seen = inverse(true) + noise * rng.standard_normal(3)
            seen[:2] += 0.05 * (outliers and i % 50 == 0)
            standing.dock(now, seen, covariance, weight)


def test_the_mean_of_what_was_seen_while_standing() -> None:
    standing = Standing()
    drive_in(standing)
    measured = standing.measure()
    assert measured.pose == pytest.approx(POSE, abs=0.0003)  # 37 images of 0.5 mm
    assert measured.spread == pytest.approx(np.full(3, 0.0005), rel=0.4)
    assert 35 <= measured.count <= 38 and measured.duration == pytest.approx(3.6, abs=0.21)


def test_outliers_are_left_out() -> None:
    standing = Standing()
    drive_in(standing, outliers=True)
    assert standing.measure().pose == pytest.approx(POSE, abs=0.0003)


def test_a_gyro_may_drift() -> None:
    standing = Standing()
    drive_in(standing, gyro=0.01)
    assert standing.measure().pose == pytest.approx(POSE, abs=0.0003)


@pytest.mark.parametrize(
    ("how", "problem"),
    [
        ({"stood": 1.0}, r"the chair has stood for 0\.7 s, 2 s are needed"),
        ({"covariance": np.diag([0.006, 1e-3, 1e-3]) ** 2}, r"0 certain measurements .* \(3\d uncertain ones\)"),
        ({"covariance": np.diag([1e-3, 1e-3, 0.02]) ** 2}, r"0 certain measurements"),
        ({"weight": 0.9}, r"0 certain measurements"),
        ({"noise": 0.005}, r"the measurements scatter by"),
        ({"gyro": 0.05}, r"the chair has stood for 0\.0 s"),
    ],
)
def test_what_is_not_sure_is_not_taught(how: dict[str, object], problem: str) -> None:
    standing = Standing()
    drive_in(standing, **how)  # type: ignore[arg-type]
    with pytest.raises(TeachError, match=problem):
        standing.measure()


def test_without_odometry_nothing_is_taught() -> None:
    standing = Standing()
    standing.odometry(1.0, [math.nan, 0.0, 0.0])
    with pytest.raises(TeachError, match="no odometry arrives"):
        standing.measure()


def test_measurements_that_are_not_finite_do_not_count() -> None:
    standing = Standing()
    drive_in(standing)
    count = standing.measure().count
    for _ in range(5):
        standing.dock(5.9, [math.nan, 0.0, 0.0], SURE, 1.0)
        standing.dock(5.9, [0.0, 0.0, 0.0], np.full((3, 3), math.inf), 1.0)
    assert standing.measure().count == count


@pytest.mark.parametrize("direction", ["forward", "backward"])
def test_every_marker_keeps_its_place_in_the_world(direction: str) -> None:
    text = DEFAULT_DOCK.read_text().replace("direction: forward ", f"direction: {direction} ")
    old = load(Dock, yaml.safe_load(text), "old")
    stands = POSE if direction == "forward" else compose(POSE, [0.0, 0.0, math.pi])
    measured = Measurement(stands, MEASURED.spread, 60, 3.1)
    new = load(Dock, yaml.safe_load(taught_text(text, "old", old, measured, NOW)), "new")
    # Seen from the standing chair nothing has moved; and by the new file, it is docked.
    for a, b in zip(old.markers, new.markers, strict=True):
        seen_before = transform_points(inverse(stands), np.array([a.position[:2]]))
        seen_after = transform_points(inverse(new.docked_pose), np.array([b.position[:2]]))
        assert seen_after == pytest.approx(seen_before, abs=2e-5)
        assert math.cos(b.normal_yaw - a.normal_yaw + POSE[2]) == pytest.approx(1.0, abs=1e-9)
        assert (b.position[2], b.size) == (a.position[2], a.size)
    # The wall, too, but for the print that would hang behind it.
    wall, farthest = (0.9 - POSE[0]) / math.cos(POSE[2]), max(marker.position[0] for marker in new.markers)
    assert new.bay.back_wall_x == pytest.approx(max(wall, farthest), abs=2e-5)
    assert new.bay.entrance_x == pytest.approx(wall - old.bay.side_wall_length, abs=2e-5)
    assert teaching_of(text) is None


def test_the_file_says_when_and_how_it_was_taught() -> None:
    dock = load(Dock, read_yaml(DEFAULT_DOCK), "dock")
    text = taught_text(DEFAULT_DOCK.read_text(), "dock", dock, MEASURED, NOW)
    first, _, rest = text.partition("\n")
    assert first == "# Taught: 2026-11-27T16:05:09Z, 60 measurements in 3.1 s, spread 0.40 mm 0.30 mm 0.011 deg"
    assert rest.count("#") == DEFAULT_DOCK.read_text().count("#")
    teaching = teaching_of(text)
    assert teaching is not None
    assert (teaching.date, teaching.count, teaching.duration) == (NOW, 60, 3.1)
    assert teaching.spread == pytest.approx((0.0004, 0.0003, math.radians(0.011)))
    later = datetime.timedelta(days=3)
    again = taught_text(text, "dock", load(Dock, yaml.safe_load(text), "d"), MEASURED, NOW + later)
    assert again.count("# Taught") == 1 and teaching_of(again).date == NOW + later  # type: ignore[union-attr]
    printed = taught_text(f"{CORRECTED}99 %\n{DEFAULT_DOCK.read_text()}", "dock", dock, MEASURED, NOW)
    assert printed.startswith(f"{CORRECTED}99 %\n# Taught: ")


@pytest.mark.parametrize("pose", [[0.31, 0.0, 0.0], [0.0, 0.0, 0.3]])
def test_another_dock_is_refused(pose: list[float]) -> None:
    dock = load(Dock, read_yaml(DEFAULT_DOCK), "dock")
    with pytest.raises(TeachError, match="is it this dock"):
        taught_text(DEFAULT_DOCK.read_text(), "d", dock, Measurement(np.array(pose), np.zeros(3), 60, 3.0), NOW)


def test_a_place_beside_the_middle_is_told() -> None:
    assert remarks(Dock(), Measurement(np.array([0.0, 0.004, 0.0]), np.zeros(3), 60, 3.0)) == []
    (text,) = remarks(Dock(), Measurement(np.array([0.0, -0.02, 0.0]), np.zeros(3), 60, 3.0))
    assert text.startswith("The taught place is 20 mm right of the bay's middle")


def write_bag(path: Path, detections: bool = True) -> None:
    """The chair drives 0.2 m ahead in 2 s and stands for 4 s more, 0.9 m before the dock's frame."""
    import rospy
    from nav_msgs.msg import Odometry

    from seater_msgs.msg import DockObservation, MarkerDetectionArray

    with rosbag.Bag(str(path), "w") as bag:
        for i in range(300):
            now, x = rospy.Time.from_sec(10.0 + 0.02 * i), 0.1 * min(2.0, 0.02 * i)
            message = Odometry()
            message.header.stamp = now
            message.pose.pose.position.x, message.pose.pose.orientation.w = x, 1.0
            bag.write("/odom", message, now)
            if detections and i % 5 == 0:
                seen, dock = MarkerDetectionArray(), DockObservation(weight=1.0)
                seen.header.stamp = now
                # Optical axes; the camera of chair.yaml is 0.45 m ahead of the axle and 0.7 m above the floor.
                dock.pose.pose.position.y, dock.pose.pose.position.z = 0.7, 0.2 - x - 0.45 - 0.03
                o = dock.pose.pose.orientation
                o.x, o.y, o.z, o.w = 0.5, -0.5, 0.5, 0.5
                dock.pose.covariance = (1e-6 * np.eye(6)).ravel().tolist()
                seen.dock = [dock]
                bag.write("/detections", seen, now)


def test_from_a_bag_that_ends_docked(tmp_path: Path) -> None:
    pytest.importorskip("rospy")
    write_bag(tmp_path / "in.bag")
    dock = tmp_path / "dock.yaml"
    dock.write_text(DEFAULT_DOCK.read_text())
    done = run("teach", "--bag", tmp_path / "in.bag", "--dock", dock)
    assert done.returncode == 0, done.stderr
    assert "the chair stands 30.0 mm ahead, 0.0 mm left, 0.00 deg off" in done.stdout and "Next:" not in done.stdout
    taught = load(Dock, read_yaml(dock), "dock")
    assert taught.markers[0].position[:2] == pytest.approx([0.87, 0.0], abs=1e-5)
    assert teaching_of(dock.read_text()) is not None
    (kept,) = tmp_path.glob("dock.yaml.2*")
    assert kept.read_text() == DEFAULT_DOCK.read_text()


def test_a_bag_without_detections_is_refused(tmp_path: Path) -> None:
    write_bag(tmp_path / "in.bag", detections=False)
    done = run("teach", "--bag", tmp_path / "in.bag", "--dock", DEFAULT_DOCK, "--output", tmp_path / "dock.yaml")
    assert done.returncode == 2 and "in.bag: has no messages on detections" in done.stderr
    assert not (tmp_path / "dock.yaml").exists()
