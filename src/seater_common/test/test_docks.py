"""Several docks: names, and prints by which images tell them apart."""

from pathlib import Path

import pytest

from seater_common.files.docks import DockDatabase, DockEntry, UnknownDockError, read_content, read_folder
from seater_common.geometry import Dock
from seater_common.params import ParameterError, as_mapping


def entry(name: str, *ids: int, source: str = "", dictionary: str = "DICT_4X4_50", **changes) -> DockEntry:
    markers = [{"id": i, "size": 0.1, "position": [0.9, 0.1 * i, 0.7], "normal_yaw": 3.14159} for i in ids]
    values = as_mapping(Dock()) | {"name": name, "markers": markers, "dictionary": dictionary} | changes
    return DockEntry.of(values, source or f"{name}.yaml")


def test_a_goal_names_a_dock_or_means_the_configured_one() -> None:
    docks = DockDatabase(entry("lab", 0), [entry("kitchen", 2), entry("hall", 1)])
    assert docks.names == ["lab", "hall", "kitchen"]
    assert docks.entry("hall").dock.markers[0].id == 1
    assert docks.entry("").dock.name == "lab"


def test_an_unknown_dock_is_answered_with_the_known_ones() -> None:
    docks = DockDatabase(entry("lab", 0), [entry("hall", 1)])
    with pytest.raises(UnknownDockError, match="no dock 'attic'; known are lab, hall"):
        docks.entry("attic")


def test_one_dock_is_a_database_whatever_its_markers() -> None:
    assert DockDatabase(entry("lab", 0, dictionary="of_another_machine")).names == ["lab"]


def test_the_content_is_the_dock_again_with_what_others_read() -> None:
    lab = entry("lab", 0, 4)
    assert read_content(lab.content, "content") == lab.dock
    for wrong in ("{", "name: lab"):
        with pytest.raises(ParameterError, match=r"lab\.yaml"):
            read_content(wrong, "lab.yaml")


@pytest.mark.parametrize(("mine", "others"), [("DICT_4X4_50", "DICT_4X4_50"), ("4X4_50", "DICT_4X4_1000")])
def test_docks_that_share_a_print_are_refused_and_both_keys_named(mine, others) -> None:
    """DICT_4X4_50 is the beginning of DICT_4X4_1000."""
    with pytest.raises(ParameterError) as refused:
        DockDatabase(entry("lab", 0, 3, dictionary=mine), [entry("hall", 7, 3, dictionary=others)])
    assert "hall.yaml/markers[1]/id: is 3" in str(refused.value) and "lab.yaml/markers[1]/id" in str(refused.value)


def test_the_same_id_of_another_family_is_another_print() -> None:
    docks = DockDatabase(entry("lab", 0), [entry("hall", 0, dictionary="DICT_5X5_50")])
    assert docks.names == ["lab", "hall"]


def test_a_family_or_an_id_that_is_not_known_is_named_with_its_file() -> None:
    with pytest.raises(ParameterError, match=r"hall.yaml/dictionary: is 'nothing'"):
        DockDatabase(entry("lab", 0), [entry("hall", 1, dictionary="nothing")])
    with pytest.raises(ParameterError, match=r"hall.yaml/markers: id 60"):
        DockDatabase(entry("lab", 0), [entry("hall", 60)])


def test_two_docks_of_one_name_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"b.yaml/name: is 'hall', which a.yaml/name is, too"):
        DockDatabase(entry("lab", 0), [entry("hall", 1, source="a.yaml"), entry("hall", 2, source="b.yaml")])


def test_a_file_of_the_folder_takes_the_place_of_the_configured_dock() -> None:
    """It is what was taught or edited last; the parameters are as old as the launch."""
    old, new = entry("lab", 0, source="~dock"), entry("lab", 5)
    docks = DockDatabase(old, [new])
    assert docks.entry("").source == "lab.yaml" and docks.replaced is old
    assert DockDatabase(old, [entry("lab", 0)]).replaced is None


def test_a_folder_holds_one_dock_a_file(tmp_path: Path) -> None:
    for name, marker in (("hall", 1), ("attic", 2)):
        (tmp_path / f"{name}.yaml").write_text(entry(name, marker).content)
    (tmp_path / "notes.txt").write_text("no dock")
    assert [e.dock.name for e in read_folder(tmp_path)] == ["attic", "hall"]


def test_every_wrong_file_of_a_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("name: a")
    (tmp_path / "b.yaml").write_text("{")
    with pytest.raises(ParameterError) as refused:
        read_folder(tmp_path)
    assert f"{tmp_path}/a.yaml/markers: is missing" in str(refused.value) and "b.yaml" in str(refused.value)


def test_a_folder_without_docks_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="must be a folder with at least one dock file"):
        read_folder(tmp_path / "nowhere")
