"""Ways to the bay: what the search finds, and how they are followed."""

import math
from dataclasses import replace

import numpy as np
import pytest
from driving import distance_to

from seater_common.field_of_view import FieldOfView
from seater_common.geometry import Chair, Dock
from seater_common.se2 import relative
from seater_nmpc.parameters import ControlParameters, PlannerParameters
from seater_nmpc.plan.free_space import FINAL_STRAIGHT
from seater_nmpc.plan.guide import Guide
from seater_nmpc.plan.lattice import BACKWARD, FORWARD, STAND, STAND_AFTER_FORWARD, Lattice
from seater_nmpc.plan.navigator import Navigator
from seater_nmpc.plan.path import Path
from seater_nmpc.plan.planner import Planner

CHAIR, DOCK, PARAMETERS, CONTROL = Chair(), Dock(), PlannerParameters(), ControlParameters()
FIELD = FieldOfView.symmetric(0.6)
BESIDE_THE_BAY = (-1.2, 0.8, -0.2)
BOX = np.array([[-2.4, -0.5], [-1.9, -0.5], [-1.9, 0.5], [-2.4, 0.5]])
BEHIND_THE_BOX = (-4.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner(CHAIR, DOCK, PARAMETERS, CONTROL.margin, FIELD)


@pytest.fixture(scope="module")
def boxed() -> Planner:
    planner = Planner(CHAIR, DOCK, PARAMETERS, CONTROL.margin, FIELD)
    planner.set_obstacles([BOX])
    return planner


def test_motions_of_the_lattice_are_those_of_a_unicycle() -> None:
    """A motion starts and ends along the headings of its nodes: chords of straights are exact, bends lie between."""
    lattice = Lattice(CHAIR, PARAMETERS)
    poses = lattice.poses()
    for motion in lattice.motions:
        start, end = lattice.edges(motion)
        first, last = poses[start[len(start) // 2]], poses[end[len(start) // 2]]
        x, y, turn = relative(first, last)
        if motion.heading == motion.heading_after:
            assert y == pytest.approx(0.0, abs=1e-12) and abs(x) > 0.0
        elif motion.shift != (0, 0):  # the chord's direction lies between the headings, on the side it turns to
            direction = math.atan2(y, x) if x > 0.0 else math.atan2(-y, -x)
            assert 0.0 < direction / turn < 1.0
        assert motion.duration >= abs(turn) / CHAIR.limits.omega_max - 1e-9
        assert math.hypot(x, y) <= CHAIR.limits.v_max * motion.duration + 1e-9


def test_ahead_of_the_bay_the_way_is_driven_forward(planner: Planner) -> None:
    path = planner.path((-2.5, 0.8, -0.35))
    assert path is not None and not np.any(path.backward)
    assert path.poses[0] == pytest.approx([-2.5, 0.8, -0.35])
    assert path.poses[-1, 1:] == pytest.approx([0.0, 0.0]) and path.poses[-1, 0] <= -CHAIR.length_front


def test_beside_the_bay_the_chair_backs_up_first(planner: Planner) -> None:
    path = planner.path(BESIDE_THE_BAY)
    assert path is not None and np.any(path.backward)
    assert all(distance_to(pose, DOCK.bay.outlines()) >= CONTROL.margin for pose in path.poses[1:])
    assert Guide(path, PARAMETERS).single is False


def test_the_way_leads_round_a_box_and_is_longer(planner: Planner, boxed: Planner) -> None:
    free, path = planner.path(BEHIND_THE_BOX), boxed.path(BEHIND_THE_BOX)
    assert free is not None and path is not None and path.duration > free.duration
    assert min(distance_to(pose, [BOX]) for pose in free.poses) < 0.0
    dense = np.vstack([np.linspace(a, b, 5) for a, b in zip(path.poses[1:], path.poses[2:], strict=False)])
    assert min(distance_to(pose, [*DOCK.bay.outlines(), BOX]) for pose in dense) >= CONTROL.margin


def test_no_way_in_is_said(boxed: Planner) -> None:
    assert boxed.open
    planner = Planner(CHAIR, DOCK, PARAMETERS, CONTROL.margin, FIELD)
    planner.set_obstacles([np.array([[-0.5, -0.2], [-0.2, -0.2], [-0.2, 0.2], [-0.5, 0.2]])])
    assert not planner.open and planner.path(BEHIND_THE_BOX) is None


def test_an_obstacle_in_the_bay_leaves_no_way_in() -> None:
    navigator = Navigator(CHAIR, DOCK, CONTROL, PARAMETERS)
    navigator.see([np.array([[0.1, 0.2], [0.3, 0.2], [0.3, 0.4], [0.1, 0.4]])])
    assert navigator.blocked() and not navigator.straight_way_clear((-1.5, 0.0, 0.0))


ROUND_THE_CHAIR = [
    np.array([[-3.2, -1.0], [-2.2, -1.0], [-2.2, -0.9], [-3.2, -0.9]]),
    np.array([[-3.2, 0.9], [-2.2, 0.9], [-2.2, 1.0], [-3.2, 1.0]]),
    np.array([[-3.3, -1.0], [-3.2, -1.0], [-3.2, 1.0], [-3.3, 1.0]]),
    np.array([[-1.8, -1.0], [-1.7, -1.0], [-1.7, 1.0], [-1.8, 1.0]]),
]


@pytest.mark.parametrize(
    ("start", "dock", "obstacles", "words"),
    [
        ((-20.0, 0.0, 0.0), DOCK, [], "outside the searched area: up to 5.5 m ahead of the dock"),
        ((-2.5, 0.0, 0.0), replace(DOCK, bay=replace(DOCK.bay, width=0.8)), [], "width of 0.800 m leaves 0.075 m"),
        ((-2.5, 0.0, 0.0), DOCK, [BOX + [1.7, 0.0]], "obstacles leave no way into the bay"),
        ((-2.35, 0.6, 0.0), DOCK, [BOX], "nearer than 0.080 m to an obstacle"),
        ((0.0, 0.35, 0.0), DOCK, [], "nearer than 0.080 m to a wall"),
        ((-2.7, 0.0, 0.0), DOCK, ROUND_THE_CHAIR, "walls and obstacles enclose the chair"),
    ],
)
def test_no_way_is_explained(start, dock, obstacles, words) -> None:
    """From each cause its own words; with a way again, none."""
    navigator = Navigator(CHAIR, dock, CONTROL, PARAMETERS)
    navigator.see(obstacles)
    assert navigator.target(start) is None and words in navigator.reason
    if dock is DOCK:
        navigator.see([])
        navigator.restart()
        assert navigator.target((-2.5, 0.3, 0.0)) is not None and navigator.reason == ""


def test_the_step_onto_the_lattice_is_no_leg_of_its_own(planner: Planner) -> None:
    """It was driven forward, by a decimetre, before a way that begins backward; only a large turn comes first."""
    rng, backward, turns = np.random.default_rng(3), 0, 0
    for x, y, turn in zip(
        rng.uniform(-4.0, -1.0, 100), rng.uniform(-1.5, 1.5, 100), rng.uniform(-0.45, 0.45, 100), strict=True
    ):
        path = planner.path((x, y, math.atan2(-y, 0.9 - x) + turn))
        if path is None:
            continue
        moves = np.hypot(*np.diff(path.poses[:, :2], axis=0).T) > 1e-9
        moves[0] = False
        first = int(np.argmax(moves))  # motion that drives
        if path.backward[1 + first]:
            large = abs(math.remainder(path.poses[first, 2] - path.poses[0, 2], 2.0 * math.pi)) > 0.4
            assert bool(path.backward[1]) is not large, path.poses[: first + 2]
            backward, turns = backward + 1, turns + large
    assert backward > 10 and 0 < turns < backward


def test_driving_backward_costs_more_than_its_time() -> None:
    changes = {change[:2]: change[2] for change in Lattice(CHAIR, PARAMETERS).mode_changes()}
    assert changes[STAND, BACKWARD] == pytest.approx(changes[BACKWARD, STAND] + 2.0)
    assert changes[STAND_AFTER_FORWARD, BACKWARD] == pytest.approx(changes[STAND, BACKWARD] + 3.0)
    assert changes[STAND, FORWARD] == changes[FORWARD, STAND_AFTER_FORWARD] == changes[STAND_AFTER_FORWARD, FORWARD]


@pytest.mark.parametrize("start", [(-1.8, 1.37, -1.01), (-1.58, -1.37, 0.96), (-1.06, 0.69, -0.43)])
def test_beside_the_bay_it_backs_up_first_rather_than_between_two_ways_forward(
    planner: Planner, start: tuple[float, float, float]
) -> None:
    """It was driven to the bay's corner, back from there, and in; a turn comes first where it stands."""
    path = planner.path(start)
    assert path is not None and np.any(path.backward)
    first = int(np.argmax(path.backward))  # the motion that ends in this pose
    assert path.poses[:first, :2] == pytest.approx(np.tile(path.poses[0, :2], (first, 1)))
    assert np.count_nonzero(np.diff(path.backward[first:].astype(int))) == 1


def test_an_open_dock_is_reached_on_a_final_straight() -> None:
    """No side walls: the way still joins the axis 0.3 m ahead of the dock, from beside it and from behind its line."""
    dock = replace(DOCK, bay=replace(DOCK.bay, side_wall_length=0.0))
    navigator = Navigator(CHAIR, dock, CONTROL, PARAMETERS)
    for start in ((-2.5, 0.8, -0.35), (-0.3, 1.2, 0.0), (-1.0, -1.0, 1.5)):
        navigator.restart()
        assert navigator.target(start) is not None, navigator.reason
        end = navigator._guide.rest()[-1]
        assert end[0] <= -FINAL_STRAIGHT + 1e-9 and end[1:] == pytest.approx([0.0, 0.0])
    assert navigator.straight_way_clear((-1.5, 0.0, 0.0))


@pytest.mark.filterwarnings("error")  # scipy warns of negative costs, for which Dijkstra's paths are wrong
@pytest.mark.parametrize(("front", "rear"), [(0.75, 0.30), (0.50, 0.55), (0.25, 0.80)])
def test_at_an_open_dock_no_part_of_a_way_costs_less_than_nothing(front: float, rear: float) -> None:
    """Rear-, mid- and front-wheel chairs: what lies ahead of the driven axle does not move the lane past the dock."""
    chair = replace(CHAIR, length_front=front, length_rear=rear)
    dock = replace(DOCK, bay=replace(DOCK.bay, side_wall_length=0.0))
    path = Planner(chair, dock, PARAMETERS, CONTROL.margin, FIELD).path((-2.5, 0.3, 0.0))
    assert path is not None and path.duration >= 2.5 / chair.limits.v_max


def test_the_guide_asks_for_the_turning_point_then_for_the_end() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [-0.5, 0.0, 0.0], [-1.0, 0.0, 0.0], [-0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    guide = Guide(Path(poses, np.array([False, True, True, False, False]), 1.0), PARAMETERS)
    assert guide.target([0.0, 0.0, 0.0], math.inf) == pytest.approx([-1.0, 0.0, 0.0]) and not guide.last_leg
    assert guide.target([-0.5, 0.0, 0.0], 0.25) == pytest.approx([-0.75, 0.0, 0.0])
    assert guide.target([-0.8, 0.0, 0.0], math.inf) == pytest.approx([-1.0, 0.0, 0.0])
    assert guide.target([-0.95, 0.0, 0.0], math.inf) == pytest.approx([0.0, 0.0, 0.0]) and guide.last_leg
    assert guide.away([-0.5, 0.3, 0.0]) == pytest.approx(0.3)


def test_beside_a_turning_point_the_chair_turns_round() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    for place, reached in (((-0.9, 0.2, 0.1), True), ((-0.85, 0.0, 0.0), False), ((-1.0, 0.3, 0.0), False)):
        guide = Guide(Path(poses, np.array([False, True, False]), 1.0), PARAMETERS)
        guide.target(place, math.inf)
        assert guide.last_leg is reached, place


def test_a_chair_that_stands_near_a_turning_point_turns_round() -> None:
    """13 cm and 0.29 rad off, more than counts as reached: after two seconds on the spot, and not while it moves."""
    poses = np.array([[-1.4, -1.3, 0.46], [-0.9, -0.7, 0.46], [-1.2, -0.8, 0.0], [-2.5, -0.8, 0.0]])
    guide = Guide(Path(poses, np.array([False, False, True, True]), 1.0), PARAMETERS)
    for k in range(60):
        guide.target([-0.77 - 0.001 * k, -0.70, 0.75], math.inf)
    assert not guide.last_leg
    for _ in range(45):
        guide.target([-0.77, -0.70, 0.75], math.inf)
    assert guide.last_leg and guide.target([-0.77, -0.70, 0.75], math.inf) == pytest.approx(poses[-1])
    far = Guide(Path(poses, np.array([False, False, True, True]), 1.0), PARAMETERS)
    for _ in range(60):
        far.target([-1.4, -1.3, 0.46], math.inf)
    assert not far.last_leg


def test_the_navigator_plans_anew_when_obstacles_move_or_the_chair_strays() -> None:
    navigator = Navigator(CHAIR, DOCK, CONTROL, replace(PARAMETERS, cell=0.2))
    navigator.see([])
    direct = navigator.target(BEHIND_THE_BOX)
    assert direct is not None and navigator.straight_way_clear(BEHIND_THE_BOX)
    navigator.see([BOX])
    assert not navigator.straight_way_clear(BEHIND_THE_BOX) and not navigator.blocked()
    around = navigator.target(BEHIND_THE_BOX)
    assert around is not None and np.hypot(*(around[:2] - direct[:2])) > 0.3
    guide = navigator._guide
    navigator.see([np.roll(BOX, 1, axis=0) + 0.001])
    navigator.target((-3.9, 0.0, 0.0))
    assert navigator._guide is guide
    navigator.target((-3.0, -1.5, 0.0))
    assert navigator._guide is not guide


def test_a_way_that_obstacles_leave_clear_is_kept_without_a_search(monkeypatch) -> None:
    navigator = Navigator(CHAIR, DOCK, CONTROL, replace(PARAMETERS, cell=0.2))
    navigator.see([BOX])
    navigator.target(BEHIND_THE_BOX)
    guide, searches = navigator._guide, []
    monkeypatch.setattr(Planner, "_search", lambda planner: searches.append(planner))
    navigator.see([BOX + [0.0, 0.06]] if guide.rest()[:, 1].mean() < 0.0 else [BOX - [0.0, 0.06]])  # away from the way
    navigator.see([])
    navigator.target(BEHIND_THE_BOX)
    assert navigator._guide is guide and not searches
    monkeypatch.undo()
    navigator.see([BOX + guide.rest()[3, :2] - BOX.mean(axis=0)])
    assert navigator._guide is None


def test_a_chair_that_got_stuck_at_the_bays_corner_leaves_it_and_comes_straight() -> None:
    """It went back to the same corner three times: the quickest way from where it had backed off to begins with a leg
    close past it."""
    roomy, stuck, backed_off = (
        Planner(CHAIR, DOCK, PARAMETERS, CONTROL.margin, FIELD, room=0.6),
        np.array([-0.83, -0.84, 0.77]),
        np.array([-1.2, -1.2, 0.77]),
    )
    for pose in (stuck, backed_off):
        path = roomy.path(pose)
        assert path is not None and np.any(path.backward)
        near = path.poses[:, 0] > -1.3
        assert not np.any(near[np.argmin(path.poses[:, 0]) :])  # once out of there, it keeps out
        assert np.count_nonzero(near) <= 4
    navigator = Navigator(CHAIR, DOCK, CONTROL)
    usual = navigator.target(backed_off)
    navigator.give_room()
    changed = navigator.target(backed_off)
    navigator.as_usual()
    navigator.restart()
    assert usual is not None and changed is not None and np.hypot(*(usual - changed)[:2]) > 0.3
    assert navigator.target(backed_off) == pytest.approx(usual)
