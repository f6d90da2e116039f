"""`seater repeat`: when a session goes on and when it ends, and what it says of the dockings."""

from __future__ import annotations

import argparse
import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
from as_typed import run as typed

from seater_nmpc.sequence.goal.results import ResultCode
from seater_tools.command import repeat
from seater_tools.repeat.session import MOST_FAILED, Docked, Session, Undocked
from seater_tools.repeat.statistics import repeatability


def docked(code: int = 0, x: float = 0.002, y: float = 0.0, heading: float = 0.0, **more: float) -> Docked:
    sd = {"position_sd": 0.0005, "heading_sd": 0.001} if code == 0 else {}
    return Docked(code=code, text="what it says", duration=15.0, x=x, y=y, heading=heading, **(sd | more))  # type: ignore[arg-type]


class Scripted:
    """Docks as it is told; `goals` is what was asked for."""

    def __init__(self, *ends: Docked, undocks: int = 0) -> None:
        self._ends, self._undocks = list(ends), undocks
        self.goals: list[str] = []

    def dock(self) -> Docked:
        self.goals.append("dock")
        if not self._ends:
            raise KeyboardInterrupt
        return self._ends.pop(0)

    def undock(self) -> Undocked:
        self.goals.append("undock")
        return Undocked(code=self._undocks, text="refused" if self._undocks else "done")


def dockings(chair: Scripted, wanted: int) -> tuple[int, str]:
    session = Session(chair, wanted)
    return len(list(session.run())), session.ended


def test_it_docks_and_undocks_and_stays_docked_at_the_end() -> None:
    chair = Scripted(docked(), docked(), docked())
    assert dockings(chair, 3) == (3, "all done")
    assert chair.goals == ["dock", "undock", "dock", "undock", "dock"]


def test_a_chair_that_stands_docked_undocks_first_which_does_not_count() -> None:
    chair = Scripted(docked(int(ResultCode.ALREADY_DOCKED)), docked(), docked())
    assert dockings(chair, 2) == (2, "all done")
    assert chair.goals == ["dock", "undock", "dock", "undock", "dock"]


@pytest.mark.parametrize("code", [c for c in ResultCode if c not in (0, 1)])
def test_who_may_try_again(code: ResultCode) -> None:
    """A docking that missed is followed by another one; whatever a person or the gate has stopped is not."""
    again = code.name in (
        *("FAILED_TO_STAGE", "FAILED_TO_DETECT_DOCK", "FAILED_TO_CHARGE"),
        *("TIMEOUT", "MARKER_LOST", "NOT_WITHIN_TOLERANCE"),
    )
    chair = Scripted(docked(int(code)), docked())
    count, ended = dockings(chair, 2)
    assert count == (2 if again else 1)
    assert chair.goals == (["dock", "dock"] if again else ["dock"])
    assert ended == ("all done" if again else "somebody has to look first: what it says")


def test_it_ends_when_dockings_fail_in_a_row_or_it_cannot_leave() -> None:
    lost = docked(int(ResultCode.MARKER_LOST))
    assert dockings(Scripted(docked(), lost, docked(), *[lost] * 5), 9)[0] == 3 + MOST_FAILED
    assert dockings(Scripted(docked(), docked(), undocks=917), 3) == (1, "it did not undock: refused")


def test_accuracy_and_repeatability_of_known_places() -> None:
    """Four corners of a square of 2 mm, 3 mm ahead: AP 3 mm, all corners sqrt(2) mm from the mean, without spread."""
    found = repeatability([docked(x=0.003 + i, y=j, heading=h) for i, j, h in [
        (0.001, 0.001, 0.01), (-0.001, 0.001, -0.01), (0.001, -0.001, 0.01), (-0.001, -0.001, -0.03)]])  # fmt: skip
    assert found.accuracy == pytest.approx(0.003) and found.repeatability == pytest.approx(math.sqrt(2.0) * 0.001)
    assert found.x is not None and found.heading is not None
    assert found.x.mean == pytest.approx(0.003) and found.x.worst == pytest.approx(0.004)
    assert found.x.sd == pytest.approx(0.001 * math.sqrt(4.0 / 3.0)) and found.heading.worst == -0.03


def test_the_formula_on_many_dockings() -> None:
    """Distances from the mean of a normal law are Rayleigh distributed: mean 1.2533 sd, their sd 0.6551 sd."""
    rng = np.random.default_rng(1)
    places = 0.002 * rng.standard_normal((4000, 2))
    found = repeatability([docked(x=x, y=y) for x, y in places])
    assert found.repeatability == pytest.approx(0.002 * (1.2533 + 3.0 * 0.6551), rel=0.03)


def test_what_did_not_dock_or_was_not_verified_is_not_measured() -> None:
    found = repeatability([docked(), docked(int(ResultCode.TIMEOUT), x=5.0), docked(x=7.0, position_sd=0.0)])
    assert (found.dockings, found.docked, found.measured) == (3, 2, 1)
    assert found.accuracy == pytest.approx(0.002) and math.isnan(found.repeatability)
    nothing = repeatability([docked(int(ResultCode.TIMEOUT))])
    assert nothing.x is None and nothing.measured == 0


def options(folder: Path, times: int) -> argparse.Namespace:
    return argparse.Namespace(times=times, pause=0.0, results=folder)


def test_table_files_and_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ends = [docked(y=0.001), docked(int(ResultCode.MARKER_LOST)), docked(y=-0.001)]
    assert repeat.run(options(tmp_path, 3), Scripted(*ends), lambda _: None) == 1
    shown = capsys.readouterr().out
    assert "2 of 3: MARKER_LOST after 15.0 s" in shown and "2 of 3 docked" in shown
    with (tmp_path / "repeat.csv").open() as lines:
        assert [float(row["y"]) for row in csv.DictReader(lines)][::2] == [0.001, -0.001]
    assert json.loads((tmp_path / "repeat.json").read_text())["repeatability"]["docked"] == 2
    assert (tmp_path / "repeat.png").stat().st_size > 10000


def test_ctrl_c_reports_what_was_done(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert repeat.run(options(tmp_path, 9), Scripted(docked()), lambda _: None) == 130
    assert "the chair stands" in capsys.readouterr().out
    assert json.loads((tmp_path / "repeat.json").read_text())["ended"] == "interrupted"


@pytest.mark.parametrize(
    "words",
    [("repeat", "3"), ("teach",), ("calibrate", "camera", "--topic", "image", "--force"), ("doctor", "--stages")],
    ids=lambda words: words[0],
)
def test_without_a_ros_master_a_command_says_so_at_once(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("rospy")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:1")
    done = typed(*words)
    assert done.returncode == 2 and "no ROS master answers" in done.stderr and ".launch" in done.stderr


def test_a_wrong_number_of_dockings_is_refused() -> None:
    assert typed("repeat", "0").returncode == 2
