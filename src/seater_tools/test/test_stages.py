"""The tree of stages, and which of them is named first."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from seater_common.params import ParameterError
from seater_tools.stages.report import as_json, conclusion, describe
from seater_tools.stages.tree import ORDER, Entry, Level, first_failing, read_stages, sort, stage_of

FILE = Path(__file__).resolve().parents[3] / "config" / "diagnostics.yaml"
NODES = {"camera": "marker_detector", "detection": "marker_detector", "pose": "marker_detector", "gate": "safety_gate"}


SELDOM = ("obstacles", "inputs")  # not every chair has them


def everybody(**other: Entry) -> list[Entry]:
    """All stages in order, but those given by name."""
    names = [name for name in ORDER if name not in SELDOM]
    good = {name: Entry(f"{NODES.get(name, 'docking')}: {name}", Level.OK, "fine", 0.5) for name in names}
    return list((good | other).values())


def test_the_file_names_the_stages_in_their_order() -> None:
    assert tuple(stage.name for stage in read_stages(FILE)) == ORDER


def test_diagnostic_aggregator_bears_what_a_chair_has_not() -> None:
    """Without `discard_stale` it calls a stage of which it heard nothing stale, and the whole chair an error."""
    analyzers = yaml.safe_load(FILE.read_text())["analyzers"]
    assert {name for name, keys in analyzers.items() if keys.get("discard_stale")} == set(SELDOM)


def test_nothing_fails() -> None:
    heard = sort(read_stages(FILE), everybody())
    assert first_failing(heard) is None
    assert conclusion(heard) == "no stage fails"


def test_the_first_in_order_is_named_whoever_spoke_first() -> None:
    entries = everybody(
        camera=Entry("marker_detector: camera", Level.ERROR, "no image for 3 s: plugged in?"),
        base=Entry("docking: base", Level.ERROR, "no odometry"),
    )
    heard = sort(read_stages(FILE), reversed(entries))
    failing = first_failing(heard)
    assert failing is not None and failing.fails
    assert failing.stage.name == "camera"
    assert "marker_detector says: no image for 3 s: plugged in?" in conclusion(heard)


def test_an_error_comes_before_a_warning() -> None:
    entries = everybody(
        detection=Entry("docking: detection", Level.WARN, "late"),
        gate=Entry("safety_gate: gate", Level.ERROR, "fault"),
    )
    entries.append(Entry("marker_detector: detection", Level.OK, "fine"))
    failing = first_failing(sort(read_stages(FILE), entries))
    assert failing is not None and failing.stage.name == "gate"
    warned = first_failing(sort(read_stages(FILE), [e for e in entries if e.level is not Level.ERROR] + everybody()))
    assert warned is not None and not warned.fails
    assert warned.stage.name == "detection"


@pytest.mark.parametrize("age", [None, 7.0])
def test_a_node_that_is_silent_is_named(age: float | None) -> None:
    entries = [entry for entry in everybody() if not entry.name.endswith(": solver")]
    if age is not None:
        entries.append(Entry("docking: solver", Level.OK, "fine", age))
    failing = first_failing(sort(read_stages(FILE), entries))
    assert failing is not None and failing.stage.name == "solver"
    assert "does the node docking run?" in failing.text


def test_a_stage_that_nobody_knows_is_no_fault() -> None:
    heard = {one.stage.name: one for one in sort(read_stages(FILE), everybody())}
    assert (heard["obstacles"].level, heard["obstacles"].fails) == (Level.STALE, False)


def test_the_report_has_all_stages_and_their_values() -> None:
    solver = Entry("docking: solver", Level.WARN, "late", 0.1, (("solve time, median [ms]", "40"),))
    heard = sort(read_stages(FILE), everybody(solver=solver))
    text = describe(heard, values=True)
    assert "docking: solver: solve time, median [ms] = 40" in text
    content = json.loads(as_json(heard))
    assert [stage["name"] for stage in content["stages"]] == list(ORDER)
    assert (content["first"], content["fails"]) == ("solver", False)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{}", "analyzers: must be a mapping"),
        ("analyzers: {a: {path: a}}", "analyzers/a: needs path and contains"),
        ("analyzers: {a: {path: a, contains: [1]}}", "analyzers/a/contains: must be a text"),
        ("analyzers: {a: {path: a, contains: b, timeout: 0}}", "analyzers/a/timeout: is 0"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "file.yaml").write_text(text)
    with pytest.raises(ParameterError, match=said):
        read_stages(tmp_path / "file.yaml")


def test_entries_are_sorted_by_their_stage() -> None:
    names = ["plant: clock", "base: base", "safety_gate: gate", "camera: camera"]
    assert sorted(names, key=stage_of) == ["camera: camera", "safety_gate: gate", "base: base", "plant: clock"]
