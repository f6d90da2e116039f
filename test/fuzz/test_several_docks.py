"""The docking node with two docks: which goals it takes, and when it loads them anew."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import yaml
from drive import Drive
from stand import CONFIG, Stand
from std_msgs.msg import Bool

from seater_msgs.msg import DockGoal, DockResult, DockState
from seater_nmpc.sequence.goal.results import ResultCode

RECOVERS = 4.0  # [s]
DOCKS = CONFIG.parent / "test" / "config" / "two_docks"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Of the two docks, for a test to change."""
    return Path(shutil.copytree(DOCKS, tmp_path / "docks"))


@pytest.fixture
def stand(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Stand:
    """The configured dock is one of the folder's."""
    return Stand(monkeypatch, dock=yaml_of(folder / "lab.yaml"), docks=str(folder))


def yaml_of(file: Path) -> dict:

    return yaml.safe_load(file.read_text())


def refused(stand: Stand, **goal) -> tuple[int, str]:
    """Code and text of a goal that is not taken."""
    before = len(stand.results)
    stand.give("dock", DockGoal(**goal))
    assert len(stand.results) == before + 1
    return stand.results[-1].result_code, stand.results[-1].result_text


def test_a_goal_to_another_dock_replaces_the_one_that_drives(stand: Stand) -> None:
    drive = Drive(stand)
    assert drive.docks(RECOVERS)
    stand.give("dock", DockGoal(dock_id="hall"))
    assert stand.results[-1].result_code == DockResult.CANCELED and stand.active
    assert stand.sent["dock_in_use"][-1].name == "hall"
    drive.step()
    request = stand.sent["velocity_request"][-1].twist
    assert (request.linear.x, request.angular.z) == (0.0, 0.0)  # it has to see that dock first
    assert drive.docks(RECOVERS) and stand.node._core.dock.name == "hall"


def test_a_goal_that_is_refused_ends_the_one_that_drives(stand: Stand) -> None:
    """The client knows of it no longer, and could not cancel it."""
    drive = Drive(stand)
    assert drive.docks(RECOVERS)
    stand.give("dock", DockGoal(dock_id="attic"))
    before, last = stand.results[-2:]
    assert (before.result_code, last.result_code) == (DockResult.CANCELED, DockResult.DOCK_NOT_IN_DB)
    assert before.result_text == f"replaced by a goal that is refused: {last.result_text}" and not stand.active
    assert last.result_text == "no dock 'attic'; known are lab, hall"
    drive.step()
    request = stand.sent["velocity_request"][-1].twist
    assert (request.linear.x, request.angular.z) == (0.0, 0.0)
    assert drive.docks(RECOVERS)


def test_a_docked_chair_takes_no_goal_to_another_dock(stand: Stand) -> None:
    drive = Drive(stand)
    stand.deliver("charging_contact", Bool(True))
    drive.advance(0.5)
    assert stand.sent["dock_state"][-1].state == DockState.DOCKED
    stand.node._in_use.watch.reached(1000.5, docked=True)
    code, text = refused(stand, dock_id="hall")
    assert (code, text) == (DockResult.DOCKED_ELSEWHERE, "the chair stands docked at lab: undock first")
    stand.deliver("charging_contact", Bool(False))


def test_docks_are_not_loaded_while_a_goal_is_active(stand: Stand) -> None:
    drive = Drive(stand)
    assert drive.docks(RECOVERS)
    answer = stand.call("reload_docks")
    assert (answer.success, answer.message) == (False, "a goal to dock is active") and stand.active


def test_no_goal_begins_while_they_are_loaded(stand: Stand) -> None:
    Drive(stand)
    stand.node._dock_services.loading = True
    assert refused(stand) == (DockResult.BUSY, "the docks are being loaded")


def test_a_goal_right_after_a_changed_dock_was_loaded_is_taken(stand: Stand, folder: Path) -> None:
    drive = Drive(stand)
    lab = folder / "lab.yaml"
    lab.write_text(lab.read_text().replace("position: 0.010", "position: 0.011"))
    answer = stand.call("reload_docks")
    assert answer.success and stand.sent["dock_in_use"][-1].revision == 1
    assert drive.docks(RECOVERS)


def test_the_dock_in_use_may_go_unless_the_chair_is_in_it(stand: Stand, folder: Path) -> None:
    drive = Drive(stand)
    stand.give("dock", DockGoal(dock_id="hall"))
    assert drive.docks(RECOVERS)
    stand.node._abort(ResultCode.CANCELED, "the test ends")
    (folder / "hall.yaml").unlink()
    stand.node._in_use.watch.reached(1000.5, docked=True)
    answer = stand.call("reload_docks")
    assert answer.message == "hall is not among them, and the chair stands docked at hall: undock first"
    stand.node._in_use.watch.reached(1000.5, docked=False)
    assert stand.call("reload_docks").success
    assert stand.node._core.dock.name == stand.sent["dock_in_use"][-1].name == "lab"


def test_a_folder_with_a_mistake_changes_nothing(stand: Stand, folder: Path) -> None:
    drive = Drive(stand)
    (folder / "hall.yaml").write_text("{")
    answer = stand.call("reload_docks")
    assert not answer.success and "hall.yaml" in answer.message
    stand.give("dock", DockGoal(dock_id="hall"))
    assert drive.docks(RECOVERS)
