"""What the page shows: places, words, and nothing that is too old."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock
from seater_panel.view.heard import Gate, Heard, Motion, Outlines, Planned, Points, Progress, Result, Sight, Sights
from seater_panel.view.model import view
from seater_panel.view.scene import ellipse, scene

NOW = 100.0
GATE = Gate(time=NOW, state="REQUEST", reason="docking drives")
PROGRESS = Progress(time=NOW, action="dock", phase="APPROACH", distance=2.0, elapsed=3.0, retries=0, marker_seen=True)
RESULT = Result(
    time=NOW - 10.0, action="dock", code=0, name="SUCCESS", text="docked", success=True, error=(0.003, 0.004, 0.002)
)
# The dock lies 2 m ahead of odom's origin and is turned by 90 degrees to the left; the chair is 1 m before it.
DOCK_POSE = np.array([2.0, 0.0, math.pi / 2])
MOTION = Motion(time=NOW, pose=np.array([2.0, -1.0, math.pi / 2]), v=0.2)
ALL = Heard(gate=GATE, motion=MOTION, progress=PROGRESS, dock=DOCK_POSE)


def shown(heard: Heard) -> dict:
    found = view(heard, Chair(), Dock(), NOW)
    json.dumps(found, allow_nan=False)
    return found


def held_by(state: str, reason: str) -> Heard:
    return replace(ALL, gate=replace(GATE, state=state, reason=reason))


def seen(heard: Heard) -> dict:
    return scene(heard, Chair(), Dock(), NOW)


def test_the_scene_is_seen_from_the_dock() -> None:
    found = seen(ALL)
    assert found["frame"] == "dock"
    assert found["pose"] == pytest.approx([-1.0, 0.0, 0.0])
    assert found["chair"][0] == pytest.approx([-0.25, 0.325])  # front left
    assert len(found["bay"]) == 3
    assert found["docked"][0] == pytest.approx([0.75, 0.325])
    assert found["plates"][0]["ends"] == [[0.9, 0.05], [0.9, -0.05]]


def test_the_dock_in_use_is_shown_and_the_others_are_named() -> None:
    wide = replace(Dock(), name="hall", bay=replace(Dock().bay, back_wall_x=1.5))
    found = shown(replace(ALL, in_use=wide, docks=("lab", "hall")))
    assert (found["dock"], found["docks"]) == ("hall", ["lab", "hall"])
    assert found["scene"]["bay"] == [
        [pytest.approx(corner) for corner in outline.tolist()] for outline in wide.bay.outlines()
    ]
    assert (shown(ALL)["dock"], shown(ALL)["docks"]) == ("default", [])


def test_path_and_obstacles_in_odom_are_seen_from_the_dock() -> None:
    planned = Planned(time=NOW, path=np.array([[2.0, -0.5]]))
    told = Outlines(in_dock=False, polygons=(np.array([[1.0, 0.0], [1.0, 1.0], [0.5, 0.5]]),))
    found = seen(replace(ALL, planned=planned, outlines=told))
    assert found["path"][0] == pytest.approx([-0.5, 0.0])
    assert found["obstacles"][0][0] == pytest.approx([0.0, 1.0])  # beside the dock, to its left


def test_obstacles_of_the_dock_and_points_of_the_chair() -> None:
    told = Outlines(in_dock=True, polygons=(np.array([[-2.0, 0.0], [-1.7, 0.0], [-1.7, 0.3]]),))
    points = Points(time=NOW, points=np.array([[1.0, 0.5]]))
    found = seen(replace(ALL, outlines=told, points=points))
    assert found["obstacles"][0][0] == pytest.approx([-2.0, 0.0])
    assert found["points"] == [pytest.approx([0.0, 0.5])]


def test_a_sight_is_turned_with_its_covariance() -> None:
    """3 cm uncertain along odom's x, which is minus y of the dock."""
    sight = Sight(id=7, place=np.array([2.0, 0.9]), covariance=np.diag([0.03**2, 0.01**2]))
    candidates = ((DOCK_POSE, 0.8),)
    found = seen(replace(ALL, sights=Sights(time=NOW, markers=(sight,), candidates=candidates)))
    marker = found["markers"][0]
    assert marker["at"] == pytest.approx([0.9, 0.0])
    assert marker["axes"][:2] == pytest.approx([0.06, 0.02])
    assert abs(math.cos(marker["axes"][2])) == pytest.approx(0.0, abs=1e-3)
    assert found["candidates"] == [{"pose": pytest.approx([0.0, 0.0, 0.0]), "weight": 0.8}]


def test_without_a_dock_the_chair_is_the_middle() -> None:
    told = Outlines(in_dock=True, polygons=(np.zeros((3, 2)),))
    found = seen(replace(ALL, dock=None, outlines=told))
    assert found["frame"] == "chair"
    assert found["pose"] == [0.0, 0.0, 0.0]
    assert "bay" not in found
    assert "obstacles" not in found  # nobody knows where they are


def test_what_is_old_is_not_shown() -> None:
    old = NOW - 1.1
    sight = Sight(id=0, place=np.zeros(2), covariance=np.eye(2))
    heard = Heard(
        gate=replace(GATE, time=old),
        motion=replace(MOTION, time=old),
        progress=replace(PROGRESS, time=old),
        planned=Planned(time=old, path=np.zeros((3, 2))),
        sights=Sights(time=old, markers=(sight,), candidates=()),
        points=Points(time=old, points=np.zeros((3, 2))),
        dock=DOCK_POSE,
        image=NOW - 3.0,
    )
    found = shown(heard)
    assert [found[key] for key in ("speed", "distance", "active", "gate", "image")] == [None, None, None, None, False]
    assert not {"path", "markers", "points"} & set(found["scene"])
    assert found["title"] == "No safety gate"


def test_many_points_are_thinned_out() -> None:
    points = Points(time=NOW, points=np.random.default_rng(1).normal(size=(5000, 2)))
    assert 100 <= len(seen(replace(ALL, points=points))["points"]) <= 200


def test_nothing_was_heard_yet() -> None:
    found = shown(Heard())
    assert found["title"] == "No safety gate"
    assert found["scene"]["frame"] == "chair"


@pytest.mark.parametrize(
    ("heard", "title", "reason"),
    [
        (ALL, "Driving to the dock", ""),
        (replace(ALL, progress=replace(PROGRESS, marker_seen=False)), "Driving to the dock", "No marker in view"),
        (replace(ALL, progress=replace(PROGRESS, retries=1)), "Driving to the dock", "Try 2."),
        (replace(ALL, progress=replace(PROGRESS, phase="WAITING_FOR_DOCK")), "Looking for the dock", "stands until"),
        (held_by("OBSTACLE", "0.3 m to a point"), "Something is in the way", "0.3 m"),
        (held_by("EMERGENCY_STOP", "the button"), "Emergency stop", "The button."),
        (held_by("RUNAWAY", "it drives at 0.4 m/s"), "Motors switched off", "It drives"),
        (held_by("USER", "the joystick drives"), "Joystick drives", "Let the joystick go"),
        (replace(ALL, progress=None, result=RESULT), "Docked", "Docked."),
        (replace(ALL, result=replace(RESULT, time=NOW)), "Docked", ""),  # the feedback is older than the result
        (
            replace(ALL, progress=None, result=replace(RESULT, success=False, text="in the way")),
            "Stopped",
            "In the way.",
        ),
        (replace(ALL, progress=None), "Ready", "Hold a button"),
    ],
)
def test_words(heard: Heard, title: str, reason: str) -> None:
    found = shown(heard)
    assert found["title"] == title
    assert reason in found["reason"]


def test_result_and_distance() -> None:
    found = shown(replace(ALL, progress=None, result=RESULT))
    assert found["result"]["error"] == {"distance": 5.0, "heading": pytest.approx(0.1146)}
    assert found["result"]["age"] == 10.0
    assert found["distance"] == pytest.approx(1.0)


def test_an_ellipse_has_two_standard_deviations() -> None:
    c, s = math.cos(0.4), math.sin(0.4)
    R = np.array([[c, -s], [s, c]])
    large, small, direction = ellipse(R @ np.diag([0.04, 0.01]) @ R.T)
    assert (large, small) == pytest.approx((0.4, 0.2))
    assert math.tan(direction) == pytest.approx(math.tan(0.4))
