"""Commands after which the chair could not stop short of an obstacle do not leave."""

import math
from dataclasses import replace

import numpy as np
import pytest
from conftest import seldom

from seater_common.geometry import Chair, Dock, polygon_distance
from seater_common.se2 import arc_step
from seater_nmpc.control.braking import BrakingCheck, braked, curvature_at
from seater_nmpc.control.clearance import Clearance
from seater_nmpc.control.command import Status
from seater_nmpc.drive.axis import configured
from seater_nmpc.parameters import ControlParameters

CHAIR, CONTROL = Chair(), ControlParameters()
LIMITS, FRONT, PERIOD = CHAIR.limits, CHAIR.length_front, CONTROL.control_period
CHECK = BrakingCheck(CHAIR, 0.02, PERIOD, 0.1)


def box(x: float, y: float, half: float = 0.2) -> np.ndarray:
    return np.array([x, y]) + half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def box_ahead(gap: float) -> np.ndarray:
    return box(FRONT + gap + 0.2, 0.0)


def test_the_distance_is_that_of_hold_lag_and_braking() -> None:
    v = 0.6
    needed = v * (PERIOD + 0.1) + 0.5 * v * v / LIMITS.a_max + 0.02
    assert CHECK.passes(np.zeros(3), v, 0.0, [box_ahead(needed + 0.002)])
    assert not CHECK.passes(np.zeros(3), v, 0.0, [box_ahead(needed - 0.002)])
    assert CHECK.passes(np.zeros(3), 0.1, 0.0, [box_ahead(needed - 0.002)])


def test_the_footprint_counts_also_when_it_turns_on_the_spot() -> None:
    beside = box(FRONT, 0.5 * CHAIR.width + 0.2 + 0.05)  # 5 cm to the left of the front
    assert not CHECK.passes(np.zeros(3), 0.0, 0.8, [beside])
    assert CHECK.passes(np.zeros(3), 0.0, 0.05, [beside])
    assert CHECK.passes(np.zeros(3), 0.0, 0.0, [beside])


def test_the_way_out_stays_open() -> None:
    touching = [box_ahead(-0.01)]
    assert not CHECK.passes(np.zeros(3), 0.05, 0.0, touching)
    assert CHECK.passes(np.zeros(3), -0.3, 0.0, touching)


@pytest.mark.parametrize(("gap", "kept"), [(0.35, True), (0.20, False)])
def test_the_walls_of_the_bay_count_with_a_smaller_margin(gap: float, *, kept: bool) -> None:
    """At 0.4 m/s, with 0.2 s of lag and 0.05 s of hold, a chair needs 0.26 m and 2 cm."""
    bay, drive = Dock().bay, configured(CONTROL.prediction)
    clearance, at = Clearance(CHAIR, bay, CONTROL), np.array([bay.back_wall_x - FRONT - gap, 0.0, 0.0])
    assert (clearance.too_near(at, 0.4, 0.4, 0.0, None, PERIOD, drive) == "") == kept
    assert clearance.too_near(at, 0.0, -0.4, 0.0, None, PERIOD, drive) == ""
    free = Clearance(CHAIR, bay, replace(CONTROL, walls=False))
    assert free.too_near(at, 0.4, 0.4, 0.0, None, PERIOD, drive) == ""


def test_a_docked_chair_in_a_narrow_bay_may_creep_in() -> None:
    """2 cm to each side, 1 cm ahead of the dock."""
    bay = replace(Dock().bay, width=CHAIR.width + 0.04)
    clearance, at = Clearance(CHAIR, bay, CONTROL), np.array([-0.01, 0.01, 0.01])
    assert clearance.too_near(at, 0.1, 0.1, 0.0, None, PERIOD, configured(CONTROL.prediction)) == ""


def arc(curvature: float, length: float, pieces: int = 20) -> np.ndarray:
    """Poses on an arc from the origin, driven forward (backward with a negative length)."""
    step = length / pieces
    poses = [np.zeros(3)]
    for _ in range(pieces):
        poses.append(arc_step(poses[-1], step, curvature * step, 1.0))
    return np.array(poses)


def test_a_planned_path_that_stays_clear_for_the_stopping_distance_counts_too() -> None:
    """Bending away from a box that the present arc would lead into; what is beyond the stopping distance is ignored."""
    outline = [box(FRONT + 0.4, -0.35)]
    path = arc(1.5, 1.2)
    assert not CHECK.passes(np.zeros(3), 0.4, -0.1, outline)
    assert CHECK.passes(np.zeros(3), 0.4, -0.1, outline, path)
    assert not CHECK.passes(np.zeros(3), 0.4, -0.1, outline, arc(-0.2, 1.2))
    far = [box(path[-1, 0], path[-1, 1])]
    assert CHECK.passes(np.zeros(3), 0.4, -0.1, far, path)


def test_braking_keeps_the_curvature_of_the_path_or_of_the_last_command() -> None:
    assert braked((0.3, 0.2), 0.025, None) == pytest.approx((0.275, 0.2 * 0.275 / 0.3))
    assert braked((-0.3, 0.2), 0.025, None) == pytest.approx((-0.275, 0.2 * 0.275 / 0.3))
    assert braked((0.3, 0.2), 0.025, -0.5) == pytest.approx((0.275, -0.5 * 0.275))
    assert braked((0.02, 0.2), 0.025, 0.5) == (0.0, 0.0)


def test_curvature_of_a_path_forward_and_backward() -> None:
    assert curvature_at(arc(0.8, 1.0), [0.3, 0.1, 0.0]) == pytest.approx(0.8, rel=1e-3)
    assert curvature_at(arc(0.8, -1.0), [-0.3, 0.1, 0.0]) == pytest.approx(0.8, rel=1e-3)
    assert curvature_at(np.zeros((5, 3)), np.zeros(3)) is None


@pytest.mark.parametrize("gap", [0.55, seldom(0.7), 1.0])
def test_a_box_that_appears_ahead_is_not_touched(controller, gap) -> None:
    """At full speed, out of nowhere: the nearest is little more than what the chair needs to stop (0.45 m)."""
    controller.reset()
    controller.set_obstacles([])
    pose, velocity = np.array([-4.0, 0.3, 0.0]), (0.0, 0.0)
    outline, nearest = None, math.inf
    for cycle in range(160):
        if cycle == 40:
            outline = box(pose[0] + FRONT + gap + 0.2, pose[1])
            controller.set_obstacles([outline])
            assert velocity[0] > 0.55
        command = controller.command(pose, velocity, [0.0, 0.0, 0.0])
        velocity = (command.v, command.omega)
        pose = arc_step(pose, *velocity, PERIOD)
        if outline is not None:
            nearest = min(nearest, polygon_distance(CHAIR.corners_at(pose), outline))
    controller.set_obstacles([])
    assert nearest > 0.0


def test_where_it_cannot_stop_it_brakes_as_hard_as_it_may(controller) -> None:
    controller.reset()
    pose, velocity = np.array([-4.0, 0.0, 0.0]), (0.0, 0.0)
    for _ in range(40):
        command = controller.command(pose, velocity, [0.0, 0.0, 0.0])
        velocity, pose = (command.v, command.omega), arc_step(pose, command.v, command.omega, PERIOD)
    controller.set_obstacles([box(pose[0] + FRONT + 0.3, pose[1])])
    before = controller.counters.obstacle_stops
    command = controller.command(pose, velocity, [0.0, 0.0, 0.0])
    controller.set_obstacles([])
    assert command.status is Status.FALLBACK_BRAKE and "stopping distance" in command.text
    assert command.v == pytest.approx(velocity[0] - LIMITS.a_max * PERIOD)
    assert controller.counters.obstacle_stops == before + 1
    assert controller.counters.consecutive_failures == 0
