"""From beside the bay the controller alone drives up to the wall's corner and finds no way on: it has to go round."""

from __future__ import annotations

import math

import numpy as np
import pytest
from chairs import SlowChair

from seater_common.geometry import Chair, Dock
from seater_common.se2 import relative, wrap_angle
from seater_common.way_clearance import smallest_clearance
from seater_nmpc.control.controller import DockingController
from seater_nmpc.control.way_round import WayRound
from seater_nmpc.drive.axis import AxisDrive
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.plan.back_off import BackOff

PERIOD = 0.05
BESIDE = (-1.3438, 1.2052, -1.0057)  # x [m], y [m], heading [rad]


def test_a_chair_beside_the_bay_goes_round_its_corner_and_docks() -> None:
    """With its delay, lag and deadbands it stood at the corner, and drove to and fro there for as long as it was left
    to (64 changes of direction in a minute)."""
    chair = SlowChair(BESIDE, 0.25, 0.2, AxisDrive(1.0, 0.02), AxisDrive(1.0, 0.05))
    controller, poses, speeds = DockingController(Chair(), Dock(), deterministic=True), [], []
    while chair.now < 50.0 and not (math.hypot(*chair.pose[:2]) < 0.01 and abs(chair.v) < 1e-3):
        command = controller.command(chair.pose, (chair.v, chair.omega), np.zeros(3), "dock", chair.now)
        chair.drive((command.v, command.omega), PERIOD)
        poses.append(chair.pose.copy())
        speeds.append(chair.v)
    assert math.hypot(*chair.pose[:2]) < 0.01 and abs(math.degrees(chair.pose[2])) < 1.0
    assert smallest_clearance(Chair(), Dock().bay, np.array(poses)) > 0.0
    signs = np.sign([v for v in speeds if abs(v) > 0.01])
    assert np.sum(signs[1:] != signs[:-1]) <= 8


@pytest.fixture
def way_round() -> WayRound:
    return WayRound(Chair(), Dock(), ControlParameters(), None)


def stand(way_round: WayRound, pose: tuple[float, float, float], target: object = "dock") -> np.ndarray:
    """Where it is to drive to after five seconds on the spot."""
    for stamp in np.arange(0.0, 5.0, 0.05):
        towards = way_round.towards(target, float(stamp), np.array(pose), [])
    return towards


def test_it_backs_off_then_drives_along_a_planned_way(way_round: WayRound) -> None:
    back = stand(way_round, BESIDE)
    assert math.dist(back[:2], BESIDE[:2]) == pytest.approx(0.6) and back[2] == pytest.approx(BESIDE[2])
    planned = way_round.towards("dock", 6.0, back, [])
    assert planned[0] < -0.5 and math.hypot(*planned[:2]) > 0.5


def test_a_chair_that_backs_towards_a_wall_of_the_bay_stops_before_it_then_gets_away() -> None:
    """From here the optimisation saw the way to the dock through the side wall, and the chair was driven into it."""
    chair, controller, poses = SlowChair((-0.13, -1.1, -1.57), 0.25, 0.2), DockingController(Chair(), Dock()), []
    texts = set()
    while chair.now < 10.0:
        command = controller.command(chair.pose, (chair.v, chair.omega), np.zeros(3), "dock", chair.now)
        chair.drive((command.v, command.omega), PERIOD)
        poses.append(chair.pose.copy())
        texts.add(command.text)
    clearances = [smallest_clearance(Chair(), Dock().bay, [pose]) for pose in poses[::5]]
    assert min(clearances) > 0.0 and clearances[-1] > 0.3
    assert "a wall of the bay is within the stopping distance" in texts


@pytest.mark.parametrize("start", [(-2.05, -0.02, 2.82), (-3.9, -0.22, -2.61)])
def test_a_chair_that_looks_away_turns_round_where_it_stands(start: tuple[float, float, float]) -> None:
    """The markers behind it were fewer metres out of view the farther it drove past them: asked to turn on the spot
    2 m before the dock, it drove backward into the bay, to 0.5 m beyond the dock's place."""
    chair, controller = SlowChair(start, 0.25, 0.2), DockingController(Chair(), Dock(), deterministic=True)
    towards, far = [start[0], start[1], math.atan2(-start[1], -start[0])], 0.0
    while chair.now < 6.0 and abs(wrap_angle(chair.pose[2] - towards[2])) > 0.2:
        command = controller.command(chair.pose, (chair.v, chair.omega), np.zeros(3), towards, chair.now)
        chair.drive((command.v, command.omega), PERIOD)
        far = max(far, math.dist(chair.pose[:2], start[:2]))
    assert chair.now < 6.0 and far < 0.35


def test_where_backing_off_got_nowhere_the_next_leads_ahead_until_another_goal_begins() -> None:
    back_off, here = BackOff(0.1), np.array(BESIDE)
    ahead = []
    for begin in (0.0, 10.0, 20.0):
        back_off.begin(begin, here)
        ahead.append(float(relative(here, back_off.target(begin, here))[0]))
        assert back_off.target(begin + 8.0, here) is None
    back_off.forget()
    back_off.begin(30.0, here)
    ahead.append(float(relative(here, back_off.target(30.0, here))[0]))
    assert ahead == pytest.approx([-0.6, 0.6, -0.6, -0.6])
    back_off.forget()
    back_off.begin(40.0, here)
    assert relative(here, back_off.target(40.0, here))[0] == pytest.approx(-0.6)


def test_from_straight_ahead_it_drives_for_the_dock_however_long_it_stands(way_round: WayRound) -> None:
    assert stand(way_round, (-1.0, 0.02, 0.05)) == pytest.approx(np.zeros(3))


def test_another_target_is_taken_as_it_is(way_round: WayRound) -> None:
    assert stand(way_round, BESIDE, [-1.0, 0.5, 0.2]) == pytest.approx([-1.0, 0.5, 0.2])
    assert stand(way_round, BESIDE, "predock") == pytest.approx([Dock().predock_x, 0.0, 0.0])
