"""Branches: which of two poses is the right one, and what is counted of those that corners alone decide."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from seater_eval.kinds import evaluate
from seater_eval.perception.images.scenes import facing
from seater_eval.photographs.branches import Branch, branch_of, count_broken
from seater_eval.photographs.detectors import CORNERS, SEATER, Found, make_detector
from seater_eval.photographs.evaluate import read_parameters
from seater_eval.photographs.report import broken_bar, describe_branches

RIGHT, OPEN = Branch(right=True, certain=True), Branch(right=True, certain=False)
WRONG, WRONG_OPEN = Branch(right=False, certain=True), Branch(right=False, certain=False)


@pytest.mark.parametrize(
    ("turned", "ambiguity", "expected"),
    [(0.1, 0.01, RIGHT), (0.1, 0.3, OPEN), (0.3, 0.01, WRONG), (0.3, 0.3, WRONG_OPEN)],
)
def test_branch_is_that_of_the_normal(turned: float, ambiguity: float, expected: Branch) -> None:
    """15 deg are 0.26 rad; a turn in the print's own plane is none of the normal."""
    pose = facing(0.0, 0.0, 1.0, yaw=turned, roll=1.0)
    found = Found(id=1, corners=np.zeros((4, 2)), pose=pose, ambiguity=ambiguity)
    assert branch_of(found, facing(0.0, 0.0, 1.0)) == expected


def test_what_is_broken_open_and_mended() -> None:
    """Only markers that both have, and only those that the corners call decided."""
    by_corners = {1: RIGHT, 2: RIGHT, 3: RIGHT, 4: RIGHT, 5: WRONG, 6: WRONG, 7: OPEN, 8: WRONG_OPEN, 9: RIGHT}
    shipped = {1: RIGHT, 2: OPEN, 3: WRONG, 4: WRONG_OPEN, 5: OPEN, 6: WRONG, 7: WRONG, 8: RIGHT, 10: WRONG}
    counts = count_broken(by_corners, shipped)
    assert counts == {"corners_decided": 4, "broken": 1, "open": 1, "corners_wrong": 2, "mended": 1}


def test_bar_asks_for_none_broken_of_some_decided() -> None:
    counts = {"corners_decided": 10, "broken": 0, "open": 3, "corners_wrong": 2, "mended": 1}
    assert broken_bar([counts, counts]).met and "20" in broken_bar([counts, counts]).note
    assert not broken_bar([counts, {**counts, "broken": 1}]).met
    assert not broken_bar([{**counts, "corners_decided": 0}]).met
    assert "break 1, leave 6 open" in describe_branches([counts, {**counts, "broken": 1}])


def test_corners_have_the_same_markers_with_poses_of_their_own() -> None:
    """Of one drawn image: the same search, and no pose of the photometric stage."""
    parameters = read_parameters(Path(__file__).resolve().parents[3] / "config")
    job = evaluate.KindJob("sharpened", 0.2, "DICT_4X4_50", 33.0, 3, parameters)
    prints, random = evaluate.scene(job)
    image = evaluate.photograph(prints, job.kind, job.shift, random)
    known, folder = evaluate._known(job, prints)
    by_corners, shipped = (
        {f.id: f for f in make_detector(name, folder, known, parameters)(image).found} for name in (CORNERS, SEATER)
    )
    assert by_corners.keys() == shipped.keys() and len(shipped) == 12
    assert {f.stage for f in by_corners.values()} <= {"edges", "corners"}
    assert "photometric" in {f.stage for f in shipped.values()}
    truth = {p.id: p.pose for p in prints}
    seen = evaluate.look(job)
    expected = count_broken(*({i: branch_of(f, truth[i]) for i, f in d.items()} for d in (by_corners, shipped)))
    assert seen.branches == expected and expected["corners_decided"] >= 6
