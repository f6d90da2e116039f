"""The chair turned about, for docks that are entered backward."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from conftest import AT_ONCE, World

from seater_common.geometry import CameraMount, Chair, Dock, pose_matrix
from seater_common.se2 import arc_step, compose
from seater_nmpc.control.command import Command
from seater_nmpc.control.controller import DockingController
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.sequence.docking_sequence import DockingSequence
from seater_nmpc.sequence.goal.results import ResultCode
from seater_nmpc.sequence.vehicle import Vehicle, turned_about

REAR_CAMERA = Chair(camera=CameraMount(x=-0.20, yaw=math.pi))
BACKWARD = Dock(direction="backward")


def test_footprint_and_limits_change_ends() -> None:
    chair = turned_about(Chair())
    assert (chair.length_front, chair.length_rear, chair.width) == (0.30, 0.75, 0.65)
    assert (chair.limits.v_max, chair.limits.v_reverse_max) == (0.3, 0.6)
    here = np.array([1.0, 2.0, 0.4])
    corners = chair.corners_at(compose(here, [0.0, 0.0, math.pi]))
    assert np.roll(corners, 2, axis=0) == pytest.approx(Chair().corners_at(here))


@pytest.mark.parametrize("yaw", [math.pi, 3.0, -3.0, 0.0, -math.pi])
def test_camera_mount_is_turned_by_pi_about_z(yaw: float) -> None:
    mount = CameraMount(x=-0.2, y=0.1, z=0.8, roll=0.05, pitch=-0.3, yaw=yaw)
    expected = pose_matrix([0.0, 0.0, math.pi]) @ mount.T_base_optical()
    turned = turned_about(Chair(camera=mount)).camera
    assert turned.T_base_optical() == pytest.approx(expected, abs=1e-12)
    assert -math.pi <= turned.yaw <= math.pi


def test_a_chair_that_cannot_reverse_is_refused() -> None:
    chair = replace(Chair(), limits=replace(Chair().limits, v_reverse_max=0.0))
    with pytest.raises(ValueError, match=r"v_reverse_max: is 0\.0, must be > 0"):
        Vehicle(chair, BACKWARD)
    assert Vehicle(chair, Dock()).chair == chair


def test_odometry_in_and_command_out_literally() -> None:
    vehicle = Vehicle(Chair(), BACKWARD)
    inside = vehicle.odometry(Odometry(1.5, np.array([1.0, 2.0, 0.5]), -0.2, 0.3))
    assert (inside.stamp, inside.v, inside.omega) == (1.5, 0.2, 0.3)
    assert inside.pose == pytest.approx([1.0, 2.0, 0.5 - math.pi])
    outside = vehicle.command(Command(v=0.2, omega=0.3, path=np.array([[1.0, 2.0, 0.5 - math.pi]])))
    assert (outside.v, outside.omega) == (-0.2, 0.3)
    assert outside.path == pytest.approx(np.array([[1.0, 2.0, 0.5]]))
    stop = vehicle.command(Command(v=0.0, omega=0.0))
    assert math.copysign(1.0, stop.v) == 1.0 and stop.path.shape == (0, 3)


def test_the_turned_chair_drives_the_same_arc() -> None:
    vehicle, pose = Vehicle(Chair(), BACKWARD), np.array([1.0, 2.0, 0.5])
    inside = vehicle.odometry(Odometry(0.0, pose, -0.2, 0.3))
    moved = arc_step(inside.pose, inside.v, inside.omega, 1.0)
    assert vehicle.pose(moved) == pytest.approx(arc_step(pose, -0.2, 0.3, 1.0))


def test_odometry_of_nan_stays_so_and_forward_is_untouched() -> None:
    bad = Odometry(0.0, np.array([1.0, 2.0, math.inf]), 0.0, 0.0)
    assert not Vehicle(Chair(), BACKWARD).odometry(bad).is_finite()
    forward, command = Vehicle(Chair(), Dock()), Command(v=0.2, omega=0.3)
    assert forward.odometry(bad) is bad and forward.command(command) is command and forward.chair == Chair()


@pytest.fixture(scope="module")
def backward_controller() -> DockingController:
    parameters = replace(ControlParameters(prediction=AT_ONCE), solver="rti", horizon=15, step=0.2)
    return DockingController(turned_about(REAR_CAMERA), BACKWARD, parameters, deterministic=True)


@pytest.fixture
def make_backward(backward_controller: DockingController) -> Callable[[list[float]], World]:
    def make(start: list[float]) -> World:
        vehicle = Vehicle(REAR_CAMERA, BACKWARD)
        backward_controller.reset()
        observer = DockObserver(vehicle.chair.camera)
        sequence = DockingSequence(vehicle.chair, BACKWARD, backward_controller, observer)
        return World(sequence, REAR_CAMERA, BACKWARD, np.array(start), vehicle=vehicle)

    return make


def assert_stands_within_limits(world: World) -> None:
    limits = world.chair.limits
    speeds = [command.v for command in world.commands]
    assert max(speeds) <= limits.v_max + 1e-9 and min(speeds) >= -limits.v_reverse_max - 1e-9
    assert (world.commands[-1].v, world.commands[-1].omega) == (0.0, 0.0)
    assert world.smallest_clearance > 0.0


def test_docks_backward_from_an_offset_start(make_backward) -> None:
    world = make_backward([-2.0, 0.4, math.pi - 0.2])
    world.tick()
    world.sequence.start_dock(world.now)
    step = world.run(60.0)
    assert step.result is not None and step.result.code is ResultCode.SUCCESS, step.result
    error = BACKWARD.docking_error(world.truth)
    assert np.hypot(*error[:2]) <= 0.010 and abs(error[2]) <= math.radians(1.0)
    assert min(command.v for command in world.commands) < -0.2
    assert_stands_within_limits(world)


def test_undocks_forward_out_of_the_bay(make_backward) -> None:
    world = make_backward([0.0, 0.0, math.pi])
    world.seen = lambda w: False
    world.tick()
    world.sequence.start_undock(world.now, force=True)
    step = world.run(30.0)
    assert step.result is not None and step.result.success
    assert BACKWARD.docking_error(world.truth) == pytest.approx([BACKWARD.predock_x, 0.0, 0.0], abs=0.1)
    assert max(command.v for command in world.commands) > 0.1
    assert_stands_within_limits(world)
