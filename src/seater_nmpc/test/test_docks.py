"""The docks that a docking node knows: each with its core, loaded anew while it runs."""

from __future__ import annotations

from dataclasses import replace

import pytest

rospy = pytest.importorskip("rospy")
from seater_common.files.docks import DockDatabase, DockEntry, UnknownDockError, read_content  # noqa: E402
from seater_common.geometry import Dock, Marker  # noqa: E402
from seater_common.params import ParameterError, as_mapping  # noqa: E402
from seater_msgs.msg import MarkerDetectionArray  # noqa: E402
from seater_nmpc.ros.docks.library import Docks  # noqa: E402
from seater_nmpc.ros.docks.services import DockServices  # noqa: E402


def entry(name: str, marker: int, source: str = "file") -> DockEntry:
    return DockEntry.of(as_mapping(replace(Dock(), name=name, markers=[Marker(id=marker)])), source)


class Made:
    """Instead of a core: which dock it is for."""

    def __init__(self, made_for: DockEntry) -> None:
        self.dock = made_for.dock


class Folder:
    """What is read; a test changes it."""

    def __init__(self, *entries: DockEntry) -> None:
        self.entries = list(entries)

    def __call__(self) -> DockDatabase:
        return DockDatabase(self.entries[0], self.entries[1:])


def test_each_dock_has_a_core_and_the_configured_one_comes_without_a_name() -> None:
    docks = Docks(Folder(entry("lab", 0), entry("hall", 1)), Made)
    assert docks.core().dock.name == docks.core("lab").dock.name == "lab"
    assert docks.core("hall").dock.markers[0].id == 1
    with pytest.raises(UnknownDockError):
        docks.core("attic")


def test_a_dock_that_has_not_changed_keeps_what_its_core_has_learned() -> None:
    folder = Folder(entry("lab", 0), entry("hall", 1))
    docks = Docks(folder, Made)
    lab, hall = docks.core("lab"), docks.core("hall")
    folder.entries[1:] = [entry("hall", 5), entry("attic", 2)]
    docks.take(docks.load())
    assert docks.core("lab") is lab and docks.core("hall") is not hall
    assert docks.database.names == ["lab", "attic", "hall"]
    assert [docks.revision(name) for name in ("lab", "hall", "attic")] == [0, 1, 0]


def test_a_dock_that_comes_back_with_another_content_is_told_from_the_first() -> None:
    folder = Folder(entry("lab", 0), entry("hall", 1))
    docks = Docks(folder, Made)
    for others in ([], [entry("hall", 5)]):
        folder.entries[1:] = others
        docks.take(docks.load())
    assert docks.revision("hall") == 1


def test_a_file_that_replaces_the_configured_dock_is_told_from_what_others_began_with() -> None:
    assert Docks(Folder(entry("lab", 0, "~dock"), entry("lab", 7)), Made).revision("lab") == 1


def test_a_wrong_folder_changes_nothing() -> None:
    folder = Folder(entry("lab", 0), entry("hall", 1))
    docks = Docks(folder, Made)
    folder.entries[1] = entry("hall", 0)
    with pytest.raises(ParameterError, match="the same print"):
        docks.load()
    assert docks.core("hall").dock.markers[0].id == 1


class Told:
    """Instead of a publisher: what was sent."""

    def __init__(self) -> None:
        self.messages = []

    def publish(self, message) -> None:
        self.messages.append(message)


def services(monkeypatch, folder: Folder) -> tuple[DockServices, Told, Docks]:
    told = Told()
    monkeypatch.setattr(rospy, "Publisher", lambda *_, **__: told)
    docks = Docks(folder, Made)
    return DockServices(docks, lambda work: work()), told, docks


def test_everybody_is_told_the_dock_in_use(monkeypatch) -> None:
    speaker, told, docks = services(monkeypatch, Folder(entry("lab", 0), entry("hall", 1, "hall.yaml")))
    speaker.use("hall", rospy.Time(7))
    message = told.messages[-1]
    assert (message.name, message.revision, message.source, message.since.secs) == ("hall", 0, "hall.yaml", 7)
    assert read_content(message.content, "") == docks.core("hall").dock and message.known == ["lab", "hall"]
    docks.take(Docks(Folder(entry("lab", 0), entry("hall", 1), entry("attic", 2)), Made).load())
    speaker.tell_again()
    message = told.messages[-1]
    assert (message.name, message.since.secs, message.known) == ("hall", 7, ["lab", "attic", "hall"])


def test_detections_of_another_dock_are_not_used(monkeypatch) -> None:
    folder = Folder(entry("lab", 0), entry("hall", 1))
    speaker, _, docks = services(monkeypatch, folder)
    speaker.use("hall", rospy.Time())
    assert speaker.about(MarkerDetectionArray(dock_name="hall"))
    assert speaker.about(MarkerDetectionArray())  # of somebody who knows of one dock only
    assert not speaker.about(MarkerDetectionArray(dock_name="lab"))
    folder.entries[1] = entry("hall", 5)
    docks.take(docks.load())
    speaker.use("hall", rospy.Time())
    assert not speaker.about(MarkerDetectionArray(dock_name="hall"))  # as it was before
    assert speaker.about(MarkerDetectionArray(dock_name="hall", dock_revision=1))


def test_docks_are_not_loaded_anew_while_it_is_refused_or_when_they_are_wrong(monkeypatch) -> None:
    folder, taken = Folder(entry("lab", 0), entry("hall", 1)), []
    monkeypatch.setattr(rospy, "Service", lambda *_, **__: None)
    speaker, _, docks = services(monkeypatch, folder)
    refusals = ["a goal to dock is active", "", ""]
    speaker.offer(lambda: refusals.pop(0), lambda loaded: taken.append(loaded) or "")
    assert speaker._on_reload(None).message == "a goal to dock is active" and not speaker.loading
    folder.entries[1] = entry("hall", 0)
    answer = speaker._on_reload(None)
    assert not answer.success and answer.message.startswith("the docks stay as they were: wrong docks")
    assert not taken and not speaker.loading
    folder.entries[1] = entry("attic", 4)
    assert speaker._on_reload(None).success and taken[0].database.names == ["lab", "attic"]
    assert docks.database.names == ["lab", "hall"]  # until the worker takes them


def test_no_goal_begins_while_docks_are_loaded(monkeypatch) -> None:
    monkeypatch.setattr(rospy, "Service", lambda *_, **__: None)
    speaker, _, _ = services(monkeypatch, Folder(entry("lab", 0)))
    speaker.offer(lambda: "", lambda loaded: "")
    assert speaker._begin() == "" and speaker.loading
    assert speaker._begin() == "they are being loaded already"
