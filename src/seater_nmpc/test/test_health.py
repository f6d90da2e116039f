"""What the docking node says of each stage: the one that is to blame warns, and those behind it only wait."""

from __future__ import annotations

import math
from collections import Counter

import pytest

from seater_nmpc.health.stages import SIGHT, Sight, Solving, base, sequence, sight, solver
from seater_nmpc.health.word import Level
from seater_nmpc.observe.innovation import Outcome
from seater_nmpc.sequence.goal.results import Phase, Result, ResultCode

ODOMETRY = base(0.02, 0)
SOLVING = Solving(failures=0, slowed="", median=0.002, period=0.05, cycles=20.0)


def levels(seen: Sight, silence: float = 0.02) -> dict[str, Level]:
    return {stage: sight(stage, seen, base(silence, 0)).level for stage in SIGHT}


def unseen(**outcomes: int) -> Sight:
    counts = Counter({Outcome[name]: count for name, count in outcomes.items()})
    return Sight(goal=True, age=2.0, images=0.03, unused=counts, why="of 60 images ...")


@pytest.mark.parametrize(
    ("outcomes", "blamed"),
    [
        ({"EMPTY": 60}, "detection"),
        ({"EMPTY": 10, "FLIP": 50}, "pose"),
        ({"UNCERTAIN": 60}, "pose"),
        ({"GATE": 40, "ELSEWHERE": 15, "EMPTY": 5}, "observer"),
        ({"NO_ODOMETRY": 60}, "observer"),
        ({"FROZEN": 60}, "camera"),
        ({}, "observer"),
    ],
)
def test_what_became_of_the_images_says_who_is_to_blame(outcomes: dict[str, int], blamed: str) -> None:
    expected = {stage: Level.WARN if stage == blamed else Level.OK for stage in SIGHT}
    assert levels(unseen(**outcomes)) == expected


def test_without_a_goal_nobody_needs_to_see_the_dock() -> None:
    assert set(levels(unseen(EMPTY=60)._replace(goal=False)).values()) == {Level.OK}


def test_the_dock_was_seen_a_moment_ago() -> None:
    assert set(levels(unseen(EMPTY=3)._replace(age=0.3)).values()) == {Level.OK}


def test_perception_is_silent() -> None:
    said = levels(unseen()._replace(images=math.inf))
    assert (said["camera"], said["detection"], said["observer"]) == (Level.OK, Level.ERROR, Level.OK)


def test_without_odometry_the_base_is_named_and_nobody_else() -> None:
    assert base(2.3, 0).level is Level.ERROR
    assert "for 2.3 s" in base(2.3, 0).text
    assert "no odometry yet" in base(math.inf, 0).text
    assert set(levels(unseen(NO_ODOMETRY=60), silence=2.3).values()) == {Level.OK}
    assert solver(SOLVING._replace(cycles=0.0), base(2.3, 0)).level is Level.OK
    assert base(0.02, 3).level is Level.WARN


@pytest.mark.parametrize(
    ("changed", "level", "words"),
    [
        ({}, Level.OK, "in time"),
        ({"failures": 1}, Level.WARN, "1 cycles in a row without a solution"),
        ({"failures": 3}, Level.ERROR, "3 cycles in a row"),
        ({"slowed": "the chair disobeys"}, Level.WARN, "drives slowly: the chair disobeys"),
        ({"median": 0.035}, Level.WARN, "35 of 50 ms"),
        ({"cycles": 12.0}, Level.WARN, "12 cycles a second, 20 are wanted"),
    ],
)
def test_the_solver(changed: dict[str, float], level: Level, words: str) -> None:
    said = solver(SOLVING._replace(**changed), ODOMETRY)
    assert said.level is level
    assert words in said.text


def test_the_sequence_tells_its_phase_and_how_the_last_goal_ended() -> None:
    lost = Result(code=ResultCode.MARKER_LOST, text="not seen for 2 s")
    assert sequence(None, None, "").level is Level.OK
    assert sequence(Phase.FINAL, lost, "a person").text == "FINAL, held: a person"
    assert sequence(Phase.PAUSED, None, "").level is Level.WARN
    said = sequence(None, lost, "")
    assert said.level is Level.WARN
    assert "MARKER_LOST: not seen for 2 s" in said.text
    for code in (ResultCode.SUCCESS, ResultCode.CANCELED):
        assert sequence(None, Result(code=code, text=""), "").level is Level.OK
