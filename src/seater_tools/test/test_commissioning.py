"""From the box to the docked chair: the commands one after the other, at a small installation that they do not know."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from printed import CONFIG

from seater_common.camera_model import CameraModel
from seater_common.params import ParameterError
from seater_tools.board.board import Board
from seater_tools.commissioning.hidden import FOCAL, PAPER, draw_hidden
from seater_tools.commissioning.report import bars, draw, end_of, table
from seater_tools.correct.scale import printed_scale
from seater_tools.lens.coverage import missing_views
from seater_tools.lens.find import FEWEST_CORNERS, View
from seater_tools.trial.drive import Face, To

SHORT = (
    To(-0.6),
    To(-1.8),
    Face(0.5),
    Face(-0.5),
    Face(0.0),
    To(-0.5),
    To(-1.2),
    Face(-0.4),
    Face(0.4),
    Face(0.0),
    To(-2.0),
)


def test_the_truth_is_as_far_off_as_asked_for() -> None:
    nominal = CameraModel.load(CONFIG / "cameras" / "d455.yaml").K[0, 0]
    drawn = [draw_hidden(CONFIG, seed) for seed in range(40)]
    focal = np.array([hidden.lens.K[0, 0] / nominal - 1.0 for hidden in drawn])
    assert 0.05 < np.abs(focal).max() <= FOCAL
    sizes = np.array([hidden.dock.markers[0].size / 0.1 - 1.0 for hidden in drawn])
    assert 0.01 < np.abs(sizes).max() < 0.022  # one printer's scale and what prints differ by
    assert {hidden.plant for hidden in drawn} == {"indoor_chair", "worn_chair"}
    assert {bool(hidden.bars) for hidden in drawn} == {True, False}
    assert draw_hidden(CONFIG, 3).chair == drawn[3].chair


def test_an_installation_is_commissioned_and_docks(tmp_path: Path) -> None:
    """A small version of what takes the campaign a minute and a half: images of 640 x 480 at 3 Hz, a short drive. What
    identification and doctor make of an installation has tests of its own."""
    pytest.importorskip("seater_perception")
    pytest.importorskip("rosbag")
    from seater_tools.commissioning.job import Job, commission_at

    hidden = draw_hidden(CONFIG, 2)
    K = np.array([[330.0, 0.0, 322.0], [0.0, 330.4, 238.0], [0.0, 0.0, 1.0]])
    lens = CameraModel(640, 480, "plumb_bob", np.array([-0.05, 0.02, 0.0005, 0.0, 0.0]), K, np.eye(3), np.zeros((3, 4)))
    camera = dataclasses.replace(hidden.simulator.camera, rate=3.0)
    hidden = dataclasses.replace(hidden, lens=lens, simulator=dataclasses.replace(hidden.simulator, camera=camera))
    commands = ("sheets", "lens", "mount", "teach")
    row = commission_at(hidden, Job(CONFIG, tmp_path, 2, 1, True), SHORT, commands)
    assert row["failed"] is None, row["why"]
    assert row["docked"], row["dockings"]
    x, y, heading = row["dockings"][0]["off"]
    assert math.hypot(x, y) < 0.010 and abs(heading) < math.radians(1.0)
    # What the commands were told was wrong by 20 mm, 3 deg and 2 %. So few images leave the mount uncertain by 5 mm
    # (1 sd), which teaching takes along.
    assert row["errors"]["dock"]["marker"] < 0.016 and row["errors"]["dock"]["size"] < 0.003
    assert abs(row["errors"]["lens"]["focal"]) < 0.004
    said = (tmp_path / "2" / "said.txt").read_text()
    assert said.count("\nNext: ") >= 5 and said.count("[0]") == said.count("$ ")
    assert (tmp_path / "2" / "installation" / "dock.yaml").read_text().count("# Taught: ") == 1


def test_bars_are_read_again_when_the_program_asks_for_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Seed 1012 reads the first time, by the errors of a ruler, a stretched print."""
    from seater_tools.commissioning.technician import StepError, Technician

    given: list[tuple[str, ...]] = []

    def run(_: Technician, package: str, program: str, *words: str | Path, more: bool = False) -> bool:
        if "--measured-bar" in words:
            given.append(tuple(map(str, words[-2:])))
            try:
                printed_scale([float(word) for word in given[-1]], PAPER)
            except ParameterError as error:
                raise StepError(str(error)) from error
        return True

    monkeypatch.setattr(Technician, "_run", run)
    hidden = draw_hidden(CONFIG, 1012)
    Technician(hidden, CONFIG, tmp_path / "a").sheets()
    assert given[0] == ("191.5", "192.6") and len(given) == 2
    stretched = dataclasses.replace(hidden, bars=(hidden.bars[0],) * 3)
    with pytest.raises(StepError, match="stretched"):
        Technician(stretched, CONFIG, tmp_path / "b").sheets()


def test_the_photographer_takes_the_views_that_the_guide_asks_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Seed 2004: the lower right corner of the image was asked for three times, and views were taken anywhere."""
    from seater_tools.commissioning import photographs

    hidden = draw_hidden(CONFIG, 2004)
    size, taken = (hidden.lens.width, hidden.lens.height), list[View]()

    def see(_: object, pose: np.ndarray, drawn: object, number: int) -> np.ndarray:
        corners = cv2.Rodrigues(pose[:3])[0] @ Board().points().T + pose[3:, None]
        pixels = hidden.lens.project(corners.T)
        inside = np.all((pixels > 0.0) & (pixels < np.array(size) - 1.0), axis=1)
        assert inside.sum() >= FEWEST_CORNERS
        taken.append(View(str(number), np.flatnonzero(inside), pixels[inside]))
        return np.zeros((2, 2), np.uint8)

    monkeypatch.setattr(photographs, "render", see)
    monkeypatch.setattr(photographs, "rays_of", lambda lens: None)
    monkeypatch.setattr(photographs, "FEWEST", 0)  # none that nobody has asked for
    photographer = photographs.Photographer(hidden.lens, tmp_path, 2004)
    photographer.taken = 1  # the views that everybody begins with are behind
    missing = missing_views([], Board(), size, hidden.lens)
    assert len(missing) == 14
    for words in missing:
        taken.clear()
        photographer.take(f"  missing: {words}")
        assert words not in missing_views(taken, Board(), size, hidden.lens) or "more views" in words


def test_a_failure_says_why_and_misses_the_bar(tmp_path: Path) -> None:
    docking = {"off": [0.002, -0.001, 0.001], "result": "SUCCESS", "text": "docked", "docked": True}
    row = {"seed": 1, "plant": "indoor_chair", "failed": None, "why": "", "notes": {}, "docked": True, "errors": {}}
    row |= {"minutes": 45.0, "driving_s": {"mount": 93.0}, "dockings": [docking]}
    refused = row | {"failed": "mount", "why": "first\nturn on the spot", "docked": False, "dockings": []}
    silent = row | {"docked": False, "dockings": [docking | {"docked": False}]}
    assert all(bar.met for bar in bars([row] * 29 + [refused]))
    assert [bar.met for bar in bars([row] * 28 + [refused] * 2)] == [False, True, True]
    assert [bar.met for bar in bars([row] * 29 + [silent])] == [True, False, True]
    assert [bar.met for bar in bars([row] * 29 + [row | {"minutes": 61.0}])] == [True, True, False]
    assert end_of(refused) == "mount: turn on the spot"
    assert "2.2" in table([row, refused]) and "turn on the spot" in table([refused])
    assert draw([row, refused], tmp_path / "a.png").stat().st_size > 10_000
