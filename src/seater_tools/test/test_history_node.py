"""The node that writes the history, without a ROS master: which dock a line is about."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

rospy = pytest.importorskip("rospy")
from seater_msgs.msg import DockActionGoal, DockActionResult, DockGoal, DockInUse  # noqa: E402
from seater_tools.ros.history import Recorder  # noqa: E402


class Node:
    """Hears what a test says."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
        self._hear: dict[str, Callable[[Any], None]] = {}
        self._file = folder / "history.csv"
        parameters = {"~file": self._file, "~dock_file": folder / "lab.yaml", "~dock/name": "lab"}
        monkeypatch.setattr(rospy, "get_param", parameters.__getitem__)
        monkeypatch.setattr(rospy, "on_shutdown", lambda work: None)
        monkeypatch.setattr(rospy, "Subscriber", lambda topic, _, hear, **__: self._hear.setdefault(topic, hear))
        self._recorder = Recorder()

    def dock(self, number: int, **goal: Any) -> None:
        """A goal that ends well."""
        given, ended = DockActionGoal(goal=DockGoal(**goal)), DockActionResult()
        given.goal_id.id = ended.status.goal_id.id = f"goal {number}"
        ended.result.success = True
        self._hear["dock/goal"](given)
        self._hear["dock/result"](ended)

    def use(self, name: str, source: str) -> None:
        self._hear["dock_in_use"](DockInUse(name=name, source=source))

    def docks(self) -> list[str]:
        """Of all lines; what waits is written."""
        self._recorder._write({})
        with self._file.open() as lines:
            return [row["dock"] for row in csv.DictReader(lines)]


def test_each_line_names_the_dock_in_use(monkeypatch, tmp_path) -> None:
    node = Node(monkeypatch, tmp_path)
    node.dock(1)  # of a docking node that does not say
    node.use("hall", str(tmp_path / "hall.yaml"))
    node.dock(2, dock_id="hall")
    node.use("lab", "/docking/dock")
    node.dock(3)
    assert node.docks() == ["lab", "hall", "lab"]


def test_a_goal_that_only_stages_is_no_docking(monkeypatch, tmp_path) -> None:
    node = Node(monkeypatch, tmp_path)
    node.dock(1, staging_only=True)
    node.dock(2)
    assert node.docks() == ["lab"]
