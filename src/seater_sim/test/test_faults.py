"""Faults that are injected into a running simulation: what the motors, the odometry and the camera make of them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from seater_common.camera_model import CameraModel
from seater_common.geometry import CameraMount
from seater_sim.chair.interface import OdometrySample
from seater_sim.faults import kinds
from seater_sim.faults.camera import CameraFault
from seater_sim.faults.plant import OdometryFault, PlantFault
from seater_sim.world.events import GOOD, NAN

SAMPLE = OdometrySample(5_000_000_000, np.array([1.0, 2.0, 0.5 * math.pi]), 0.4, 0.1, np.eye(3), np.eye(2))
LATER = replace(SAMPLE, time_ns=5_020_000_000, pose=np.array([1.0, 2.5, 0.5 * math.pi]), v=0.5)


@pytest.mark.parametrize(
    ("component", "kind", "values", "words"),
    [
        ("wheels", "off", [], "no component 'wheels'; there are plant, odometry, camera"),
        ("camera", "tired", [], "camera has no fault 'tired'; it has frozen"),
        ("plant", "runaway", [], r"takes 1 to 2 values \(V \[m/s\], OMEGA \[rad/s\]\), got 0"),
        ("camera", "late", [0.1, 0.2], r"takes 1 values \(SECONDS\), got 2"),
        ("odometry", "scale", [math.nan], "not finite"),
    ],
)
def test_a_wrong_wish_is_refused_with_what_there_is(component: str, kind: str, values: list[float], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        kinds.read(component, kind, values)


def test_values_that_may_be_left_out_are_zero() -> None:
    assert kinds.read("plant", "runaway", [0.3]) == (0.3, 0.0)
    assert kinds.read("camera", kinds.CLEAR, []) == ()


@pytest.mark.parametrize(
    ("kind", "values", "driven"),
    [
        (kinds.CLEAR, (), (0.4, 0.2)),
        ("runaway", (0.3, -0.1), (0.3, -0.1)),
        ("stuck", (), (0.0, 0.0)),
        ("reversed", (), (-0.4, 0.2)),
        ("left_motor_dead", (), (0.225, 0.9)),  # the right wheel at 0.4 + 0.25 * 0.2 = 0.45 m/s, the left one stands
        ("right_motor_dead", (), (0.175, -0.7)),
        ("deaf", (), (0.4, 0.2)),
    ],
)
def test_what_reaches_the_motors(kind: str, values: tuple[float, ...], driven: tuple[float, float]) -> None:
    fault = PlantFault(track=0.5)
    fault.set(kind, values)
    assert fault.command(0.4, 0.2) == pytest.approx(driven)
    assert fault.persists == (kind in ("runaway", "deaf"))


def changed(kind: str, *values: float) -> OdometrySample | None:
    """The second of two messages."""
    fault = OdometryFault()
    fault.set(kind, values)
    fault.apply(SAMPLE)
    return fault.apply(LATER)


def test_odometry_that_is_frozen_has_fresh_stamps() -> None:
    frozen = changed("frozen")
    assert frozen is not None and frozen.time_ns == LATER.time_ns and (frozen.v, frozen.omega) == (0.0, 0.0)
    assert np.array_equal(frozen.pose, SAMPLE.pose)


def test_odometry_with_wrong_stamps_or_none() -> None:
    zero, late = changed("zero_stamps"), changed("late", 0.5)
    assert zero is not None and late is not None
    assert (zero.time_ns, late.time_ns) == (0, LATER.time_ns - 500_000_000)
    assert changed("off") is None


def test_odometry_that_measures_wrongly() -> None:
    scaled, jumped, nan, still = (
        changed("scale", 2.0),
        changed("jump", 0.5, 0.0, 90.0),
        changed("nan"),
        changed("zero_twist"),
    )
    assert scaled is not None and jumped is not None and nan is not None and still is not None
    assert scaled.pose == pytest.approx([1.0, 3.0, 0.5 * math.pi]) and scaled.v == 1.0
    # the old odom frame stands at (0.5, 0) and is turned by 90 deg: (1, 2.5) lies at (0.5 - 2.5, 1)
    assert jumped.pose == pytest.approx([-2.0, 1.0, math.pi])
    assert np.all(np.isnan(nan.pose)) and math.isnan(nan.v)
    assert (still.v, still.omega) == (0.0, 0.0) and np.array_equal(still.pose, LATER.pose)


def test_odometry_now_and_then() -> None:
    fault = OdometryFault()
    fault.set("slow", (1.0,))
    sent = [fault.apply(replace(SAMPLE, time_ns=20_000_000 * k)) for k in range(151)]
    assert [k for k, one in enumerate(sent) if one is not None] == [0, 50, 100, 150]


def test_odometry_of_another_body_says_so() -> None:
    ahead = changed("other_frame", 0.3)
    assert ahead is not None and ahead.frame == "chair_front" and SAMPLE.frame == "base_link"
    assert ahead.pose == pytest.approx([1.0, 2.8, 0.5 * math.pi])


def test_a_jump_stays_when_the_odometry_is_whole_again() -> None:
    fault = OdometryFault()
    fault.set("jump", (0.5, 0.0, 0.0))
    fault.set(kinds.CLEAR, ())
    after = fault.apply(SAMPLE)
    assert after is not None and after.pose == pytest.approx([1.5, 2.0, 0.5 * math.pi])


def test_what_the_camera_sees_from_where() -> None:
    fault, pose = CameraFault(), np.array([-1.0, 0.2, 0.1])
    assert np.array_equal(fault.seen_from(pose), pose) and fault.mode == GOOD and fault.delay == 0.0
    fault.set("dock_moved", (0.0, 0.3, 0.0))
    assert fault.seen_from(pose) == pytest.approx([-1.0, -0.1, 0.1])  # the dock went left, so the chair is right of it
    fault.set("knocked", (10.0, -5.0))
    mount = fault.mount(CameraMount(yaw=0.1, pitch=0.2))
    assert (mount.yaw, mount.pitch) == pytest.approx((0.1 + math.radians(10.0), 0.2 - math.radians(5.0)))
    fault.set("nan", ())
    assert fault.mode == NAN and np.array_equal(fault.seen_from(pose), pose)
    fault.set("late", (0.4,))
    assert (fault.delay, fault.period) == (0.4, 0.0)
    fault.set("slow", (1.0,))
    assert (fault.delay, fault.period) == (0.0, 1.0)


def test_a_wrong_focal_length_keeps_the_principal_point() -> None:
    K = np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]])
    model = CameraModel(640, 480, "plumb_bob", np.zeros(5), K, np.eye(3), np.hstack([K, np.zeros((3, 1))]))
    fault = CameraFault()
    assert fault.told(model) is model
    fault.set("focal", (1.1,))
    told = fault.told(model)
    for matrix in (told.K, told.P):
        assert (matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]) == pytest.approx((660.0, 660.0, 320.0, 240.0))
    assert model.K[0, 0] == 600.0
    fault.set("resized", (0.5,))
    told = fault.told(model)
    assert (told.width, told.height, told.K[0, 0], told.P[1, 2]) == (320, 240, 300.0, 120.0)
    fault.set("nan_distortion", ())
    assert np.isnan(fault.told(model).D).tolist() == [True, False, False, False, False]


def test_a_shifted_or_zoomed_picture_and_a_camera_info_that_knows_nothing_of_it() -> None:
    K = np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]])
    model = CameraModel(640, 480, "plumb_bob", np.zeros(5), K, np.eye(3), np.hstack([K, np.zeros((3, 1))]))
    fault = CameraFault()
    assert fault.lens(model) is model
    for kind, values, expected in [
        ("shifted", (10.0, -3.0), (600.0, 330.0, 237.0)),
        ("zoomed", (0.9,), (540.0, 320.0, 240.0)),
    ]:
        fault.set(kind, values)
        lens = fault.lens(model)
        for matrix in (lens.K, lens.P):
            assert (matrix[1, 1], matrix[0, 2], matrix[1, 2]) == pytest.approx(expected)
        assert fault.told(model) is model
    assert model.K[0, 2] == 320.0


def test_without_a_master_the_command_says_what_to_start(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    failure = pytest.importorskip("seater_sim.ros.failure")
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:1")
    assert failure.main(["failure", "camera", "frozen"]) == 1
    assert "no ROS master answers at http://localhost:1: start sim.launch" in capsys.readouterr().err
